//! From a mission that was read to a fleet that is ready to run.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Mutex},
    time::Duration,
};

use orienteer_hardware::{
    driver::SonarDriver,
    drivers::{Lines, OpenBase, Site},
    nodes::{BaseNode, Guarded, NoSonar, SonarNode},
    remote::{RemoteHardware, fingerprint},
    sim::{Arena, ArenaClock},
};
use orienteer_runtime::{
    agent::{Behaviour, BuildError, Phase, RobotContext, Teammate},
    arbitration::{
        Arbitration, Client, Clients,
        sonar::{SafetyFloor, SonarArbiter},
    },
    clock::Epoch,
    config::{
        Mission, Problem, Problems, SourceId, Sources,
        mission::{ClockKind, HardwarePlace, MissionKeys, RecordKeys, RobotConfig, StartAt},
    },
    fleet::{Crowd, Environment, Leader, Still},
    geometry::Pose,
    host::{Factory, NodePlan, panic_text},
    link::{Backend, Bus, BusOptions},
    random::Streams,
    recording::{RobotInfo, Source, Track},
    robot::RobotPlan,
    robot_model::Ring,
    topics::{ClientId, Fingerprint},
};

use super::{
    Loaded, RunError, elsewhere,
    remarks::{self, Remark},
    world::{find_place, open_world},
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
    /// Learns when the mission's time begins.
    pub epoch: Epoch,
    /// The robot elsewhere whose hardware sets the beat, if any has hardware elsewhere: the first.
    pub leader: Option<Leader>,
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

/// Opens world and drivers and plans the fleet. Robots whose hardware is elsewhere get nodes that stand in for it.
///
/// # Errors
/// If something in the configuration does not work out, or links can't be made.
pub fn compose(loaded: Loaded, registry: &Registry, seed: u64) -> Result<Composed, RunError> {
    let Loaded { mission, mut sources, file } = loaded;
    let streams = Streams::new(seed);
    let arena = open_arena(&mission, &mut sources, streams)?;
    let settings = &mission.settings;
    let bus = Bus::open(settings.links, &BusOptions { run: settings.run.clone(), ..BusOptions::default() })?;
    let (epoch, lines) = (Epoch::default(), Lines::default());
    let (mut robots, mut remarks, mut leader) = (Vec::new(), Vec::new(), None);
    let team = team(&mission);
    let mut builder = RobotBuilder::new(registry, settings, arena.as_ref(), streams, &bus, (&epoch, &lines, &team));
    for (number, config) in mission.robots.iter().enumerate() {
        builder.number = number;
        let plan = match config.hardware {
            HardwarePlace::Here => builder.whole(config, &mut sources, &mut remarks)?,
            HardwarePlace::Elsewhere => {
                // Its drivers are asked what robot it is, and left alone. In this world there is no body of it.
                let scratch = open_arena(&mission, &mut sources, streams)?;
                let run = elsewhere::run(settings, config, &sources)?;
                leader.get_or_insert(Leader { run, robot: config.name.clone() });
                RobotBuilder { arena: scratch.as_ref(), ..builder }.without_hardware(config, &mut sources, &mut remarks)?
            }
        };
        robots.push(plan);
    }
    if let Some(crowd) = Crowd::find(&robots) {
        return Err(Problems::from(crowded(&crowd, &mission.robots[crowd.robot], &sources)).into());
    }
    if settings.links == Backend::Shared
        && let Some(text) = remarks::of_descriptors(&robots)
    {
        let robots = mission.robots.iter().map(|robot| robot.name.clone()).collect();
        remarks.push(Remark { robots, text, location: None });
    }
    let period = builder.period;
    let Mission { settings, record, .. } = mission;
    Ok(Composed { settings, record, robots, arena, period, epoch, leader, sources, file, remarks })
}

/// Plans a fleet of one robot's hardware and nothing else, for a mission in another process.
///
/// # Errors
/// If the mission has no such robot or says that its hardware is its own; otherwise as [`compose`].
pub fn compose_hardware(loaded: Loaded, registry: &Registry, seed: u64, robot: &str) -> Result<Composed, RunError> {
    let Loaded { mission, mut sources, file } = loaded;
    let streams = Streams::new(seed);
    let config = elsewhere::find(&mission, robot, &sources)?;
    let arena = open_arena(&mission, &mut sources, streams)?;
    let settings = &mission.settings;
    let run = elsewhere::run(settings, config, &sources)?;
    let bus = Bus::open(Backend::Shared, &BusOptions { run: Some(run), ..BusOptions::default() })?;
    let (epoch, lines, mut remarks) = (Epoch::default(), Lines::default(), Vec::new());
    let team = team(&mission);
    let builder = RobotBuilder::new(registry, settings, arena.as_ref(), streams, &bus, (&epoch, &lines, &team));
    let robots = vec![builder.hardware(config, &mut sources, &mut remarks)?];
    let period = builder.period;
    let Mission { settings, record, .. } = mission;
    Ok(Composed { settings, record, robots, arena, period, epoch, leader: None, sources, file, remarks })
}

fn open_arena(mission: &Mission, sources: &mut Sources, streams: Streams) -> Result<Option<Arc<Arena>>, Problems> {
    mission.world.as_ref().map(|world| open_world(world, sources, streams)).transpose()
}

fn crowded(Crowd { topic, most, .. }: &Crowd, robot: &RobotConfig, sources: &Sources) -> Problem {
    let message = format!("more than {most} robots tell each other `{topic}`");
    let hint = format!("at most {most} robots can hear each other: leave the agent out here, or make two missions of it");
    Problem::new(sources, &robot.span, message, hint)
}

/// All robots, as they know each other.
fn team(mission: &Mission) -> Arc<[Teammate]> {
    let mate = |robot: &RobotConfig| Teammate {
        name: Arc::from(robot.name.as_str()),
        agents: robot.agents.iter().map(|agent| agent.kind.clone()).collect(),
    };
    mission.robots.iter().map(mate).collect()
}

#[derive(Clone, Copy)]
struct RobotBuilder<'a> {
    registry: &'a Registry,
    settings: &'a MissionKeys,
    number: usize,
    arena: Option<&'a Arc<Arena>>,
    streams: Streams,
    period: Duration,
    wall: bool,
    bus: &'a Bus,
    epoch: &'a Epoch,
    lines: &'a Lines,
    team: &'a Arc<[Teammate]>,
}

