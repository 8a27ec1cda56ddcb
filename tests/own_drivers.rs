//! Drivers of one's own: what they are refused for, and what becomes of them.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{
    sync::atomic::{AtomicU32, Ordering},
    thread,
    time::Duration,
};

use orienteer::{
    Registry,
    hardware::{
        base::{executor::ExecutorConfig, protection::ProtectionConfig},
        driver::{BaseDriver, DriverError, SonarDriver},
        drivers::{BaseKind, OpenBase, Site, SonarKind},
    },
    mission::{self, Outcome, RunError, RunOptions},
    runtime::{
        agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
        agents::NoConfig,
        clock::Pace,
        config::{Problem, Problems},
        fleet::Ended,
        geometry::{Limits, Twist},
        robot_model::{Platform, Ring, Transducer},
        time::Time,
        topics::{FiringProgram, Odometry, SonarScan},
    },
};

const HALL: &str = "[[room]]\ncorners = [[0, 0], [8, 6]]\n";

fn loaded(mission: &str, registry: &Registry) -> mission::Loaded {
    let files = [("mission.toml", mission), ("hall.toml", HALL)];
    let files = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
    mission::load_files(files, "mission.toml", registry).unwrap()
}

/// The line of a problem and its text.
fn told(problem: &Problem) -> (usize, String) {
    (problem.location().unwrap().line, problem.to_string())
}

/// A ring that its driver says takes no time.
struct Timeless(Ring);

impl SonarDriver for Timeless {
    fn ring(&self) -> &Ring {
        &self.0
    }

    fn set_program(&mut self, _now: Time, _program: &FiringProgram) {}

    fn poll(&mut self, _now: Time, _scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        Ok(())
    }
}

impl SonarKind for Timeless {
    const NAME: &'static str = "timeless";
    const HELP: &'static str = "a ring that takes no time";
    type Config = NoConfig;

    fn open(_config: NoConfig, _site: &mut Site<'_>) -> Result<Box<dyn SonarDriver>, Problems> {
        let transducers = vec![Transducer { mount: Default::default(), half_beam: 0.2 }];
        let mut program = FiringProgram::default();
        program.slots.push(1);
        Ok(Box::new(Self(Ring { name: "timeless".into(), transducers, min_range: 0.1, max_range: 5.0, slot_time: 0.0, program })))
    }
}

const TIMELESS: &str = r#"
[mission]
links = "direct"

[world]
file = "hall.toml"

[[robot]]
name = "huey"
start = { x = 2, y = 2 }
base = { driver = "sim" }
sonar = { driver = "timeless" }
"#;

