//! What a base does when something around it goes wrong, in wall time.
//!
//! Each fault is made on purpose in a mission of a few seconds with one robot in an empty hall. The base driver is watched
//! from outside all robot code: it notes what it is told and when. The behaviour that drives hides the number of its step in
//! the curvature of each command, too slight to matter to the robot, so that every command executed is known by the moment
//! at which the step that asked for it began; a command is executed until the next one comes.

mod behaviours;
mod watched;

use std::{
    cell::RefCell,
    ops::ControlFlow,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use orienteer_hardware::sim::Arena;
use orienteer_runtime::{fleet::FleetControl, geometry::Twist, time::Time};

use super::{Effort, Row, Suite, SuiteError};
use crate::{
    Registry,
    mission::{self, Outcome, Recording, RunOptions},
};
use behaviours::{Bystander, Culprit, Driver};
use watched::WatchedBase;

pub(super) const SUITE: Suite = Suite {
    name: "faults",
    help: "panics, sleep, floods, silent sonar and lost commands, in wall time: how old a command the base executes",
    run,
};

/// The control period, s.
const PERIOD: f64 = 0.05;
/// How old a command other than a stop may be, ms: a control period and 10 ms.
const OLDEST: f64 = 1000.0 * PERIOD + 10.0;
/// When things go wrong, s after the start.
const FAULT_AT: f64 = 1.5;
/// How long a stopped command stream stays so, s.
const OUTAGE: f64 = 1.0;
/// A machine that wakes a sleeping thread later than this, ms, has stalled: no deadline can be met on it meanwhile.
const STALL: f64 = 5.0;
/// How often a mission is run again because of that.
const REPEATS: u32 = 3;
/// How long a mission lasts, s.
const DURATION: f64 = 5.0;
/// How fast the robot drives, m/s.
const SPEED: f64 = 0.3;
/// Time in which a B12 brakes from that speed at 2.18 m/s², and two looks at it, ms.
const BRAKING: f64 = 1000.0 * SPEED / 2.18 + 20.0;
/// How long a sonar may be silent before the base believes it, ms: the default of `max_sonar_age`, two passes of 25 ms, a period.
const SILENCE: f64 = 500.0 + 2.0 * 25.0 + 1000.0 * PERIOD;

const HALL: &str = "[[room]]\ncorners = [[0, 0], [30, 20]]\n";

/// Something that goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    None,
    Panic,
    Sleep,
    Flood,
    SilentSonar,
    NoCommands,
}

const FAULTS: [(Fault, &str); 6] = [
    (Fault::None, "no fault"),
    (Fault::Panic, "the driving behaviour panics in its 40th step"),
    (Fault::Sleep, "a behaviour sleeps for 2 s in a step"),
    (Fault::Flood, "a behaviour floods samples and log lines"),
    (Fault::SilentSonar, "the sonar goes silent"),
    (Fault::NoCommands, "the command stream stops"),
];

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let registry =
        Registry::standard().with_base::<WatchedBase>().with_agent::<Driver>().with_agent::<Culprit>().with_agent::<Bystander>();
    // A full run is not longer than a quick one unless asked for: the machine's clock can't be hurried.
    let times = effort.seeds.unwrap_or(1).max(1);
    let count = times * FAULTS.len() as u64;
    let mut rows = Vec::new();
    for (number, (fault, words)) in (0..).zip(FAULTS) {
        let mut seen = Seen::default();
        for time in 0..times {
            seen.worst_of(&observe_undisturbed(fault, &registry)?);
            (effort.progress)("faults", number * times + time + 1, count);
        }
        rows.extend(seen.rows(fault, words));
    }
    Ok(rows)
}

/// A mission during which the whole machine stalled says nothing of the robot: it is run again, and counted.
fn observe_undisturbed(fault: Fault, registry: &Registry) -> Result<Seen, SuiteError> {
    let mut stalls = 0;
    loop {
        let seen = observe(fault, registry)?;
        if seen.woken_late <= STALL || stalls == REPEATS {
            return Ok(Seen { stalls, ..seen });
        }
        stalls += 1;
    }
}

/// What a mission with a fault looked like from outside.
#[derive(Debug, Default)]
struct Seen {
    /// Age of the oldest command other than a stop while it was executed, ms.
    oldest: f64,
    /// Commands executed that no step asked for.
    unknown: u32,
    /// Commands executed, stops included.
    commands: usize,
    /// From the fault to the first stop, and until the base stood, ms.
    stopped: f64,
    stood: f64,
    /// Steps of another behaviour in the last second of the mission.
    went_on: f64,
    /// Restarts of the behaviour that failed, and what it said in vain.
    restarts: f64,
    dropped: f64,
    /// How late a thread that only sleeps was woken at worst, ms: what the machine adds to every other figure.
    woken_late: f64,
    /// Missions that were run again because the machine stalled.
    stalls: u32,
}

