//! A robot's talk with another process in the middle of each step.
//!
//! Hardware in a process of its own senses, and the mission that decides is elsewhere. If each kept to its own beat, what was sensed
//! would wait for up to a period there, and what was decided for up to a period here. So the hardware rings when it has sensed,
//! and acts when the answer has come. An answer that does not come is not waited for: see [`Dialogue::ring`].

use std::time::Duration;

use crate::{
    clock::{Started, Stopwatch},
    link::{Bell, Doorbell, LinkError, RobotBus, Wake},
};

/// After so many answers that did not come nobody is waited for, until somebody rings again.
const FORLORN: u32 = 10;

/// Rings, and waits for an answer, once in each step.
pub(super) struct Dialogue {
    bell: Bell,
    /// Away while somebody waits at it.
    doorbell: Option<Doorbell>,
    patience: Duration,
    stopwatch: Stopwatch,
    started: Started,
    fruitless: u32,
    /// It has been held in this step.
    pub over: bool,
}

/// A wait for the answer.
pub(super) struct Listening {
    doorbell: Doorbell,
    patience: Duration,
}

impl Dialogue {
    /// Answers are waited for as long as `patience`. Must be called inside a tokio runtime.
    pub fn new(bus: &RobotBus, patience: Duration, stopwatch: Stopwatch) -> Result<Self, LinkError> {
        Ok(Self {
            bell: bus.bell()?,
            doorbell: Some(bus.doorbell()?),
            patience,
            stopwatch,
            started: stopwatch.start(),
            fruitless: 0,
            over: false,
        })
    }

    /// A step begins.
    pub fn begin(&mut self) {
        (self.started, self.over) = (self.stopwatch.start(), false);
    }

    /// Rings. What is to be waited for then; `None` if nobody has answered for a while.
    pub fn ring(&mut self) -> Option<Listening> {
        self.over = true;
        let mut doorbell = self.doorbell.take()?;
        // A late answer to the step before is none to this one; it only shows that there is somebody.
        if doorbell.forget() {
            self.fruitless = 0;
        }
        self.bell.ring();
        if self.fruitless >= FORLORN {
            self.doorbell = Some(doorbell);
            return None;
        }
        Some(Listening { doorbell, patience: self.patience })
    }

    /// The wait is over. Returns how old the step has become.
    pub fn end(&mut self, (doorbell, answered): (Doorbell, bool)) -> Duration {
        self.doorbell = Some(doorbell);
        self.fruitless = if answered { 0 } else { self.fruitless + 1 };
        self.started.elapsed().unwrap_or_default()
    }
}

impl Listening {
    /// Waits until somebody answers, or patience is over.
    pub async fn listen(mut self) -> (Doorbell, bool) {
        // A doorbell that no longer rings is as good as nobody at the door.
        let answered = tokio::time::timeout(self.patience, self.doorbell.wait()).await;
        let answered = matches!(answered, Ok(Ok(Wake::Rung)));
        (self.doorbell, answered)
    }
}
