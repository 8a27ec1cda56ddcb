//! From a configuration to a running fleet, and what comes of it.
//!
//! [`load`] reads and checks a configuration, [`compose`] opens its world and drivers and plans the fleet, [`run`] does both,
//! runs it and writes what it leaves behind. Everything that is wrong with a configuration comes as [`Problems`], each at its
//! file, line and column, before anything moves.

mod compose;
mod elsewhere;
mod embedded;
mod output;
mod paths;
mod places;
mod remarks;
mod world;

use std::{
    cell::RefCell,
    ops::ControlFlow,
    path::{Path, PathBuf},
    rc::Rc,
    sync::Arc,
    time::Duration,
};

use orienteer_hardware::sim::Arena;
use orienteer_runtime::{
    clock::Pace,
    config::{Mission, Problems, SourceId, Sources, mission::ClockKind},
    descriptors,
    fleet::{self, Ear, Ended, FleetControl, FleetError, Observer},
    recording::{self, ChunkLimits, RecordError, Recorder, RecordingSummary, Sink},
    robot::RobotReport,
    time::Time,
};

pub use compose::{Composed, compose, compose_hardware};
pub use embedded::{EMBEDDED, embedded_files};
pub use output::OutputError;
pub use remarks::{Remark, several};
pub(crate) use world::{find_place, open_world};

use crate::Registry;

/// A configuration that makes sense, with the files that it was read from.
#[derive(Debug)]
pub struct Loaded {
    /// What it says.
    pub mission: Mission,
    /// Where it says it. Files that drivers and worlds read are added.
    pub sources: Sources,
    /// The mission's own file.
    pub file: SourceId,
}

/// Reads a configuration from the disk.
///
/// # Errors
/// Everything that is wrong with it.
pub fn load(path: impl AsRef<Path>, registry: &Registry) -> Result<Loaded, Problems> {
    let (sources, file) = Sources::open(path.as_ref())?;
    load_from(sources, file, registry)
}

/// Reads a configuration that is built into the program: `office-floor`, for instance.
///
/// # Errors
/// If there is none of this name, or everything that is wrong with it.
pub fn load_embedded(name: &str, registry: &Registry) -> Result<Loaded, Problems> {
    load_files(embedded_files(), &format!("{name}.toml"), registry)
}

/// Reads a configuration from files in memory, each with its name.
///
/// # Errors
/// Everything that is wrong with it.
pub fn load_files(
    files: impl IntoIterator<Item = (String, Vec<u8>)>,
    main: &str,
    registry: &Registry,
) -> Result<Loaded, Problems> {
    let mut sources = Sources::embedded(files);
    let file = sources.read(main)?;
    load_from(sources, file, registry)
}

fn load_from(mut sources: Sources, file: SourceId, registry: &Registry) -> Result<Loaded, Problems> {
    let mission = Mission::load(&mut sources, file, registry)?;
    Ok(Loaded { mission, sources, file })
}

/// What is to be different from what the configuration says.
#[derive(Default)]
pub struct RunOptions {
    /// How time passes.
    pub pace: Option<Pace>,
    /// How long, simulated or real.
    pub duration: Option<Duration>,
    /// The seed.
    pub seed: Option<u64>,
    /// Run nothing but the hardware of this robot, until somebody stops it unless there is a duration.
    pub hardware_of: Option<String>,
    /// Number of threads.
    pub threads: Option<usize>,
    /// Where the recording goes.
    pub record: Recording,
    /// Where maps and pictures go; nowhere if not given.
    pub out: Option<PathBuf>,
    /// Lets others pause, step and stop the fleet.
    pub control: FleetControl,
    /// Told once all is ready and before anything moves.
    pub ready: Option<Box<dyn FnOnce()>>,
    /// Watches the fleet.
    pub observer: Option<Box<dyn WorldObserver>>,
}

/// Where a recording goes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Recording {
    /// As the configuration says, in the output directory; nowhere if there is none.
    #[default]
    AsConfigured,
    /// Nowhere.
    Off,
    /// Nowhere, but its hash is computed.
    HashOnly,
    /// Into this file.
    File(PathBuf),
}