impl Seen {
    fn worst_of(&mut self, other: &Seen) {
        let first = self.commands == 0;
        let least = |a: f64, b: f64| if first { b } else { a.min(b) };
        *self = Seen {
            oldest: self.oldest.max(other.oldest),
            unknown: self.unknown + other.unknown,
            commands: self.commands + other.commands,
            stopped: self.stopped.max(other.stopped),
            stood: self.stood.max(other.stood),
            went_on: least(self.went_on, other.went_on),
            restarts: least(self.restarts, other.restarts),
            dropped: least(self.dropped, other.dropped),
            woken_late: self.woken_late.max(other.woken_late),
            stalls: self.stalls + other.stalls,
        };
    }

    fn rows(&self, fault: Fault, words: &str) -> Vec<Row> {
        let row = |what: &str| format!("{words}: {what}");
        let mut rows = vec![
            Row::at_most(row("oldest command but stops executed"), OLDEST, self.oldest, "ms"),
            Row::exactly(row("commands executed that no step asked for"), 0.0, f64::from(self.unknown), ""),
            Row::at_least(row("steps of another behaviour in the last second"), 10.0, self.went_on, ""),
            Row::information(row("a thread of any program is woken late by"), self.woken_late, "ms"),
            Row::information(row("missions run again because the machine stalled"), f64::from(self.stalls), ""),
        ];
        let stop_within = match fault {
            Fault::None | Fault::Flood => None,
            Fault::Panic | Fault::Sleep | Fault::NoCommands => Some(OLDEST),
            Fault::SilentSonar => Some(SILENCE),
        };
        if let Some(limit) = stop_within {
            rows.push(Row::at_most(row("the base is told to stop within"), limit, self.stopped, "ms"));
            rows.push(Row::at_most(row("the base stands within"), (limit + BRAKING).round(), self.stood, "ms"));
        }
        match fault {
            Fault::Panic => rows.push(Row::at_least(row("panics survived"), 1.0, self.restarts, "")),
            Fault::Flood => rows.push(Row::at_least(row("samples and lines dropped and counted"), 1.0, self.dropped, "")),
            _ => {}
        }
        rows
    }
}

/// What the robot's behaviours note while a mission runs.
#[derive(Debug, Default)]
struct RobotNotes {
    /// When each step of the driving behaviour began; a command carries the step's place here.
    asked: Vec<Instant>,
    /// Steps of the behaviour that looks on.
    steps: Vec<Instant>,
    /// When the fault began.
    fault: Option<Instant>,
}

/// What the base notes.
#[derive(Debug, Default)]
struct BaseNotes {
    /// What the base was told, and when that was done.
    told: Vec<(Instant, Twist)>,
    /// How fast it truly was.
    speeds: Vec<(Instant, f64)>,
}

/// All notes. The base's own are apart, so that its thread never waits for another that notes something.
#[derive(Debug, Default)]
struct Notes {
    robot: Mutex<RobotNotes>,
    base: Mutex<BaseNotes>,
}

type Notebook = Arc<Notes>;

thread_local! {
    /// Where whatever is built on this thread takes its notes. Drivers and behaviours are made from configurations, which can't
    /// carry it; a mission on one thread is built and stepped on its caller's.
    static NOTEBOOK: RefCell<Notebook> = RefCell::default();
}

fn notebook() -> Notebook {
    NOTEBOOK.with_borrow(Arc::clone)
}

fn lock<T>(notes: &Mutex<T>) -> MutexGuard<'_, T> {
    notes.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A command that tells from which step it comes.
fn marked(step: usize) -> Twist {
    Twist::new(SPEED, SPEED * MARK * (step + 1) as f64)
}

/// The curvature between the commands of two steps, 1/m: after ten minutes still a circle of 80 m.
const MARK: f64 = 1e-6;

fn step_of(command: Twist) -> Option<usize> {
    // Protection slows commands down on their curve, or leaves nothing but their turn.
    let speed = if command.linear == 0.0 { SPEED } else { command.linear };
    let mark = command.angular / speed / MARK;
    let step = mark.round();
    ((mark - step).abs() < 1e-3 && step >= 1.0).then(|| step as usize - 1)
}

/// A thread that does nothing but sleep, and is woken by the machine when the machine pleases.
struct Sleeper {
    rest: Arc<AtomicBool>,
    thread: thread::JoinHandle<f64>,
}

impl Sleeper {
    fn start() -> Self {
        let rest = Arc::new(AtomicBool::new(false));
        let resting = rest.clone();
        let nap = Duration::from_millis(10);
        let thread = thread::spawn(move || {
            let mut latest = Duration::ZERO;
            while !resting.load(Ordering::Relaxed) {
                let lay_down = Instant::now();
                thread::sleep(nap);
                latest = latest.max(lay_down.elapsed().saturating_sub(nap));
            }
            1000.0 * latest.as_secs_f64()
        });
        Self { rest, thread }
    }

    /// How late it was woken at worst, ms.
    fn rest(self) -> f64 {
        self.rest.store(true, Ordering::Relaxed);
        self.thread.join().unwrap_or(f64::NAN)
    }
}

