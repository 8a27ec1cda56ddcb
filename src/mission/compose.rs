//! From a mission that was read to a fleet that is ready to run.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Mutex},
    time::Duration,
};

use orienteer_hardware::{
    driver::SonarDriver,
    drivers::{OpenBase, Site},
    nodes::{BaseNode, Guarded, NoSonar, SonarNode},
    sim::{Arena, ArenaClock},
};
use orienteer_runtime::{
    agent::{Behaviour, BuildError, Phase, RobotContext},
    arbitration::{
        Arbitration, Client, Clients,
        sonar::{SafetyFloor, SonarArbiter},
    },
    config::{
        Problem, Problems, SourceId, Sources,
        mission::{ClockKind, MissionKeys, RecordKeys, RobotConfig, StartAt},
    },
    fleet::{Environment, Still},
    geometry::Pose,
    host::{Factory, NodePlan, panic_text},
    link::{Bus, BusOptions},
    random::Streams,
    recording::{RobotInfo, Source, Track},
    robot::RobotPlan,
    robot_model::Ring,
    topics::ClientId,
};

use super::{
    Loaded, RunError,
    remarks::{self, Remark},
    world::open_world,
};
use crate::Registry;

/// A fleet that is ready to run.
pub struct Composed {
    /// `[mission]`.
    pub settings: MissionKeys,
    /// `[record]`.
    pub record: RecordKeys,
    /// The robots.
    pub robots: Vec<RobotPlan>,
    /// The simulated world, if there is one.
    pub arena: Option<Arc<Arena>>,
    /// The control period.
    pub period: Duration,
    /// All files that it was read from.
    pub sources: Sources,
    /// The mission's own among them.
    file: SourceId,
    /// What a person should know before anything moves.
    pub remarks: Vec<Remark>,
}

impl Composed {
    /// What moves by itself around the robots.
    #[must_use]
    pub fn environment(&self) -> Box<dyn Environment> {
        match &self.arena {
            Some(arena) => Box::new(ArenaClock::new(arena.clone())),
            None => Box::new(Still),
        }
    }

    /// All files that it was read from, as the recording keeps them: the mission's own first.
    #[must_use]
    pub fn recorded_sources(&self) -> Vec<Source> {
        let main = self.sources.name(self.file);
        let mut files = self.sources.files();
        files.sort_by_key(|(name, _)| *name != main);
        files.into_iter().map(|(name, bytes)| Source { name: name.to_owned(), bytes: bytes.to_vec() }).collect()
    }

    /// Names of robots and their nodes, as the recording keeps them.
    #[must_use]
    pub fn robot_infos(&self) -> Vec<RobotInfo> {
        let info = |robot: &RobotPlan| RobotInfo::new(&robot.name, robot.nodes.iter().map(|node| node.context.node.to_string()));
        self.robots.iter().map(info).collect()
    }
}

/// Opens world and drivers and plans the fleet.
///
/// # Errors
/// If something in the configuration does not work out, or links can't be made.
pub fn compose(loaded: Loaded, registry: &Registry, seed: u64) -> Result<Composed, RunError> {
    let Loaded { mission, mut sources, file } = loaded;
    let streams = Streams::new(seed);
    let period = Duration::from_secs_f64(1.0 / mission.settings.control_rate_hz);
    let arena = match &mission.world {
        Some(world) => Some(open_world(world, &mut sources, streams)?),
        None => None,
    };
    let bus = Bus::open(mission.settings.links, &BusOptions { run: mission.settings.run.clone(), ..BusOptions::default() })?;
    let wall = mission.settings.clock == ClockKind::Wall;
    let (mut robots, mut remarks) = (Vec::new(), Vec::new());
    for (number, config) in mission.robots.iter().enumerate() {
        let builder = RobotBuilder { registry, config, number, arena: arena.as_ref(), streams, period, wall, bus: &bus };
        robots.push(builder.build(&mut sources, &mut remarks)?);
    }
    Ok(Composed { settings: mission.settings, record: mission.record, robots, arena, period, sources, file, remarks })
}

struct RobotBuilder<'a> {
    registry: &'a Registry,
    config: &'a RobotConfig,
    number: usize,
    arena: Option<&'a Arc<Arena>>,
    streams: Streams,
    period: Duration,
    wall: bool,
    bus: &'a Bus,
}

/// Nodes that every robot has come before its agents, arbitration comes after them.
const BASE: u16 = 0;
const SONAR: u16 = 1;
const FIRST_AGENT: u16 = 2;

/// Avoidance must hear every transducer as often as this, s, or as often as a slow ring can.
const EVERY_TRANSDUCER: f64 = 0.5;

