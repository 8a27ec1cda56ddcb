//! Who drives, who listens, and why.
//!
//! A robot has one base and one sonar ring, and many behaviours that want them. The arbiters of this module decide: pure
//! functions of what the clients claim and of the time they are told, with no clock, thread or link of their own.
//!
//! * [`base`]: transactions, strict preemption, queue, hanging on, notices, limits.
//! * [`sonar`]: firing programs, with a [`floor`](sonar::SafetyFloor) that nobody can take away.
//! * [`client`]: the other side, what a behaviour calls.
//! * [`explain`]: a decision as a sentence.
//! * [`Arbitration`]: both arbiters as a node of a robot.
//!
//! # The rule
//!
//! Every client that has an open transaction has a [`Standing`]. The base belongs to the first in line, and the line is
//! ordered by two things only: **priority**, higher first, then **arrival**, earlier first (in one step, the order of the
//! clients in the configuration). That single order says all of the protocol of Randazza (1989), §3:
//!
//! * *strictly higher priority preempts*: it goes to the front at once; an equal arrives later, so it doesn't;
//! * *equals wait in order*;
//! * *an overridden owner that hangs on gets the base back when the overrider yields*: it arrived before every equal that
//!   waits, or it would not have been granted, so no memory of the override is needed to put it first.
//!
//! # Claims are states
//!
//! What a client says is what it wants now, whole. An arbiter looks at the newest claim of each client when it decides, and
//! at nothing else: how many claims came before, or were lost, makes no difference. Silence is release, because a claim lapses.
//! The answers are states too: the decision is published in every step, and a client that goes on naming a transaction
//! that is over is told so again.
//!
//! An arbiter believes what it is told; [`Arbitration`] does not. A claim holds for [`lease`] at most, and was made no later than now,
//! whatever it says: one that a client could make last would outlive the client.

pub mod base;
pub mod client;
mod clients;
pub mod explain;
mod node;
#[doc(hidden)]
pub mod oracle;
pub mod sonar;
mod standing;

use std::time::Duration;

pub use clients::{Client, Clients};
pub use node::Arbitration;
pub use standing::{Standing, rank, rule};

/// How long a claim holds unless renewed: two control periods and a bit, so that one late step does not stop the robot.
#[must_use]
pub fn lease(period: Duration) -> Duration {
    period.mul_f64(2.5)
}
