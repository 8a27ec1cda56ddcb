//! The kinds that a mission may name.

use orienteer_agents::{
    Avoidance, CorridorFollower, FeatureDetector, Geographer, MapperAgent, Patrol, PlaceClassifier, Wander, WhereAmI,
};
use orienteer_hardware::{
    base::presets,
    drivers::Drivers,
    rings,
    wire::{arcos, oi},
};
use orienteer_runtime::{
    agent::Agent,
    agents::Agents,
    config::mission::{AgentInfo, Catalog, DriverInfo},
};

/// Everything that a configuration may name: kinds of agents, drivers, platforms, rings.
///
/// ```
/// use orienteer::Registry;
/// let registry = Registry::standard();
/// assert!(registry.agents().kind("avoidance").is_some());
/// assert!(registry.drivers().base("sim").is_some());
/// ```
pub struct Registry {
    agents: Agents,
    drivers: Drivers,
}

impl Registry {
    /// What comes with Orienteer.
    #[must_use]
    pub fn standard() -> Self {
        let mut agents = Agents::default();
        agents
            .add::<WhereAmI>()
            .add::<Avoidance>()
            .add::<CorridorFollower>()
            .add::<FeatureDetector>()
            .add::<PlaceClassifier>()
            .add::<Geographer>()
            .add::<Patrol>()
            .add::<Wander>()
            .add::<MapperAgent>();
        Self { agents, drivers: Drivers::standard() }
    }

    /// Adds a kind of agent.
    #[must_use]
    pub fn with_agent<A: Agent>(mut self) -> Self {
        self.agents.add::<A>();
        self
    }

    /// Adds a kind of base driver.
    #[must_use]
    pub fn with_base<K: orienteer_hardware::drivers::BaseKind>(mut self) -> Self {
        self.drivers.add_base::<K>();
        self
    }

    /// Adds a kind of sonar driver.
    #[must_use]
    pub fn with_sonar<K: orienteer_hardware::drivers::SonarKind>(mut self) -> Self {
        self.drivers.add_sonar::<K>();
        self
    }

    /// The kinds of agents.
    #[must_use]
    pub fn agents(&self) -> &Agents {
        &self.agents
    }

    /// The drivers.
    #[must_use]
    pub fn drivers(&self) -> &Drivers {
        &self.drivers
    }
}

impl Catalog for Registry {
    fn agent(&self, kind: &str) -> Option<&AgentInfo> {
        self.agents.kind(kind).map(|kind| &kind.info)
    }

    fn agent_kinds(&self) -> Vec<String> {
        self.agents.kinds().iter().map(|kind| kind.name.to_owned()).collect()
    }

    fn base_driver(&self, name: &str) -> Option<&DriverInfo> {
        self.drivers.base(name).map(|kind| &kind.info)
    }

    fn base_drivers(&self) -> Vec<String> {
        self.drivers.bases().iter().map(|kind| kind.name.to_owned()).collect()
    }

    fn sonar_driver(&self, name: &str) -> Option<&DriverInfo> {
        self.drivers.sonar(name).map(|kind| &kind.info)
    }

    fn sonar_drivers(&self) -> Vec<String> {
        self.drivers.sonars().iter().map(|kind| kind.name.to_owned()).collect()
    }

    fn names(&self, sort: &str) -> Vec<String> {
        match sort {
            "platform" => presets::all().map(|preset| preset.name).collect(),
            "arcos-model" => arcos::units::MODELS.iter().map(|units| units.model.to_owned()).collect(),
            "create-model" => oi::units::MODELS.iter().map(|model| model.name.to_owned()).collect(),
            "ring" => rings::all().map(|named| named.ring.name).collect(),
            _ => Vec::new(),
        }
    }
}