/// Watches a fleet and the world around it between steps: progress bars, experiments.
pub trait WorldObserver {
    /// Called after each step; `arena` is the simulated world if there is one. `Break` ends the mission.
    fn after_step(&mut self, now: Time, arena: Option<&Arena>) -> ControlFlow<()>;
}

impl<F: FnMut(Time, Option<&Arena>) -> ControlFlow<()>> WorldObserver for F {
    fn after_step(&mut self, now: Time, arena: Option<&Arena>) -> ControlFlow<()> {
        self(now, arena)
    }
}

/// What became of a mission.
#[derive(Debug)]
pub struct Outcome {
    /// The mission's name.
    pub name: String,
    /// What drove time forward.
    pub clock: ClockKind,
    /// The seed that was used.
    pub seed: u64,
    /// One report for each robot, in the order of the configuration.
    pub robots: Vec<RobotReport>,
    /// The time of the last step.
    pub time: Time,
    /// Number of steps.
    pub steps: u64,
    /// Steps that were skipped because the last one came too late: the machine, or a behaviour, was too slow.
    pub missed: u64,
    /// Wall time from the first step to the last.
    pub elapsed: Duration,
    /// Why it ended.
    pub ended: Ended,
    /// The recording.
    pub recording: Option<RecordingSummary>,
    /// Files written, the recording included.
    pub files: Vec<PathBuf>,
    /// What could not be drawn or written, and what was down when the mission ended.
    pub failures: Vec<String>,
}

impl Outcome {
    /// Simulated seconds per real second.
    #[must_use]
    pub fn real_time_factor(&self) -> f64 {
        self.time.as_secs_f64() / self.elapsed.as_secs_f64().max(1e-9)
    }
}

