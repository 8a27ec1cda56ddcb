//! How a client asks for the sonar, and what it hears of it.

use std::time::Duration;

use crate::{
    time::Time,
    topics::{ClientId, FiringProgram, SonarClaim, SonarDecision},
};

/// How a client stands with the sonar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SonarState {
    /// It does not ask for a program of its own.
    Free,
    /// It asks for a program that does not run yet.
    Waiting,
    /// Its program runs.
    Holding,
    /// Its program ran, and a higher priority took the sonar.
    Overridden {
        /// Whose program runs now.
        by: ClientId,
    },
}

/// A behaviour's hold on the sonar.
///
/// Scans come to everyone, whoever has the sonar; a program is only for a client that needs the ring to fire in another way
/// than it does by itself. It stands until another or [`release`](Self::release), and comes back after an override.
///
/// ```
/// # use std::time::Duration;
/// # use orienteer_runtime::{time::Time, topics::{ClientId, FiringProgram, SonarDecision}};
/// use orienteer_runtime::arbitration::client::{SonarHandle, SonarState};
///
/// let mut mapper = SonarHandle::new(ClientId(3));
/// let mut program = FiringProgram::default();
/// program.slots.push(0b11);
/// mapper.run(program);
/// assert_eq!(mapper.state(), SonarState::Waiting);
/// assert_eq!(mapper.claim(Time::START, Duration::from_millis(100)).program, program);
///
/// let mut decision = SonarDecision::default();
/// decision.holder = ClientId(3);
/// mapper.hear(&decision);
/// assert_eq!(mapper.state(), SonarState::Holding);
/// ```
#[derive(Debug, Clone)]
pub struct SonarHandle {
    client: ClientId,
    state: SonarState,
    program: FiringProgram,
}

impl SonarHandle {
    /// A handle for a client that has not asked for anything.
    #[must_use]
    pub fn new(client: ClientId) -> Self {
        Self { client, state: SonarState::Free, program: FiringProgram::default() }
    }

    /// Asks for a firing program, until another or [`release`](Self::release). A program without slots is a release.
    pub fn run(&mut self, program: FiringProgram) {
        self.program = program;
        if program.slots.is_empty() {
            self.release();
        } else if self.state == SonarState::Free {
            self.state = SonarState::Waiting;
        }
    }

    /// Gives the sonar back.
    pub fn release(&mut self) {
        (self.state, self.program) = (SonarState::Free, FiringProgram::default());
    }

    /// How the client stands, as far as it has heard.
    #[must_use]
    pub fn state(&self) -> SonarState {
        self.state
    }

    /// Takes in the newest decision.
    pub fn hear(&mut self, decision: &SonarDecision) {
        let mine = decision.holder == self.client;
        self.state = match (self.state, decision.holder.known()) {
            (SonarState::Free, _) => SonarState::Free,
            _ if mine => SonarState::Holding,
            (SonarState::Holding | SonarState::Overridden { .. }, Some(by)) => SonarState::Overridden { by },
            _ => SonarState::Waiting,
        };
    }

    /// The claim to publish at the end of the step at `now`; it lapses after `lease`.
    #[must_use]
    pub fn claim(&self, now: Time, lease: Duration) -> SonarClaim {
        SonarClaim { client: self.client, stamp: now, valid_until: now + lease, program: self.program }
    }
}
