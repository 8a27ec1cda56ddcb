//! Somebody beside the line to a device that has no watchdog.
//!
//! Most bases stop by themselves when nobody speaks to them. Some go on for ever with the last speed that they were told, and a program
//! that is killed tells them nothing more. A [`Minder`] listens to what goes to such a device, and when nothing has come for too long it
//! says stop in the client's stead, again and again.
//!
//! It only helps if it outlives the client, so it lives in a process of its own, which holds the device's end of the line:
//!
//! ```text
//! client ══ socket ══▶ minder's process ══ serial port, TCP ══▶ device
//!        ◀════════════                  ◀══════════════════════
//! ```
//!
//! The client's [`Line`](super::Line) starts that process from the program that it runs in, which therefore begins with
//! [`mind_if_asked`]. When either process ends, the other notices at once: the minder stops the device and goes, the client opens its
//! line anew. A minder says ten times a second that it is well; one that is held up is killed, and the client stops the device itself.
//! Only whoever kills both in the same moment leaves a device that nobody minds; and only the device's end of a radio link could help
//! against that.

mod client;
mod order;
mod process;

use std::{thread, time::Duration};

use orienteer_runtime::time::Time;

use super::Stream;
pub(super) use client::open;
pub use process::mind_if_asked;

/// While the client is silent the device is told to stop so often.
const AGAIN: Duration = Duration::from_millis(100);
/// What has come from the device waits for no longer than this.
const LOOK: Duration = Duration::from_millis(2);
/// The device is told so often to stop at the end, in case that something gets lost.
const FAREWELLS: u32 = 3;

/// What a minder has to know of a device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Minding {
    /// The bytes that stop the device, whatever it has been told before; also if that was cut off in the middle.
    pub stop: Vec<u8>,
    /// A client that says nothing for so long is as good as gone.
    pub silence: Duration,
}

/// Listens to a client, and knows when to stop the device in its stead.
///
/// ```
/// use std::time::Duration;
/// use orienteer_hardware::line::{Minder, Minding};
/// use orienteer_runtime::time::Time;
///
/// let after = |millis| Time::START + Duration::from_millis(millis);
/// let mut minder = Minder::new(Minding { stop: vec![0], silence: Duration::from_millis(250) });
/// minder.hear(after(0), b"drive");
/// assert_eq!(minder.due(after(200)), None);
/// assert_eq!(minder.due(after(251)), Some(&[0][..]));
/// ```
#[derive(Debug, Clone)]
pub struct Minder {
    minding: Minding,
    heard: Time,
    stopped: Option<Time>,
}

impl Minder {
    /// Begins to listen at [`Time::START`].
    #[must_use]
    pub fn new(minding: Minding) -> Self {
        Self { minding, heard: Time::START, stopped: None }
    }

    /// The client has sent this to the device.
    pub fn hear(&mut self, now: Time, bytes: &[u8]) {
        if !bytes.is_empty() {
            (self.heard, self.stopped) = (now, None);
        }
    }

    /// What is to be sent to the device now, if anything.
    pub fn due(&mut self, now: Time) -> Option<&[u8]> {
        let silent = now.since(self.heard) > self.minding.silence;
        if !silent || self.stopped.is_some_and(|stopped| now.since(stopped) < AGAIN) {
            return None;
        }
        self.stopped = Some(now);
        Some(&self.minding.stop)
    }
}

/// Says stop for the last time.
fn stop(device: &mut dyn Stream, minding: &Minding) {
    for _ in 0..FAREWELLS {
        let _ = device.write(&minding.stop);
        thread::sleep(AGAIN / 2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silent_client_is_spoken_for_until_it_speaks_again() {
        let mut minder = Minder::new(Minding { stop: vec![7], silence: Duration::from_millis(250) });
        let mut stops = Vec::new();
        for millis in 0..1000 {
            let now = Time::START + Duration::from_millis(millis);
            if millis % 200 == 0 && millis <= 400 {
                minder.hear(now, b"go");
            }
            if millis == 900 {
                minder.hear(now, b"");
            }
            if minder.due(now).is_some() {
                stops.push(millis);
            }
        }
        assert_eq!(stops, [651, 751, 851, 951]);
    }
}