#[test]
fn a_ring_that_can_keep_no_safety_floor_is_refused_where_it_is_named() {
    let registry = Registry::standard().with_sonar::<Timeless>();
    match mission::compose(loaded(TIMELESS, &registry), &registry, 1) {
        Err(RunError::Config(problems)) => {
            let (line, text) = told(&problems.list()[0]);
            assert_eq!(line, 12, "{text}");
            assert!(text.contains("slot time of 0 s"), "{text}");
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("a robot without a safety floor"),
    }
}

/// A base that shows on which thread it is driven.
struct Wheels {
    platform: Platform,
    /// Panics at this time.
    fails_at: Option<Time>,
    /// Counts how often it was stopped after that.
    stopped: &'static AtomicU32,
    failed: bool,
}

impl BaseDriver for Wheels {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, _now: Time, _twist: Twist) -> Result<(), DriverError> {
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        self.failed |= self.fails_at.is_some_and(|fails_at| now >= fails_at);
        if self.failed {
            // Without the hook, which would write to every test's output.
            std::panic::resume_unwind(Box::new("as planned"));
        }
        // The distance is made to tell whether it is read by its guard.
        let guarded = thread::current().name().is_some_and(|name| name.starts_with("base of"));
        Ok(Odometry { stamp: now, travelled: f64::from(u8::from(guarded)), ..Odometry::default() })
    }

    fn stop(&mut self) {
        if self.failed {
            self.stopped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// How often bases were stopped after their driver had panicked.
static STOPPED: AtomicU32 = AtomicU32::new(0);

fn wheels(fails_at: Option<Time>) -> OpenBase {
    wheels_of(0.1, fails_at)
}

fn wheels_of(radius: f64, fails_at: Option<Time>) -> OpenBase {
    let platform = Platform {
        name: "wheels".to_owned(),
        radius,
        limits: Limits { linear: 0.5, angular: 1.0 },
        acceleration: 1.0,
        angular_acceleration: 1.0,
        turning_radius: 0.0,
    };
    OpenBase {
        driver: Box::new(Wheels { platform, fails_at, stopped: &STOPPED, failed: false }),
        motion: ExecutorConfig::default(),
        protection: ProtectionConfig { sonar_required: false, ..ProtectionConfig::default() },
        start: Default::default(),
    }
}

struct Real;

impl BaseKind for Real {
    const NAME: &'static str = "real";
    const HELP: &'static str = "knows only real time";
    const REAL_TIME: bool = true;
    type Config = NoConfig;

    fn open(_config: NoConfig, _site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        Ok(wheels(None))
    }
}

/// Says whether the base is guarded.
struct Asks(f64);

impl Behaviour for Asks {
    fn step(&mut self, _now: Time, inputs: &Inputs, _out: &mut Outputs) {
        self.0 = inputs.latest::<Odometry>().map_or(self.0, |odometry| odometry.travelled);
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("guarded", self.0);
    }
}

impl Agent for Asks {
    const KIND: &'static str = "asks";
    const HELP: &'static str = "asks whether the base is guarded";
    type Config = NoConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<Odometry>();
    }

    fn build(_config: NoConfig, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self(0.0))
    }
}

#[allow(clippy::result_large_err)]
fn drive(mission: &str, pace: Option<Pace>) -> Result<Outcome, RunError> {
    let registry = Registry::standard().with_base::<Real>().with_base::<Frail>().with_base::<Stillborn>();
    let registry = registry.with_base::<Absurd>().with_agent::<Asks>();
    mission::run(loaded(mission, &registry), &registry, RunOptions { pace, ..RunOptions::default() })
}

fn mission_with(driver: &str, clock: &str) -> String {
    format!(
        "[mission]\nlinks = \"direct\"\nduration = 0.4\nclock = \"{clock}\"\n\n[[robot]]\nname = \"huey\"\nbase = {{ driver = \"{driver}\" }}\n\n[robot.agent.asks]\n"
    )
}

#[test]
fn a_real_base_is_refused_in_simulated_time_whoever_asks_for_it() {
    let of_file = drive(&mission_with("real", "lockstep"), None);
    let of_options = drive(&mission_with("real", "wall"), Some(Pace::Factor(1.0)));
    for refused in [of_file, of_options] {
        let Err(RunError::Config(problems)) = refused else { panic!("{refused:?}") };
        let problem = &problems.list()[0];
        assert_eq!(told(problem).0, 8);
        assert!(problem.hint().contains("clock = \"wall\""), "{}", problem.hint());
    }
}

#[test]
fn a_base_is_guarded_whenever_time_is_real() {
    for (clock, pace, guarded) in [
        ("wall", None, 1.0),
        ("lockstep", Some(Pace::Wall), 1.0),
        ("lockstep", None, 0.0),
        ("wall", Some(Pace::AsFastAsPossible), 0.0),
    ] {
        let driver = if guarded == 1.0 { "real" } else { "frail" };
        let outcome = drive(&mission_with(driver, clock), pace).unwrap();
        assert_eq!(outcome.robots[0].fact("guarded"), Some(guarded), "{clock} {pace:?}");
    }
}

/// A device that counts how often anybody has come to it.
struct Shy;

static DISTURBED: AtomicU32 = AtomicU32::new(0);

impl BaseDriver for Shy {
    fn platform(&self) -> &Platform {
        static PLATFORM: std::sync::LazyLock<Platform> = std::sync::LazyLock::new(|| wheels(None).driver.platform().clone());
        &PLATFORM
    }

    fn command(&mut self, _now: Time, _twist: Twist) -> Result<(), DriverError> {
        DISTURBED.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        DISTURBED.fetch_add(1, Ordering::Relaxed);
        Ok(Odometry { stamp: now, ..Odometry::default() })
    }

    fn stop(&mut self) {
        DISTURBED.fetch_add(1, Ordering::Relaxed);
    }
}

impl BaseKind for Shy {
    const NAME: &'static str = "shy";
    const HELP: &'static str = "counts its visitors";
    const REAL_TIME: bool = true;
    type Config = NoConfig;

    fn open(_config: NoConfig, _site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        Ok(OpenBase { driver: Box::new(Shy), ..wheels(None) })
    }
}

/// `check` composes a mission, too, and the robot may be driving for somebody else at that moment.
#[test]
fn a_mission_that_is_only_composed_leaves_devices_alone() {
    let registry = Registry::standard().with_base::<Shy>().with_agent::<Asks>();
    let composed = mission::compose(loaded(&mission_with("shy", "wall"), &registry), &registry, 1).unwrap();
    thread::sleep(Duration::from_millis(50));
    drop(composed);
    assert_eq!(DISTURBED.load(Ordering::Relaxed), 0);
}

/// A base whose driver panics after a second.
struct Frail;

impl BaseKind for Frail {
    const NAME: &'static str = "frail";
    const HELP: &'static str = "panics after a second";
    type Config = NoConfig;

    fn open(_config: NoConfig, _site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        Ok(wheels(Some(Time::from_secs_f64(1.0))))
    }
}

/// A base whose driver panics at once.
struct Stillborn;

impl BaseKind for Stillborn {
    const NAME: &'static str = "stillborn";
    const HELP: &'static str = "panics at once";
    type Config = NoConfig;

    fn open(_config: NoConfig, _site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        Ok(wheels(Some(Time::START)))
    }
}

/// The base is stopped, it is said, and nobody else is hurt: the other robot and the agents go on.
#[test]
fn a_driver_that_panics_costs_its_own_base_only() {
    for (clock, driver) in [("lockstep", "frail"), ("wall", "frail"), ("lockstep", "stillborn"), ("wall", "stillborn")] {
        let before = STOPPED.load(Ordering::Relaxed);
        let mission = mission_with(driver, clock).replace("duration = 0.4", "duration = 1.5")
            + &format!("\n[[robot]]\nname = \"luey\"\nbase = {{ driver = \"{driver}\" }}\n\n[robot.agent.asks]\n");
        let outcome = drive(&mission, None).unwrap();
        assert!(STOPPED.load(Ordering::Relaxed) >= before + 2);
        assert_eq!(outcome.ended, Ended::Complete, "{clock}");
        let told = |robot: &str| outcome.failures.iter().any(|failure| failure.contains(robot) && failure.contains("base"));
        assert!(told("huey") && told("luey"), "{:?}", outcome.failures);
    }
}

/// A base whose driver does not know how large it is.
struct Absurd;

impl BaseKind for Absurd {
    const NAME: &'static str = "absurd";
    const HELP: &'static str = "is not a number wide";
    type Config = NoConfig;

    fn open(_config: NoConfig, _site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        Ok(wheels_of(f64::NAN, None))
    }
}

/// Protection would find everything free for a body without a size.
#[test]
fn a_base_that_can_not_be_is_refused() {
    let Err(RunError::Config(problems)) = drive(&mission_with("absurd", "lockstep"), None) else { panic!("it was run") };
    let (line, text) = told(&problems.list()[0]);
    assert!(line == 7 && text.contains("the radius of `wheels` is NaN"), "{line}: {text}");
}

#[test]
fn two_robots_have_no_line_in_common_and_the_network_no_baud() {
    let registry = Registry::standard();
    let told = |bases: &[&str]| {
        let robots = bases.iter().enumerate().map(|(i, base)| format!("[[robot]]\nname = 'r{i}'\nbase = {{ {base} }}\n"));
        let mission = format!("[mission]\nclock = 'wall'\nlinks = 'direct'\n{}", robots.collect::<String>());
        let composed = mission::compose(loaded(&mission, &registry), &registry, 1);
        match composed.map(|_| ()) {
            Ok(()) => (0, String::new()),
            Err(RunError::Config(problems)) => told(&problems.list()[0]),
            Err(other) => panic!("{other}"),
        }
    };
    let (pioneer, create) = ("driver = 'arcos', port = '/dev/ttyUSB0'", "driver = 'create', port = '/dev/ttyUSB0'");
    let (line, text) = told(&[pioneer, create]);
    assert!(line == 9 && text.contains("`r0` has the base at `/dev/ttyUSB0` already"), "{line}: {text}");
    assert_eq!(told(&[pioneer, "driver = 'create', port = '/dev/ttyUSB1', baud = 115200"]).0, 0);
    let (line, text) = told(&["driver = 'create', port = 'tcp://a:1', baud = 115200"]);
    assert!(line == 6 && text.contains("only a serial port has a speed"), "{line}: {text}");
}