/// A mission could not be run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The configuration does not work out with this world and these drivers.
    #[error("{0}")]
    Config(#[from] Problems),
    /// The links can't be made.
    #[error("{0}\nhint: {hint}", hint = .0.hint())]
    Link(#[from] orienteer_runtime::link::LinkError),
    /// The robots can't be brought to life.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// The recording would fall on a file that is not for it.
    #[error("the recording `{}` would overwrite {what}", path.display())]
    Overwrites {
        /// Where it was to go.
        path: PathBuf,
        /// What is there.
        what: &'static str,
    },
    /// The recording can't be begun.
    #[error("the recording can't be begun: {0}")]
    Record(#[from] RecordError),
    /// The output directory can't be used.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Runs a mission to its end and writes what it leaves behind.
///
/// # Errors
/// If it can't be begun; then nothing has moved. What goes wrong later is in the [`Outcome`].
pub fn run(mut loaded: Loaded, registry: &Registry, options: RunOptions) -> Result<Outcome, RunError> {
    let threads = threads(&loaded.mission, &options);
    // One more listens for signals.
    descriptors::check_room_for(threads + 1).map_err(FleetError::from)?;
    // Who stops the program while links are being made leaves none behind.
    let ear = Ear::open(options.control.clone());
    let pace = options.pace.unwrap_or(pace(&loaded.mission.settings));
    // Whether bases are guarded, and which drivers are refused, depends on how time passes in truth.
    loaded.mission.settings.clock = if pace == Pace::Wall { ClockKind::Wall } else { ClockKind::Lockstep };
    let seed = options.seed.unwrap_or(loaded.mission.settings.seed);
    let composed = match &options.hardware_of {
        Some(robot) => compose_hardware(loaded, registry, seed, robot)?,
        None => compose(loaded, registry, seed)?,
    };
    for remark in &composed.remarks {
        tracing::warn!("{remark}");
    }
    if let Some(out) = &options.out {
        output::prepare(out)?;
    }
    let settings = composed.settings.clone();
    let planned = Duration::from_secs_f64(settings.duration);
    let duration = options.duration.or_else(|| options.hardware_of.is_none().then_some(planned));
    let recorder = start_recording(&composed, &options, seed, duration.unwrap_or(planned))?;
    let arena = composed.arena.clone();
    // Without a directory nobody will ever see a trail.
    let trailed = arena.clone().filter(|_| options.out.is_some());
    let trails = Rc::new(RefCell::new(paths::Trails::new(trailed)));
    let plan = fleet::FleetPlan {
        environment: composed.environment(),
        robots: composed.robots,
        period: composed.period,
        duration,
        pace,
        leader: composed.leader,
        threads,
        recorder,
        control: options.control,
        epoch: composed.epoch,
        observer: watch(arena.clone(), trails.clone(), options.observer),
    };
    if let Some(ready) = options.ready {
        ready();
    }
    let report = fleet::run(plan)?;
    drop(ear);

    let mut outcome = Outcome {
        name: settings.name,
        clock: settings.clock,
        seed,
        robots: report.robots,
        time: report.time,
        steps: report.steps,
        missed: report.missed,
        elapsed: report.elapsed,
        ended: report.ended,
        recording: None,
        files: Vec::new(),
        failures: Vec::new(),
    };
    match report.recording {
        Some(Ok(summary)) => {
            outcome.files.extend(summary.path.clone());
            outcome.recording = Some(summary);
        }
        Some(Err(error)) => outcome.failures.push(format!("the recording failed: {error}")),
        None => {}
    }
    output::collect_failures(&mut outcome);
    if let Some(out) = &options.out {
        output::write(out, &mut outcome, &trails.borrow(), &composed.sources);
    }
    Ok(outcome)
}

fn pace(settings: &orienteer_runtime::config::mission::MissionKeys) -> Pace {
    match (settings.clock, settings.speed) {
        (ClockKind::Wall, _) => Pace::Wall,
        (ClockKind::Lockstep, Some(factor)) => Pace::Factor(factor),
        (ClockKind::Lockstep, None) => Pace::AsFastAsPossible,
    }
}

fn threads(mission: &Mission, options: &RunOptions) -> usize {
    let robots = if options.hardware_of.is_some() { 1 } else { mission.robots.len() };
    let threads = options.threads.or(mission.settings.threads.map(usize::from));
    threads.unwrap_or_else(|| usual_threads(robots)).clamp(1, robots.max(1))
}

/// A second thread pays off only if each has several robots to step between two barriers, which cost two wake-ups each.
fn usual_threads(robots: usize) -> usize {
    const ROBOTS_PER_THREAD: usize = 8;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    cores.min(robots / ROBOTS_PER_THREAD).max(1)
}

fn watch(
    arena: Option<Arc<Arena>>,
    trails: Rc<RefCell<paths::Trails>>,
    mut observer: Option<Box<dyn WorldObserver>>,
) -> Box<dyn Observer> {
    Box::new(move |now: Time| {
        trails.borrow_mut().after_step(now);
        match &mut observer {
            Some(observer) => observer.after_step(now, arena.as_deref()),
            None => ControlFlow::Continue(()),
        }
    })
}

fn start_recording(
    composed: &Composed,
    options: &RunOptions,
    seed: u64,
    duration: Duration,
) -> Result<Option<Recorder>, RunError> {
    let record = &composed.record;
    let sink = match &options.record {
        Recording::Off => return Ok(None),
        Recording::HashOnly => Sink::Hash,
        Recording::File(path) => Sink::File(path.clone()),
        Recording::AsConfigured => {
            let Some(out) = options.out.as_ref().filter(|_| record.enabled) else { return Ok(None) };
            let name = record.file.clone().unwrap_or_else(|| format!("{}.mcap", composed.settings.name));
            Sink::File(out.join(name))
        }
    };
    if let Sink::File(path) = &sink {
        if composed.sources.holds(path) {
            return Err(RunError::Overwrites { path: path.clone(), what: "a file of the mission" });
        }
        if !recording::may_be_replaced(path) {
            return Err(RunError::Overwrites { path: path.clone(), what: "something that is no recording" });
        }
    }
    let mission = recording::Mission {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed,
        duration,
        control_period: composed.period,
        robots: composed.robot_infos(),
        sources: composed.recorded_sources(),
    };
    Ok(Some(Recorder::start(sink, &mission, ChunkLimits::default())?))
}
