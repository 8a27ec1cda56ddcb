//! Emulators: simulated robots that speak the language of real ones, for drivers and for other people's programs.
//!
//! An [`Emulator`] is the base's end of a protocol, without any I/O: it gets the bytes that a client has sent, says what its motors do,
//! and answers with what they and the sonars have come to. A [`Rig`] puts it on a simulated body, and a [`Port`] lets a client in.
//!
//! ```text
//! client ══ port ══▶ emulator ──demand──▶ body in its world
//!        ◀═════════           ◀─odometry, scans──
//! ```

mod arcos;
mod create;
mod live;
mod port;
mod rig;

use orienteer_runtime::{
    geometry::Twist,
    time::Time,
    topics::{FiringProgram, Odometry, SonarScan},
};

use crate::wire::Counts;

pub use arcos::{ArcosEmulator, Make};
pub use create::CreateEmulator;
pub use live::{Wire, live};
pub use port::{Caller, Port, PortError};
pub use rig::Rig;

/// The base's end of a protocol.
pub trait Emulator: Send {
    /// Takes in bytes that a client has sent.
    fn receive(&mut self, now: Time, bytes: &[u8]);

    /// What the motors do from `now` on. Called a hundred times a second with where the base is.
    fn drive(&mut self, now: Time, odometry: &Odometry) -> Twist;

    /// Where the body touches something, robot frame, rad; `None` if it touches nothing. Called before [`drive`](Self::drive).
    fn feel(&mut self, _at: Option<f64>) {}

    /// In which order the sonars fire, if that has changed since the last call. A program without slots means the ring's own.
    fn firing(&mut self) -> Option<FiringProgram> {
        None
    }

    /// The sonars have heard something.
    fn hear(&mut self, _scan: &SonarScan) {}

    /// Appends what the base sends.
    fn transmit(&mut self, now: Time, odometry: &Odometry, into: &mut Vec<u8>);

    /// How its session stands, for people.
    fn status(&self) -> String;

    /// What came over the wire so far.
    fn counts(&self) -> Counts;
}

impl<E: Emulator + ?Sized> Emulator for Box<E> {
    fn receive(&mut self, now: Time, bytes: &[u8]) {
        (**self).receive(now, bytes);
    }

    fn feel(&mut self, at: Option<f64>) {
        (**self).feel(at);
    }

    fn drive(&mut self, now: Time, odometry: &Odometry) -> Twist {
        (**self).drive(now, odometry)
    }

    fn firing(&mut self) -> Option<FiringProgram> {
        (**self).firing()
    }

    fn hear(&mut self, scan: &SonarScan) {
        (**self).hear(scan);
    }

    fn transmit(&mut self, now: Time, odometry: &Odometry, into: &mut Vec<u8>) {
        (**self).transmit(now, odometry, into);
    }

    fn status(&self) -> String {
        (**self).status()
    }

    fn counts(&self) -> Counts {
        (**self).counts()
    }
}
