//! Many robots, one clock.
//!
//! [`run`] brings a fleet to life, steps it to the end of its mission and returns what became of it. Robots are spread over
//! threads, each with an actix arbiter and a `Crew` that steps its robots one after the other; a robot is never split. The
//! `Conductor` starts a step on all crews, waits until all are through (the barrier), hands what they recorded to the
//! recorder in the order of the robots, and lets the [`Environment`] move on. So a robot sees the others as they stood at the
//! end of the previous step, and hears what they [told](crate::topics::TeamPayload) each other in it; neither the order of robots nor the number of threads can
//! show in a result.

mod conductor;
mod control;
mod crew;
mod exchange;
mod leader;
mod pulse;
mod signals;

use std::{cell::RefCell, ops::ControlFlow, rc::Rc, time::Duration};

pub use control::FleetControl;
pub use exchange::Crowd;
pub(crate) use exchange::{Exchange, Hearer as TeamHearer, Teller as TeamTeller, Word, hearer, teller};
pub use leader::Leader;
pub(crate) use pulse::{Died, Pulse};
pub use signals::{Ear, Signals, before_exit};

use crate::{
    clock::{Epoch, Pace},
    descriptors::{self, TooFewDescriptors},
    host::HostError,
    recording::{RecordError, Recorder, RecordingSummary},
    robot::{RobotPlan, RobotReport},
    time::Time,
};

/// Whatever surrounds the robots and moves by itself: the simulated world and its people.
pub trait Environment {
    /// Moves on to `now`. Called between two steps, when no robot is being stepped.
    fn advance(&mut self, now: Time);
}

/// A world in which nothing moves but the robots.
#[derive(Debug, Clone, Copy, Default)]
pub struct Still;

impl Environment for Still {
    fn advance(&mut self, _now: Time) {}
}

/// Watches a fleet from outside, between steps: progress bars, experiments.
pub trait Observer {
    /// Called after each step; `Break` ends the mission.
    fn after_step(&mut self, now: Time) -> ControlFlow<()>;
}

impl<F: FnMut(Time) -> ControlFlow<()>> Observer for F {
    fn after_step(&mut self, now: Time) -> ControlFlow<()> {
        self(now)
    }
}

/// A fleet as it is planned.
pub struct FleetPlan {
    /// Its robots. Their order is that of the recording.
    pub robots: Vec<RobotPlan>,
    /// What surrounds them.
    pub environment: Box<dyn Environment>,
    /// Time between two steps.
    pub period: Duration,
    /// When the mission ends; `None`: when it is told to, or all robots are done.
    pub duration: Option<Duration>,
    /// How time passes.
    pub pace: Pace,
    /// At wall time: who sets the beat, if it is not the clock.
    pub leader: Option<Leader>,
    /// Threads to spread the robots over; 1 runs everything on the caller's.
    pub threads: usize,
    /// Where the recording goes. Without one the robots' tracks are muted.
    pub recorder: Option<Recorder>,
    /// Lets others pause, step and stop the fleet.
    pub control: FleetControl,
    /// Learns when the mission's time begins.
    pub epoch: Epoch,
    /// Watches.
    pub observer: Box<dyn Observer>,
}

/// Why a mission ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// Its time was up.
    Complete,
    /// All robots said that they were done.
    AllDone,
    /// Somebody stopped it: Ctrl-C, [`FleetControl::stop`] or an [`Observer`].
    Stopped,
}

/// What became of a fleet.
#[derive(Debug)]
pub struct FleetReport {
    /// One report for each robot, in the order of the plan.
    pub robots: Vec<RobotReport>,
    /// The time of the last step.
    pub time: Time,
    /// Number of steps.
    pub steps: u64,
    /// Steps skipped because the machine was too slow. Always 0 in lockstep.
    pub missed: u64,
    /// Wall time from the first step to the last.
    pub elapsed: Duration,
    /// Why it ended.
    pub ended: Ended,
    /// The recording, if there was one and it could be written.
    pub recording: Option<Result<RecordingSummary, RecordError>>,
}

/// A fleet can't be brought to life.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// A robot can't.
    #[error(transparent)]
    Host(#[from] HostError),
    /// Its threads need more files than may be open.
    #[error(transparent)]
    Descriptors(#[from] TooFewDescriptors),
    /// A part of it died of a panic that nobody could catch.
    #[error("{who} panicked outside of its behaviour; the mission can't go on")]
    Died {
        /// Which part.
        who: String,
    },
    /// The actor system or a thread can't be started, or died.
    #[error("the actor system failed: {0}")]
    System(String),
}

/// Runs a fleet to the end of its mission, on the calling thread and `plan.threads - 1` others.
///
/// Ctrl-C, SIGTERM and SIGHUP end the mission in good order. A second one, a second later or more, ends the program at once with
/// exit code 130: a behaviour may never return.
///
/// # Errors
/// If a robot can't be brought to life; then none moves. If a part of the fleet dies that can't do without; then the bases of
/// the others stop.
pub fn run(plan: FleetPlan) -> Result<FleetReport, FleetError> {
    descriptors::check_room_for(plan.threads.min(plan.robots.len()))?;
    let outcome: Rc<RefCell<Option<Result<FleetReport, FleetError>>>> = Rc::default();
    let system = actix::System::new();
    let result = outcome.clone();
    system.block_on(async move {
        let report = conductor::conduct(plan).await;
        *result.borrow_mut() = Some(report);
    });
    outcome.take().unwrap_or_else(|| Err(FleetError::System("it ended without a report".to_string())))
}