impl RobotBuilder<'_> {
    fn build(&self, sources: &mut Sources, noted: &mut Vec<Remark>) -> Result<RobotPlan, RunError> {
        let (base, sonar) = self.open_devices(sources)?;
        let sonar = sonar.unwrap_or_else(|| Box::new(NoSonar::default()));
        let ring = sonar.ring().clone();
        if let Some(flaw) = remarks::flaw(&base, &ring) {
            let hint = "the driver says so; correct it, or the values that it takes from here";
            return Err(Problems::from(Problem::new(sources, &self.config.span, flaw, hint)).into());
        }
        if let Some(text) = remarks::of_sight(&base, &ring, self.period) {
            Remark::note(noted, &self.config.name, text);
        }
        let context = self.context(&base, &ring);
        let mut nodes = vec![self.base_node(&context, base, &ring)];
        nodes.push(self.sonar_node(&context, sonar));
        for (i, agent) in self.config.agents.iter().enumerate() {
            let client = ClientId(FIRST_AGENT + i as u16);
            nodes.push(self.agent_node(&context, client, agent, sources)?);
        }
        nodes.push(self.arbitration_node(&context, nodes.len() as u16, sources)?);
        let name: Arc<str> = Arc::from(self.config.name.as_str());
        let track = Track::new(self.number, &name, (!ring.transducers.is_empty()).then_some(&ring));
        Ok(RobotPlan { bus: self.bus.robot(&name)?, track, nodes, name })
    }

    fn open_devices(&self, sources: &mut Sources) -> Result<(OpenBase, Option<Box<dyn SonarDriver>>), Problems> {
        let start = self.start(sources)?;
        let mut site = Site {
            robot: &self.config.name,
            start,
            arena: self.arena,
            period: self.period,
            streams: self.streams,
            span: self.config.base.span.clone(),
            start_span: self.config.start.as_ref().map(|start| start.span.clone()),
            sources,
            shared: None,
        };
        let drivers = self.registry.drivers();
        let unknown =
            |site: &Site<'_>, name: &str| site.problem(format!("there is no driver `{name}`"), "see `orienteer list drivers`");
        let base = match drivers.base(&self.config.base.name) {
            Some(kind) if kind.real_time && !self.wall => return Err(needs_wall_clock(&site, kind.name)),
            Some(kind) => kind.open(&self.config.base.section, &mut site)?,
            None => return Err(unknown(&site, &self.config.base.name)),
        };
        let Some(sonar) = &self.config.sonar else { return Ok((base, None)) };
        site.span = sonar.span.clone();
        let sonar = match drivers.sonar(&sonar.name) {
            Some(kind) if kind.real_time && !self.wall => return Err(needs_wall_clock(&site, kind.name)),
            Some(kind) => kind.open(&sonar.section, &mut site)?,
            None => return Err(unknown(&site, &sonar.name)),
        };
        Ok((base, Some(sonar)))
    }

    fn start(&self, sources: &Sources) -> Result<Option<Pose>, Problems> {
        let Some(start) = &self.config.start else { return Ok(None) };
        let pose = match &start.at {
            StartAt::Pose(pose) => *pose,
            StartAt::Place { name, heading } => {
                let place = self.arena.and_then(|arena| arena.world().place(name));
                let Some(place) = place else {
                    let places = self.arena.map(|arena| arena.world().places.iter().map(|place| place.name.as_str()));
                    let known = places.map(|names| names.collect::<Vec<_>>().join(", ")).unwrap_or_default();
                    let hint =
                        if known.is_empty() { "the world names no places".to_owned() } else { format!("there are: {known}") };
                    return Err(
                        Problem::new(sources, &start.span, format!("there is no place `{name}` in the world"), hint).into()
                    );
                };
                Pose { heading: heading.unwrap_or(place.heading), ..place }
            }
        };
        Ok(Some(Pose::new(pose.x + start.offset.0, pose.y + start.offset.1, pose.heading)))
    }

    fn context(&self, base: &OpenBase, ring: &Ring) -> RobotContext {
        let device = |name: &str| Client { name: name.to_owned(), priority: 0 };
        let mut clients = vec![device("base"), device("sonar")];
        clients.extend(self.config.agents.iter().map(|agent| Client { name: agent.name.clone(), priority: agent.priority }));
        clients.push(device("arbitration"));
        RobotContext {
            robot: Arc::from(self.config.name.as_str()),
            node: Arc::from(""),
            client: ClientId::NONE,
            clients: Arc::new(Clients::new(clients)),
            platform: Arc::new(base.driver.platform().clone()),
            ring: Arc::new(ring.clone()),
            start: base.start,
            period: self.period,
            streams: self.streams,
        }
    }

    /// The context of one node.
    fn of_node(&self, context: &RobotContext, client: u16) -> RobotContext {
        let client = ClientId(client);
        let name = context.clients.get(client).map_or("", |client| client.name.as_str());
        RobotContext { node: Arc::from(name), client, ..context.clone() }
    }

    fn base_node(&self, context: &RobotContext, base: OpenBase, ring: &Ring) -> NodePlan {
        let OpenBase { driver, motion, protection, .. } = base;
        let (ring, period, wall, robot) = (ring.clone(), self.period, self.wall, self.config.name.clone());
        let begin = move || {
            if !wall {
                return Ok(BaseNode::new(driver, &ring, motion, protection, period));
            }
            let guarded = Guarded::new(driver, &robot, period).map_err(|error| BuildError::for_good(error.to_string()))?;
            let guard = guarded.guard();
            Ok(BaseNode::new(Box::new(guarded), &ring, motion, protection, period).guarded_by(guard))
        };
        NodePlan {
            context: self.of_node(context, BASE),
            phases: vec![Phase::Sense, Phase::Act],
            wiring: BaseNode::wiring(),
            claims: false,
            deadline: self.period,
            factory: once(begin),
        }
    }

    fn sonar_node(&self, context: &RobotContext, sonar: Box<dyn SonarDriver>) -> NodePlan {
        NodePlan {
            context: self.of_node(context, SONAR),
            phases: vec![Phase::Sense],
            wiring: SonarNode::wiring(),
            claims: false,
            deadline: self.period,
            factory: once(move || Ok(SonarNode::new(sonar))),
        }
    }

    fn agent_node(
        &self,
        context: &RobotContext,
        client: ClientId,
        agent: &orienteer_runtime::config::mission::AgentConfig,
        sources: &Sources,
    ) -> Result<NodePlan, Problems> {
        let Some(kind) = self.registry.agents().kind(&agent.kind) else {
            let message = format!("there is no kind of agent `{}`", agent.kind);
            return Err(Problem::new(sources, &agent.span, message, "see `orienteer list agents`").into());
        };
        let factory = kind.prepare(&agent.section, sources)?;
        let context = self.of_node(context, client.0);
        // Build it once for the sake of its errors, which can be told here with their place.
        if let Err(error) = rehearse(&factory, &context) {
            let message = format!("`{}` can't be built: {error}", agent.name);
            return Err(
                Problem::new(sources, &agent.span, message, "correct its parameters, or give the robot what it needs").into()
            );
        }
        Ok(NodePlan {
            context,
            phases: vec![kind.phase],
            wiring: kind.wiring.clone(),
            claims: kind.claims,
            deadline: agent.deadline.map_or(self.period, Duration::from_secs_f64),
            factory,
        })
    }

    fn arbitration_node(&self, context: &RobotContext, client: u16, sources: &Sources) -> Result<NodePlan, Problems> {
        let floor = SafetyFloor::under_all(&context.ring, EVERY_TRANSDUCER).map_err(|error| {
            let at = self.config.sonar.as_ref().map_or(&self.config.span, |sonar| &sonar.span);
            let message = format!("the sonar can't keep the robot safe: {error}");
            Problem::new(sources, at, message, "its driver gives the ring; correct it, or choose another")
        })?;
        Ok(NodePlan {
            context: self.of_node(context, client),
            phases: vec![Phase::Arbitrate],
            wiring: Arbitration::wiring(),
            claims: false,
            deadline: self.period,
            factory: Box::new(move |robot| {
                let sonar = SonarArbiter::new(&robot.clients, &robot.ring, floor.clone());
                Ok(Box::new(Arbitration::new(&robot.clients, sonar, robot.period)))
            }),
        })
    }
}

/// Builds a behaviour and drops it again.
fn rehearse(factory: &Factory, context: &RobotContext) -> Result<(), BuildError> {
    let panicked = |panic: Box<dyn Any + Send>| BuildError::for_good(format!("it panicked: {}", panic_text(panic.as_ref())));
    catch_unwind(AssertUnwindSafe(|| factory(context).map(drop))).map_err(panicked)?
}

fn needs_wall_clock(site: &Site<'_>, driver: &str) -> Problems {
    let message = format!("the driver `{driver}` is for a real device, but the mission does not run on real time");
    site.problem(message, "set `clock = \"wall\"` in `[mission]`, and give no `speed`")
}

/// Begins with a device when its robot comes to life, and not before: a mission that is only checked leaves devices alone. A device
/// can be opened only once: after a panic it can't be built anew, and its base stands.
fn once<B: Behaviour>(begin: impl FnOnce() -> Result<B, BuildError> + Send + 'static) -> Factory {
    let begin = Mutex::new(Some(begin));
    Box::new(move |_| {
        let begin = begin.lock().ok().and_then(|mut begin| begin.take());
        match begin {
            Some(begin) => Ok(Box::new(begin()?)),
            None => Err(BuildError::for_good("its device can't be opened a second time")),
        }
    })
}
