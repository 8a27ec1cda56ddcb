//! A simulated robot that speaks the language of a real one, in a world of its own and at the pace of a clock on the wall.
//!
//! Drivers, ours or other people's, find it at a port, as they would find the robot. See [`hardware::emulator`](crate::hardware::emulator).

use std::{ops::ControlFlow, path::PathBuf, time::Duration};

use crate::{
    hardware::{
        base::{kinematics::BaseConfig, odometry::OdometryConfig, presets},
        emulator::{self, ArcosEmulator, Caller, CreateEmulator, Emulator, Make, Port, Rig},
        rings::{self, NamedRing},
        sim::{Arena, SimBase, SimBodyConfig, SimSonar},
        wire::{arcos::units::Units, oi::units::Model},
    },
    mission::{embedded_files, find_place, open_world},
    runtime::{
        config::{
            Problem, Problems, Sources,
            mission::{WorldConfig, WorldKind},
        },
        fleet::FleetControl,
        geometry::Pose,
        random::Streams,
        time::Time,
        topics::Truth,
    },
};

/// What is emulated, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The world's file: Orienteer's own TOML, or a map of the ROS map server; the office floor if there is none.
    pub world: Option<PathBuf>,
    /// The robot, one of [`ROBOTS`].
    pub robot: String,
    /// The model that it is or says it is, which fixes its units; the newest of its kind if there is none.
    pub model: Option<String>,
    /// Where it stands.
    pub start: Start,
    /// Seed of its noise, and of the people around.
    pub seed: u64,
}

/// Where an emulated robot stands.
#[derive(Debug, Clone, PartialEq)]
pub enum Start {
    /// At the world's first place, or at its origin.
    Anywhere,
    /// At a place with a name.
    Place(String),
    /// Here, in the world's frame.
    Pose(Pose),
}

/// A robot that can be emulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Robot {
    /// Its name, which is that of its platform.
    pub name: &'static str,
    /// The language that it speaks.
    pub language: Language,
    /// Its ring, if it has one.
    ring: Option<&'static str>,
    /// Its model unless another is asked for.
    model: &'static str,
}

/// The language that a robot speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// Pioneers and AmigoBots do.
    Arcos,
    /// iRobot's Open Interface: Creates and Roombas do.
    Create,
}

impl Language {
    /// Where its robots are found unless somebody wants them elsewhere. Each language has a port of its own: two emulators run side by side.
    #[must_use]
    pub fn usual_port(self) -> &'static str {
        match self {
            Self::Arcos => "tcp://127.0.0.1:8101",
            Self::Create => "tcp://127.0.0.1:8102",
        }
    }
}

/// The robots that can be emulated; of each language the usual one first.
pub const ROBOTS: [Robot; 3] = [
    Robot { name: "p3dx", language: Language::Arcos, ring: Some("p3dx-16"), model: "p3dx-sh" },
    Robot { name: "amigobot", language: Language::Arcos, ring: Some("amigobot-8"), model: "amigo-sh" },
    Robot { name: "create2", language: Language::Create, ring: None, model: "create2" },
];

impl Robot {
    /// The robot of this name that speaks this language; the usual one without a name.
    #[must_use]
    pub fn find(language: Language, name: Option<&str>) -> Option<Self> {
        let mut robots = ROBOTS.into_iter().filter(|robot| robot.language == language);
        robots.find(|robot| name.is_none_or(|name| name == robot.name))
    }
}

/// An emulated robot of whatever family in its world.
pub type EmulatedRobot = Rig<Box<dyn Emulator>>;

/// Puts the robot into its world.
///
/// # Errors
/// If there is no such robot or world, or the robot does not fit where it is to stand.
pub fn build(options: &Options) -> Result<EmulatedRobot, Problems> {
    let (emulator, body, ring) = choose(options)?;
    let arena = open_arena(options)?;
    let start = place(&options.start, &arena)?;
    let refuse = |message: String| Problem::nowhere(message, "name another place with `--start`");
    let config = SimBodyConfig { base: body.clone(), odometry: OdometryConfig::default() };
    let robot = arena.add(&options.robot, start, config).map_err(|error| refuse(error.to_string()))?;
    let listen = |ring: NamedRing| SimSonar::new(arena.clone(), &options.robot, robot.clone(), ring.ring, &ring.model);
    let sonar = ring.map(listen).transpose().map_err(|error| refuse(error.to_string()))?;
    Ok(Rig::new(emulator, arena, SimBase::new(robot, body.platform()), sonar))
}

