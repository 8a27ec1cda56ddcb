//! What a mission may name: kinds of agents, drivers, rings, platforms.

use schemars::Schema;

use crate::topics::{BaseClaim, BaseDecision, BaseNotice, Payload, SonarClaim, SonarDecision};

/// A kind of agent, as far as its configuration matters.
#[derive(Debug, Clone)]
pub struct AgentInfo {
    /// The schema of its own keys. The common ones (`kind`, `priority`, `enabled`, `deadline_ms`) may not be among them.
    pub schema: Schema,
    /// One line of help.
    pub help: String,
    /// Topics it can't do without.
    pub reads: Vec<String>,
    /// Topics it writes, claims included.
    pub writes: Vec<String>,
    /// True if it may want to drive.
    pub takes_base: bool,
    /// Its priority if the configuration gives none.
    pub priority: u8,
}

impl AgentInfo {
    /// True if it asks for the base or the sonar, so that its priority means something.
    #[must_use]
    pub fn claims(&self) -> bool {
        self.takes_base || self.writes.iter().any(|topic| topic == BaseClaim::TOPIC || topic == SonarClaim::TOPIC)
    }
}

/// A driver of a base or a sonar, as far as its configuration matters.
#[derive(Debug, Clone)]
pub struct DriverInfo {
    /// The schema of its own keys. `driver` may not be among them.
    pub schema: Schema,
    /// One line of help.
    pub help: String,
    /// Topics that its actor writes.
    pub writes: Vec<String>,
    /// True if it is simulated: then the mission needs a world.
    pub needs_world: bool,
}

/// Knows everything that a mission may name. The answers may not change while a mission is read.
pub trait Catalog {
    /// A kind of agent.
    fn agent(&self, kind: &str) -> Option<&AgentInfo>;
    /// All kinds of agents, in the order in which people should see them.
    fn agent_kinds(&self) -> Vec<String>;
    /// A driver of a base.
    fn base_driver(&self, name: &str) -> Option<&DriverInfo>;
    /// All drivers of bases.
    fn base_drivers(&self) -> Vec<String>;
    /// A driver of a sonar.
    fn sonar_driver(&self, name: &str) -> Option<&DriverInfo>;
    /// All drivers of sonars.
    fn sonar_drivers(&self) -> Vec<String>;
    /// All names of a sort (`"ring"`, `"platform"`), for keys whose schema has `x-names`.
    fn names(&self, sort: &str) -> Vec<String>;
    /// Topics that every robot has without any agent, besides those of its drivers.
    fn always_written(&self) -> Vec<String> {
        [BaseDecision::TOPIC, BaseNotice::TOPIC, SonarDecision::TOPIC].map(str::to_owned).to_vec()
    }
    /// True if several agents of a robot may write the topic.
    fn many_writers(&self, topic: &str) -> bool {
        [BaseClaim::TOPIC, SonarClaim::TOPIC].contains(&topic)
    }
}
