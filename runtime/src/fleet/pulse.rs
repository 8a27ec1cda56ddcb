//! How a fleet learns that one of its actors has died.

use actix::{Message, Recipient};

/// An actor has died of a panic.
#[derive(Debug, Message)]
#[rtype(result = "()")]
pub(crate) struct Died {
    pub who: String,
}

/// Held by every actor of a fleet. Whoever waits for an actor that panicked would wait for ever; so its pulse, which goes down
/// with it, tells the conductor.
pub(crate) struct Pulse {
    who: String,
    conductor: Recipient<Died>,
}

impl Pulse {
    pub(crate) fn new(who: impl Into<String>, conductor: Recipient<Died>) -> Self {
        Self { who: who.into(), conductor }
    }

    /// The pulse of another actor of the same fleet.
    pub(crate) fn of(&self, who: impl Into<String>) -> Self {
        Self::new(who, self.conductor.clone())
    }
}

impl Drop for Pulse {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.conductor.do_send(Died { who: std::mem::take(&mut self.who) });
        }
    }
}
