//! What a behaviour is.
//!
//! A [`Behaviour`] is a plain state machine. Once per control period it is shown its [`Inputs`] and fills its [`Outputs`]; it
//! knows nothing of actors, clocks or shared memory, so a unit test can step it by hand. An [`Agent`] is a behaviour that can
//! be named in a configuration: it declares its parameters and the topics that it reads and writes.
//!
//! ```
//! use orienteer_runtime::agent::{Behaviour, Inputs, Outputs, Wiring};
//! use orienteer_runtime::{geometry::Twist, time::Time, topics::{Echo, SonarScan}};
//!
//! /// Drives on until something is nearer than half a metre, then turns.
//! struct Wander;
//!
//! impl Behaviour for Wander {
//!     fn step(&mut self, _now: Time, inputs: &Inputs, out: &mut Outputs) {
//!         let Some(scan) = inputs.latest::<SonarScan>() else { return };
//!         let blocked = matches!(scan.echo(0), Echo::Range(range) if range < 0.5);
//!         out.base.drive(if blocked { Twist::new(0.0, 0.5) } else { Twist::new(0.2, 0.0) });
//!     }
//! }
//!
//! let mut wiring = Wiring::default();
//! wiring.reads::<SonarScan>();
//! let (mut inputs, mut out) = (Inputs::offline(&wiring), Outputs::offline(&wiring));
//! inputs.put(SonarScan::from_echoes(Time::START, 1, &[Echo::Range(0.3)]));
//! Wander.step(Time::START, &inputs, &mut out);
//! let claim = out.base.claim(Time::START, std::time::Duration::from_millis(100));
//! assert_eq!(claim.motion, orienteer_runtime::topics::Motion::velocity(Twist::new(0.0, 0.5)));
//! ```
//!
//! Long manoeuvres are easier to read as an `async fn` over a [`Pilot`]; see [`Script`].

mod inputs;
mod outputs;
mod pilot;
mod script;
mod undeclared;
mod wiring;

use std::{sync::Arc, time::Duration};

use schemars::JsonSchema;
use serde::de::DeserializeOwned;

pub use inputs::Inputs;
pub(crate) use outputs::GRID;
pub use outputs::{Finish, LogLine, OutputFile, Outputs};
pub use pilot::{Aborted, Pilot, PoseHandle, Strategy};
pub use script::Script;
pub use tracing::Level;
pub(crate) use wiring::Tap;
pub use wiring::{Need, Port, Wiring};

use crate::{
    arbitration::Clients,
    config::{Problems, Section, Sources},
    geometry::Pose,
    random::Streams,
    robot_model::{Platform, Ring},
    time::Time,
    topics::ClientId,
};

/// When in a control period a node is stepped. The phases of a period follow each other in this order; within a phase the
/// order of the configuration holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// Devices publish what they measured.
    Sense,
    /// The robot works out where it is.
    Estimate,
    /// Behaviours claim the base and the sonar.
    Behave,
    /// Arbitration decides between them.
    Arbitrate,
    /// Devices carry the decision out.
    Act,
}

/// A plain state machine that is stepped once in each of its phases.
pub trait Behaviour: 'static {
    /// Looks at the inputs and fills the outputs. Must not block; a panic is caught by the host, which releases the base and
    /// builds the behaviour anew.
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs);

    /// Last words when the mission ends: figures for the summary and files to write.
    fn finish(&mut self, _now: Time, _last_words: &mut Finish) {}
}

/// A behaviour that a configuration can name.
pub trait Agent: Behaviour + Sized {
    /// The kind's name in a configuration, in kebab case.
    const KIND: &'static str;
    /// One line of help.
    const HELP: &'static str;
    /// The phase in which it is stepped.
    const PHASE: Phase = Phase::Behave;
    /// True if it may claim the base or the sonar.
    const CLAIMS: bool = true;
    /// Its priority unless the configuration says otherwise; larger wins.
    const PRIORITY: u8 = 5;
    /// Its parameters. Every field's doc comment reaches the JSON schema.
    type Config: DeserializeOwned + JsonSchema + Send + Sync + Clone + 'static;

    /// Declares the topics that it reads and writes.
    fn topics(wiring: &mut Wiring);

    /// Reads the files that the parameters name. They are kept in recordings, and their problems are told at their places.
    ///
    /// # Errors
    /// Whatever is wrong with them.
    fn read_files(_config: &mut Self::Config, _parameters: &Section, _sources: &mut Sources) -> Result<(), Problems> {
        Ok(())
    }

    /// Builds it for one robot. Also called to build it anew after a panic.
    ///
    /// # Errors
    /// If the parameters do not fit the robot, with a sentence for the person who wrote them.
    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError>;
}

/// Why an agent can't be built: a sentence for people, naming the parameter if there is one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct BuildError {
    /// What is wrong and how to mend it.
    pub message: String,
    /// True if it is no use to try again.
    pub for_good: bool,
}

impl BuildError {
    /// An error with this message.
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), for_good: false }
    }

    /// An error that will be the same each time, such as of a device that can be opened only once.
    #[must_use]
    pub fn for_good(message: impl Into<String>) -> Self {
        Self { message: message.into(), for_good: true }
    }
}

/// A robot of the same mission.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Teammate {
    /// Its name.
    pub name: Arc<str>,
    /// The kinds of its agents.
    pub agents: Vec<String>,
}

/// What a node knows of the robot that it runs on. Cheap to clone.
#[derive(Debug, Clone)]
pub struct RobotContext {
    /// The robot's name, unique in the mission.
    pub robot: Arc<str>,
    /// The node's own name, unique on the robot.
    pub node: Arc<str>,
    /// The node's place in the table of clients.
    pub client: ClientId,
    /// All nodes of the robot, with their priorities.
    pub clients: Arc<Clients>,
    /// The body.
    pub platform: Arc<Platform>,
    /// The sonar ring.
    pub ring: Arc<Ring>,
    /// All robots of the mission, in its order.
    pub team: Arc<[Teammate]>,
    /// Where the robot starts, map frame.
    pub start: Pose,
    /// Time between two steps.
    pub period: Duration,
    /// Source of random streams; see [`RobotContext::stream`].
    pub streams: Streams,
}

impl RobotContext {
    /// The random stream of this node for one purpose.
    #[must_use]
    pub fn stream(&self, purpose: &str) -> rand_pcg::Pcg64 {
        self.streams.stream(&self.robot, &format!("{}/{purpose}", self.node))
    }

    /// The robot's own place in its team.
    #[must_use]
    pub fn number(&self) -> u32 {
        self.team.iter().position(|mate| mate.name == self.robot).unwrap_or_default() as u32
    }

    /// How many other robots of the mission run an agent of this kind.
    #[must_use]
    pub fn mates_with(&self, kind: &str) -> usize {
        let others = self.team.iter().filter(|mate| mate.name != self.robot);
        others.filter(|mate| mate.agents.iter().any(|agent| agent == kind)).count()
    }

    /// The control period in seconds.
    #[must_use]
    pub fn period_secs(&self) -> f64 {
        self.period.as_secs_f64()
    }
}
