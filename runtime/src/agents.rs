//! The kinds of agents that a configuration may name.

use schemars::Schema;

use crate::{
    agent::{Agent, Behaviour, GRID, Need, Phase, Wiring},
    config::{Problems, Section, Sources, mission::AgentInfo, validate},
    host::Factory,
    topics::{BaseClaim, Payload, SonarClaim},
};

/// A set of kinds of agents, in the order in which people should see them.
///
/// ```
/// use orienteer_runtime::agent::{Agent, Behaviour, BuildError, Inputs, Outputs, RobotContext, Wiring};
/// use orienteer_runtime::{agents::Agents, time::Time};
///
/// struct Idler;
///
/// impl Behaviour for Idler {
///     fn step(&mut self, _now: Time, _inputs: &Inputs, _out: &mut Outputs) {}
/// }
///
/// impl Agent for Idler {
///     const KIND: &'static str = "idler";
///     const HELP: &'static str = "does nothing, with great care";
///     type Config = orienteer_runtime::agents::NoConfig;
///     fn topics(_wiring: &mut Wiring) {}
///     fn build(_config: Self::Config, _robot: &RobotContext) -> Result<Self, BuildError> { Ok(Self) }
/// }
///
/// let mut agents = Agents::default();
/// agents.add::<Idler>();
/// assert_eq!(agents.kind("idler").unwrap().info.help, "does nothing, with great care");
/// ```
#[derive(Debug, Default, Clone)]
pub struct Agents {
    kinds: Vec<AgentKind>,
}

/// One kind of agent.
#[derive(Debug, Clone)]
pub struct AgentKind {
    /// Its name in a configuration.
    pub name: &'static str,
    /// What the configuration has to know.
    pub info: AgentInfo,
    /// When it is stepped.
    pub phase: Phase,
    /// The topics that it reads and writes.
    pub wiring: Wiring,
    /// True if it may claim the base or the sonar.
    pub claims: bool,
    prepare: fn(&Section, &mut Sources) -> Result<Factory, Problems>,
}

/// The parameters of an agent that has none.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NoConfig {}

impl Agents {
    /// Adds a kind. One of the same name is replaced.
    pub fn add<A: Agent>(&mut self) -> &mut Self {
        let kind = AgentKind::of::<A>();
        match self.kinds.iter_mut().find(|other| other.name == kind.name) {
            Some(other) => *other = kind,
            None => self.kinds.push(kind),
        }
        self
    }

    /// The kind of this name.
    #[must_use]
    pub fn kind(&self, name: &str) -> Option<&AgentKind> {
        self.kinds.iter().find(|kind| kind.name == name)
    }

    /// All kinds.
    #[must_use]
    pub fn kinds(&self) -> &[AgentKind] {
        &self.kinds
    }
}

impl AgentKind {
    fn of<A: Agent>() -> Self {
        let mut wiring = Wiring::default();
        A::topics(&mut wiring);
        let names = |ports: &[crate::agent::Port], need: Option<Need>| {
            ports.iter().filter(|port| need.is_none_or(|need| port.need == need)).map(|port| port.topic.to_owned()).collect()
        };
        let mut writes: Vec<String> = names(wiring.write_ports(), None);
        if A::CLAIMS {
            writes.extend([BaseClaim::TOPIC.to_owned(), SonarClaim::TOPIC.to_owned()]);
        }
        if wiring.draws_a_map() {
            writes.push(GRID.to_owned());
        }
        let info = AgentInfo {
            schema: schema::<A>(),
            help: A::HELP.to_owned(),
            reads: names(wiring.read_ports(), Some(Need::Required)),
            writes,
            takes_base: A::CLAIMS,
            priority: A::PRIORITY,
        };
        Self { name: A::KIND, info, phase: A::PHASE, wiring, claims: A::CLAIMS, prepare: prepare::<A> }
    }

    /// What builds agents of this kind with these parameters.
    ///
    /// # Errors
    /// If the parameters do not fit the kind's schema, or there is something wrong with a file that they name.
    pub fn prepare(&self, parameters: &Section, sources: &mut Sources) -> Result<Factory, Problems> {
        (self.prepare)(parameters, sources)
    }
}

fn schema<A: Agent>() -> Schema {
    validate::schema_of::<A::Config>()
}

fn prepare<A: Agent>(parameters: &Section, sources: &mut Sources) -> Result<Factory, Problems> {
    let mut config: A::Config = validate::read(parameters, sources)?;
    A::read_files(&mut config, parameters, sources)?;
    Ok(Box::new(move |robot| A::build(config.clone(), robot).map(|agent| Box::new(agent) as Box<dyn Behaviour>)))
}
