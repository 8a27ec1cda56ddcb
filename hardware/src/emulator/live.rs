//! An emulated robot at the pace of a clock on the wall.

use std::{
    ops::ControlFlow,
    thread,
    time::{Duration, Instant},
};

use orienteer_runtime::time::Time;

use super::{Caller, Emulator, Port, Rig};

/// What is later than this is not made up for.
const LOST: Duration = Duration::from_millis(200);

/// What an emulated robot hangs on: a [`Port`], or one that somebody meddles with.
pub trait Wire {
    /// Appends what has come from the client, and says who it is.
    fn receive(&mut self, now: Time, into: &mut Vec<u8>) -> Caller;

    /// Sends these bytes to the client, if there is one.
    fn send(&mut self, bytes: &[u8]);
}

impl Wire for Port {
    fn receive(&mut self, now: Time, into: &mut Vec<u8>) -> Caller {
        Port::receive(self, now, into)
    }

    fn send(&mut self, bytes: &[u8]) {
        Port::send(self, bytes);
    }
}

/// Lets a robot live on this wire until `watch`, which sees it after each beat, breaks off.
///
/// The robot does not notice who comes and goes at the other end, as one on a serial line does not: a client that is gone is one that is
/// silent. A program that was halted for a while goes on where it was: its world has stood still meanwhile.
pub fn live<E: Emulator>(rig: &mut Rig<E>, wire: &mut impl Wire, mut watch: impl FnMut(&Rig<E>, Caller) -> ControlFlow<()>) {
    let (mut received, mut answer) = (Vec::new(), Vec::new());
    let mut due = Instant::now();
    loop {
        received.clear();
        answer.clear();
        let caller = wire.receive(rig.now(), &mut received);
        rig.beat(&received, &mut answer);
        wire.send(&answer);
        if watch(rig, caller).is_break() {
            return;
        }
        due += Rig::<E>::BEAT;
        if Instant::now().saturating_duration_since(due) > LOST {
            due = Instant::now();
        }
        thread::sleep(due.saturating_duration_since(Instant::now()));
    }
}
