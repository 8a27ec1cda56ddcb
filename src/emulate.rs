//! A simulated robot that speaks the language of a real one, in a world of its own and at the pace of a clock on the wall.
//!
//! Drivers, ours or other people's, find it at a port, as they would find the robot. See [`hardware::emulator`](crate::hardware::emulator).

use std::{
    path::PathBuf,
    thread,
    time::{Duration, Instant},
};

use crate::{
    hardware::{
        base::{kinematics::BaseConfig, odometry::OdometryConfig, presets},
        emulator::{ArcosEmulator, Caller, Make, Port, Rig},
        rings::{self, NamedRing},
        sim::{Arena, SimBase, SimBodyConfig, SimSonar},
        wire::arcos::units::Units,
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
    /// The robot: `p3dx` or `amigobot`.
    pub robot: String,
    /// The model that it says it is, which fixes its units; the newest of its kind if there is none.
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

/// The robots that can be emulated: body, ring, and model unless another is asked for.
pub const ROBOTS: [(&str, &str, &str); 2] = [("p3dx", "p3dx-16", "p3dx-sh"), ("amigobot", "amigobot-8", "amigo-sh")];

/// Puts the robot into its world.
///
/// # Errors
/// If there is no such robot or world, or the robot does not fit where it is to stand.
pub fn build(options: &Options) -> Result<Rig<ArcosEmulator>, Problems> {
    let (body, ring, units) = choose(options)?;
    let arena = open_arena(options)?;
    let start = place(&options.start, &arena)?;
    let refuse = |message: String| Problem::nowhere(message, "name another place with `--start`");
    let config = SimBodyConfig { base: body.clone(), odometry: OdometryConfig::default() };
    let robot = arena.add(&options.robot, start, config).map_err(|error| refuse(error.to_string()))?;
    let make = Make::new(units, &body, ring.ring.transducers.len());
    let sonar = SimSonar::new(arena.clone(), &options.robot, robot.clone(), ring.ring, &ring.model)
        .map_err(|error| refuse(error.to_string()))?;
    Ok(Rig::new(ArcosEmulator::new(make), arena, SimBase::new(robot, body.platform()), sonar))
}

fn choose(options: &Options) -> Result<(BaseConfig, NamedRing, Units), Problems> {
    let known = ROBOTS.iter().find(|(name, ..)| *name == options.robot);
    let parts = known.and_then(|(body, ring, model)| {
        let units = Units::of(options.model.as_deref().unwrap_or(model));
        Some((presets::by_name(body)?, rings::find(ring)?, units))
    });
    match parts {
        None => {
            Err(Problem::nowhere(format!("there is no robot `{}` to emulate", options.robot), "`p3dx` and `amigobot` are").into())
        }
        Some((.., None)) => {
            let model = options.model.as_deref().unwrap_or_default();
            Err(Problem::nowhere(format!("there is no model `{model}`"), "leave `--model` out, or take for instance `p3dx`")
                .into())
        }
        Some((body, ring, Some(units))) => Ok((body, ring, units)),
    }
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
    pub emulator: &'a ArcosEmulator,
}

/// Lets the robot live until somebody stops it or the time is over, at the pace of a clock on the wall.
///
/// A program that was halted for a while goes on where it was: its world has stood still meanwhile.
pub fn live(
    rig: &mut Rig<ArcosEmulator>,
    port: &mut Port,
    duration: Option<Duration>,
    control: &FleetControl,
    mut watch: impl FnMut(Beat<'_>),
) {
    let (mut received, mut answer) = (Vec::new(), Vec::new());
    let mut due = Instant::now();
    while !control.is_stopped() && duration.is_none_or(|duration| rig.now().since(Time::START) < duration) {
        received.clear();
        answer.clear();
        let caller = port.receive(rig.now(), &mut received);
        if caller != Caller::Same {
            rig.hang_up();
        }
        rig.beat(&received, &mut answer);
        port.send(&answer);
        watch(Beat { now: rig.now(), caller, truth: &rig.truth(), emulator: rig.emulator() });
        due += Rig::<ArcosEmulator>::BEAT;
        let late = Instant::now().saturating_duration_since(due);
        if late > LOST {
            due = Instant::now();
        }
        thread::sleep(due.saturating_duration_since(Instant::now()));
    }
}

/// What is later than this is not made up for.
const LOST: Duration = Duration::from_millis(200);