/// A robot's devices, opened, and what every node has to know of the robot.
struct Opened {
    base: OpenBase,
    sonar: Box<dyn SonarDriver>,
    ring: Ring,
    context: RobotContext,
}

/// Nodes that every robot has come before its agents, arbitration comes after them.
pub(super) const BASE: u16 = 0;
pub(super) const SONAR: u16 = 1;
const FIRST_AGENT: u16 = 2;

/// Avoidance must hear every transducer as often as this, s, or as often as a slow ring can.
const EVERY_TRANSDUCER: f64 = 0.5;

impl<'a> RobotBuilder<'a> {
    fn new(
        registry: &'a Registry,
        settings: &'a MissionKeys,
        arena: Option<&'a Arc<Arena>>,
        streams: Streams,
        bus: &'a Bus,
        (epoch, lines, team): (&'a Epoch, &'a Lines, &'a Arc<[Teammate]>),
    ) -> Self {
        let period = Duration::from_secs_f64(1.0 / settings.control_rate_hz);
        let wall = settings.clock == ClockKind::Wall;
        Self { registry, settings, number: 0, arena, streams, period, wall, bus, epoch, lines, team }
    }

    /// A robot with all its nodes.
    fn whole(&self, config: &RobotConfig, sources: &mut Sources, noted: &mut Vec<Remark>) -> Result<RobotPlan, RunError> {
        let Opened { base, sonar, ring, context } = self.open(config, sources, noted)?;
        let mut nodes = vec![self.base_node(config, &context, base, &ring), self.sonar_node(&context, sonar)];
        nodes.extend(self.minds(config, &context, sources)?);
        self.plan(config, &ring, nodes)
    }

    /// A robot whose base and sonar live in another process.
    fn without_hardware(
        &self,
        config: &RobotConfig,
        sources: &mut Sources,
        noted: &mut Vec<Remark>,
    ) -> Result<RobotPlan, RunError> {
        let opened = self.open(config, sources, noted)?;
        let hardware = RemoteHardware {
            run: elsewhere::run(self.settings, config, sources)?,
            robot: config.name.clone(),
            epoch: self.epoch.clone(),
            fingerprint: self.fingerprint(config, &opened),
            has_line: self.has_line(config),
        };
        let Opened { ring, context, .. } = opened;
        let mut nodes = elsewhere::stand_ins(hardware, |client| self.of_node(&context, client));
        nodes.extend(self.minds(config, &context, sources)?);
        self.plan(config, &ring, nodes)
    }

    /// Base and sonar, for a mission in another process.
    fn hardware(&self, config: &RobotConfig, sources: &mut Sources, noted: &mut Vec<Remark>) -> Result<RobotPlan, RunError> {
        let opened = self.open(config, sources, noted)?;
        let presence = elsewhere::presence(&opened.context, self.epoch, self.fingerprint(config, &opened));
        let Opened { base, sonar, ring, context } = opened;
        let nodes = vec![self.base_node(config, &context, base, &ring), self.sonar_node(&context, sonar), presence];
        let plan = self.plan(config, &ring, nodes)?;
        Ok(RobotPlan { answered_within: Some(self.period / 2), ..plan })
    }

    fn fingerprint(&self, config: &RobotConfig, opened: &Opened) -> Fingerprint {
        let Opened { base: OpenBase { driver, motion, protection, .. }, ring, .. } = opened;
        fingerprint(&config.base.name, driver.platform(), ring, motion, protection, self.period)
    }

    fn open(&self, config: &RobotConfig, sources: &mut Sources, noted: &mut Vec<Remark>) -> Result<Opened, RunError> {
        let (base, sonar, noted_by_drivers) = self.open_devices(config, sources)?;
        for remark in &noted_by_drivers {
            Remark::note(noted, &config.name, remark.location(), format!("{}; {}", remark.message(), remark.hint()));
        }
        let sonar = sonar.unwrap_or_else(|| Box::new(NoSonar::default()));
        let ring = sonar.ring().clone();
        if let Some(flaw) = remarks::flaw(&base, &ring) {
            let hint = "the driver says so; correct it, or the values that it takes from here";
            return Err(Problems::from(Problem::new(sources, &config.span, flaw, hint)).into());
        }
        if let Some(text) = remarks::of_sight(&base, &ring, self.period) {
            Remark::note(noted, &config.name, None, text);
        }
        let context = self.context(config, &base, &ring);
        Ok(Opened { base, sonar, ring, context })
    }

    /// Agents and arbitration.
    fn minds(&self, config: &RobotConfig, context: &RobotContext, sources: &mut Sources) -> Result<Vec<NodePlan>, Problems> {
        let mut nodes = Vec::new();
        for (i, agent) in config.agents.iter().enumerate() {
            nodes.push(self.agent_node(context, ClientId(FIRST_AGENT + i as u16), agent, sources)?);
        }
        nodes.push(self.arbitration_node(config, context, FIRST_AGENT + nodes.len() as u16, sources)?);
        Ok(nodes)
    }

    fn plan(&self, config: &RobotConfig, ring: &Ring, nodes: Vec<NodePlan>) -> Result<RobotPlan, RunError> {
        let name: Arc<str> = Arc::from(config.name.as_str());
        let track = Track::new(self.number, &name, (!ring.transducers.is_empty()).then_some(ring));
        Ok(RobotPlan { bus: self.bus.robot(&name)?, track, nodes, name, answered_within: None })
    }

    fn open_devices(
        &self,
        config: &RobotConfig,
        sources: &mut Sources,
    ) -> Result<(OpenBase, Option<Box<dyn SonarDriver>>, Vec<Problem>), Problems> {
        let start = self.start(config, sources)?;
        let mut site = Site {
            robot: &config.name,
            start,
            arena: self.arena,
            period: self.period,
            streams: self.streams,
            span: config.base.span.clone(),
            keys: config.base.section.clone(),
            start_span: config.start.as_ref().map(|start| start.span.clone()),
            sources,
            shared: None,
            lines: self.lines,
            remarks: Vec::new(),
        };
        let drivers = self.registry.drivers();
        let unknown =
            |site: &Site<'_>, name: &str| site.problem(format!("there is no driver `{name}`"), "see `orienteer list drivers`");
        let base = match drivers.base(&config.base.name) {
            Some(kind) if kind.real_time && !self.wall => return Err(needs_wall_clock(&site, kind.name)),
            Some(kind) => kind.open(&config.base.section, &mut site)?,
            None => return Err(unknown(&site, &config.base.name)),
        };
        let Some(sonar) = &config.sonar else { return Ok((base, None, site.remarks)) };
        site.span = sonar.span.clone();
        let sonar = match drivers.sonar(&sonar.name) {
            Some(kind) if kind.real_time && !self.wall => return Err(needs_wall_clock(&site, kind.name)),
            Some(kind) => kind.open(&sonar.section, &mut site)?,
            None => return Err(unknown(&site, &sonar.name)),
        };
        Ok((base, Some(sonar), site.remarks))
    }

    fn start(&self, config: &RobotConfig, sources: &Sources) -> Result<Option<Pose>, Problems> {
        let Some(start) = &config.start else { return Ok(None) };
        let pose = match &start.at {
            StartAt::Pose(pose) => *pose,
            StartAt::Place { name, heading } => {
                let place = find_place(self.arena.map(|arena| &**arena), name)
                    .map_err(|(message, hint)| Problem::new(sources, &start.span, message, hint))?;
                Pose { heading: heading.unwrap_or(place.heading), ..place }
            }
        };
        Ok(Some(Pose::new(pose.x + start.offset.0, pose.y + start.offset.1, pose.heading)))
    }

    fn context(&self, config: &RobotConfig, base: &OpenBase, ring: &Ring) -> RobotContext {
        let device = |name: &str| Client { name: name.to_owned(), priority: 0 };
        let mut clients = vec![device("base"), device("sonar")];
        clients.extend(config.agents.iter().map(|agent| Client { name: agent.name.clone(), priority: agent.priority }));
        clients.push(device("arbitration"));
        RobotContext {
            robot: Arc::from(config.name.as_str()),
            node: Arc::from(""),
            client: ClientId::NONE,
            clients: Arc::new(Clients::new(clients)),
            platform: Arc::new(base.driver.platform().clone()),
            ring: Arc::new(ring.clone()),
            team: self.team.clone(),
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

    fn has_line(&self, config: &RobotConfig) -> bool {
        self.registry.drivers().base(&config.base.name).is_some_and(|kind| kind.has_line)
    }

    fn base_node(&self, config: &RobotConfig, context: &RobotContext, base: OpenBase, ring: &Ring) -> NodePlan {
        let OpenBase { driver, motion, protection, .. } = base;
        let (ring, period, wall, robot) = (ring.clone(), self.period, self.wall, context.robot.to_string());
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
            wiring: BaseNode::wiring(self.has_line(config)),
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
        sources: &mut Sources,
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

    fn arbitration_node(
        &self,
        config: &RobotConfig,
        context: &RobotContext,
        client: u16,
        sources: &Sources,
    ) -> Result<NodePlan, Problems> {
        let floor = SafetyFloor::under_all(&context.ring, EVERY_TRANSDUCER).map_err(|error| {
            let at = config.sonar.as_ref().map_or(&config.span, |sonar| &sonar.span);
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
pub(super) fn once<B: Behaviour>(begin: impl FnOnce() -> Result<B, BuildError> + Send + 'static) -> Factory {
    let begin = Mutex::new(Some(begin));
    Box::new(move |_| {
        let begin = begin.lock().ok().and_then(|mut begin| begin.take());
        match begin {
            Some(begin) => Ok(Box::new(begin()?)),
            None => Err(BuildError::for_good("its device can't be opened a second time")),
        }
    })
}