fn mission_text(fault: Fault) -> String {
    let silent = if fault == Fault::SilentSonar {
        format!(", faults = {{ silent = [{{ from = {FAULT_AT:.1}, to = {:.1} }}] }}", FAULT_AT + 2.0)
    } else {
        String::new()
    };
    let panics = if fault == Fault::Panic { "panics = true" } else { "" };
    let culprit = match fault {
        Fault::Sleep => "[robot.agent.culprit]\nmischief = \"sleep\"",
        Fault::Flood => "[robot.agent.culprit]\nmischief = \"flood\"",
        _ => "",
    };
    format!(
        r#"
[mission]
clock = "wall"
duration = {DURATION:.1}
control_rate_hz = {:.1}
links = "local"

[world]
file = "hall.toml"

[[robot]]
name = "huey"
base = {{ driver = "watched" }}
sonar = {{ driver = "sim"{silent} }}
start = {{ x = 3.0, y = 10.0 }}

[robot.agent.test-driver]
{panics}

{culprit}

[robot.agent.bystander]
"#,
        1.0 / PERIOD
    )
}

fn observe(fault: Fault, registry: &Registry) -> Result<Seen, SuiteError> {
    let notes = Notebook::default();
    NOTEBOOK.set(notes.clone());
    let files = [("faults.toml", mission_text(fault)), ("hall.toml", HALL.to_owned())];
    let files = files.map(|(name, text)| (name.to_owned(), text.into_bytes()));
    let loaded = mission::load_files(files, "faults.toml", registry).map_err(SuiteError::from_display)?;
    let control = FleetControl::default();
    let options = RunOptions {
        threads: Some(1),
        record: Recording::HashOnly,
        observer: Some(outage(fault, notes.clone(), control.clone())),
        control,
        ..RunOptions::default()
    };
    let machine = Sleeper::start();
    let outcome = mission::run(loaded, registry, options).map_err(SuiteError::from_display)?;
    let ended = Instant::now();
    NOTEBOOK.take();
    let (robot, base) = (lock(&notes.robot), lock(&notes.base));
    Ok(Seen { woken_late: machine.rest(), ..judge(fault, &robot, &base, &outcome, ended) })
}

/// Stops the command stream, and notes when the sonar has gone silent.
fn outage(fault: Fault, notes: Notebook, control: FleetControl) -> Box<dyn mission::WorldObserver> {
    let mut done = !matches!(fault, Fault::NoCommands | Fault::SilentSonar);
    Box::new(move |now: Time, _: Option<&Arena>| {
        if !done && now.as_secs_f64() >= FAULT_AT {
            done = true;
            lock(&notes.robot).fault = Some(Instant::now());
            if fault == Fault::NoCommands {
                control.pause();
                let control = control.clone();
                thread::spawn(move || {
                    thread::sleep(Duration::from_secs_f64(OUTAGE));
                    control.resume();
                });
            }
        }
        ControlFlow::Continue(())
    })
}

fn judge(fault: Fault, robot: &RobotNotes, base: &BaseNotes, outcome: &Outcome, ended: Instant) -> Seen {
    let millis = |from: Instant, to: Instant| 1000.0 * to.saturating_duration_since(from).as_secs_f64();
    let mut seen = Seen { commands: base.told.len(), ..Seen::default() };
    let mut before = Twist::STOP;
    for pair in base.told.windows(2) {
        let (command, until) = (pair[0].1, pair[1].0);
        // The base may brake of its own accord, on the curve that it measures.
        let brakes = command.linear >= 0.0 && command.linear < before.linear;
        match step_of(command).and_then(|step| robot.asked.get(step)) {
            _ if command.is_stop() => {}
            Some(asked) => seen.oldest = seen.oldest.max(millis(*asked, until)),
            None if brakes => {}
            None => seen.unknown += 1,
        }
        before = command;
    }
    if let Some(began) = robot.fault {
        let since = |found: Option<Instant>| found.map_or(f64::INFINITY, |when| millis(began, when));
        let stop = base.told.iter().find(|(when, twist)| *when > began && twist.linear == 0.0);
        seen.stopped = since(stop.map(|(when, _)| *when));
        let stand = base.speeds.iter().find(|(when, speed)| *when > began && speed.abs() < 1e-3);
        seen.stood = since(stand.map(|(when, _)| *when));
    } else if fault != Fault::None {
        (seen.stopped, seen.stood) = (f64::INFINITY, f64::INFINITY);
    }
    let last_second = |step: &&Instant| ended.saturating_duration_since(**step) < Duration::from_secs(1);
    seen.went_on = robot.steps.iter().filter(last_second).count() as f64;
    let nodes = || outcome.robots.iter().flat_map(|robot| &robot.nodes);
    seen.restarts = nodes().map(|node| f64::from(node.panics)).sum();
    seen.dropped = nodes().map(|node| node.dropped as f64).sum();
    seen
}