/// The other end of its language, its body, and its ring if it has one.
type Parts = (Box<dyn Emulator>, BaseConfig, Option<NamedRing>);

fn choose(options: &Options) -> Result<Parts, Problems> {
    let Some(robot) = ROBOTS.iter().find(|robot| robot.name == options.robot) else {
        let known = ROBOTS.map(|robot| format!("`{}`", robot.name)).join(", ");
        return Err(
            Problem::nowhere(format!("there is no robot `{}` to emulate", options.robot), format!("there are {known}")).into()
        );
    };
    let model = options.model.as_deref().unwrap_or(robot.model);
    let ring = robot.ring.and_then(rings::find);
    let parts: Option<Parts> = match robot.language {
        Language::Arcos => Units::of(model).zip(presets::by_name(robot.name)).map(|(units, body)| {
            let transducers = ring.as_ref().map_or(0, |ring| ring.ring.transducers.len());
            let emulator: Box<dyn Emulator> = Box::new(ArcosEmulator::new(Make::new(units, &body, transducers)));
            (emulator, body, ring)
        }),
        Language::Create => Model::of(model).map(|model| {
            let emulator: Box<dyn Emulator> = Box::new(CreateEmulator::new(model));
            (emulator, CreateEmulator::body(), None)
        }),
    };
    let hint = format!("leave `--model` out, or take for instance `{}`", robot.model);
    Ok(parts.ok_or_else(|| Problem::nowhere(format!("there is no model `{model}`"), hint))?)
}

fn open_arena(options: &Options) -> Result<std::sync::Arc<Arena>, Problems> {
    let (mut sources, source, path) = match &options.world {
        Some(path) => {
            let (sources, source) = Sources::open(path)?;
            (sources, source, path.display().to_string())
        }
        None => {
            let mut sources = Sources::embedded(embedded_files());
            let path = "worlds/office-floor.toml";
            let source = sources.read(path)?;
            (sources, source, path.to_owned())
        }
    };
    let is_map = options.world.as_ref().and_then(|path| path.extension()).is_some_and(|end| end == "yaml" || end == "yml");
    let kind = if is_map { WorldKind::Map } else { WorldKind::File };
    // A map is read by its name, which is relative to its own directory here.
    let path = if is_map { sources.name(source).to_owned() } else { path };
    let config = WorldConfig { kind, path, source, span: sources.start_of(source) };
    open_world(&config, &mut sources, Streams::new(options.seed))
}

fn place(start: &Start, arena: &Arena) -> Result<Pose, Problems> {
    match start {
        Start::Anywhere => Ok(arena.world().places.first().map_or_else(Pose::default, |place| place.pose)),
        Start::Pose(pose) => Ok(*pose),
        Start::Place(name) => Ok(find_place(Some(arena), name).map_err(|(message, hint)| Problem::nowhere(message, hint))?),
    }
}

/// How the robot stands, after each beat.
#[derive(Clone, Copy)]
pub struct Beat<'a> {
    /// Time since the start.
    pub now: Time,
    /// Who is at the port.
    pub caller: Caller,
    /// Where the robot truly is.
    pub truth: &'a Truth,
    /// The emulator.
    pub emulator: &'a dyn Emulator,
}

/// Lets the robot live until somebody stops it or the time is over, at the pace of a clock on the wall.
pub fn live(
    rig: &mut EmulatedRobot,
    port: &mut Port,
    duration: Option<Duration>,
    control: &FleetControl,
    mut watch: impl FnMut(Beat<'_>),
) {
    emulator::live(rig, port, |rig, caller| {
        watch(Beat { now: rig.now(), caller, truth: &rig.truth(), emulator: rig.emulator() });
        let over = duration.is_some_and(|duration| rig.now().since(Time::START) >= duration);
        if over || control.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
}
