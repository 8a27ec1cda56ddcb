//! From a reading at a sonar's driver to the command at a base's driver, through avoidance in another process.
//!
//! ```sh
//! cargo bench --bench latency              # a minute for each row; `-- 10` for ten seconds
//! ```
//!
//! A driver shows avoidance something too near and something far enough by turns, in each step, and takes the time until the base is told
//! to stand and to go. All that is real lies between: nodes, arbitration, protection, guard, shared memory, two wake-ups of a process
//! and one of a thread. The bench starts itself twice, as the hardware and as the mission, and gives what share of a core each needs.

use std::{
    env,
    fmt::Write as _,
    process::{Child, Command, ExitCode, Stdio},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use orienteer::{
    Registry,
    hardware::{
        base::{executor::ExecutorConfig, protection::ProtectionConfig},
        driver::{BaseDriver, DriverError, SonarDriver},
        drivers::{BaseKind, OpenBase, Site, SonarKind},
    },
    mission::{self, Recording, RunOptions},
    runtime::{
        agent::{Agent, Behaviour, BuildError, Inputs, Outputs, RobotContext, Wiring},
        agents::NoConfig,
        config::Problems,
        geometry::{Limits, Pose, Twist},
        robot_model::{Platform, Ring, Transducer},
        time::Time,
        topics::{Echo, FiringProgram, FixedVec, Odometry, SonarScan},
    },
};
use rustix::time::{ClockId, clock_gettime};
use thread_priority::{
    NormalThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};

/// Whether a process of this bench is to be the hardware or the mission.
const ROLE: &str = "ORIENTEER_LATENCY";
/// Radius of the body, m. Its only transducer sits at the rim and looks ahead.
const RADIUS: f64 = 0.2;
/// What avoidance stops for, and what it does not mind, m.
const NEAR: f32 = 0.02;
const FAR: f32 = 0.08;
/// Before this nothing counts.
const ACQUAINTED: Duration = Duration::from_secs(3);

/// What has been shown and not been answered, and how long the answers took.
#[derive(Default)]
struct Probe {
    shown: Option<(Instant, bool)>,
    near: bool,
    took: Vec<Duration>,
    unanswered: u64,
    began: Option<Instant>,
}

impl Probe {
    /// True once mission and hardware have had the time to find each other.
    fn counts(&mut self) -> bool {
        self.began.get_or_insert_with(Instant::now).elapsed() > ACQUAINTED
    }
}

static PROBE: Mutex<Option<Probe>> = Mutex::new(None);

fn probe<T>(with: impl FnOnce(&mut Probe) -> T) -> T {
    with(PROBE.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(Probe::default))
}

struct ProbeBase {
    platform: Platform,
    twist: Twist,
}

impl BaseDriver for ProbeBase {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, _now: Time, twist: Twist) -> Result<(), DriverError> {
        self.twist = twist;
        probe(|probe| {
            let answered = probe.shown.take_if(|(_, near)| *near == twist.is_stop());
            if let Some((when, _)) = answered.filter(|_| probe.counts()) {
                probe.took.push(when.elapsed());
            }
        });
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        Ok(Odometry { stamp: now, twist: self.twist, ..Odometry::default() })
    }

    fn stop(&mut self) {}
}

struct ProbeSonar(Ring);

impl SonarDriver for ProbeSonar {
    fn ring(&self) -> &Ring {
        &self.0
    }

    fn set_program(&mut self, _now: Time, _program: &FiringProgram) {}

    fn poll(&mut self, now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        probe(|probe| {
            probe.near = !probe.near;
            let echo = Echo::Range(if probe.near { NEAR } else { FAR });
            scans.push(SonarScan::from_echoes(now, probe.took.len() as u64, &[echo]));
            let unanswered = probe.shown.replace((Instant::now(), probe.near)).is_some();
            probe.unanswered += u64::from(unanswered && probe.counts());
        });
        Ok(())
    }
}

struct ProbeKind;

impl BaseKind for ProbeKind {
    const NAME: &'static str = "probe";
    const HELP: &'static str = "takes the time";
    type Config = NoConfig;

    fn open(_: NoConfig, _: &mut Site<'_>) -> Result<OpenBase, Problems> {
        let platform = Platform {
            name: "probe".to_owned(),
            radius: RADIUS,
            limits: Limits { linear: 0.5, angular: 1.0 },
            // At its speed at once, so that each command shows what was decided.
            acceleration: 1e4,
            angular_acceleration: 1e4,
            turning_radius: 0.0,
        };
        Ok(OpenBase {
            driver: Box::new(ProbeBase { platform, twist: Twist::STOP }),
            motion: ExecutorConfig::default(),
            // It would see the same scan, and answer before avoidance can.
            protection: ProtectionConfig { sonar_required: false, ..ProtectionConfig::default() },
            start: Pose::default(),
        })
    }
}

impl SonarKind for ProbeKind {
    const NAME: &'static str = "probe";
    const HELP: &'static str = "shows something near and something far by turns";
    type Config = NoConfig;

    fn open(_: NoConfig, _: &mut Site<'_>) -> Result<Box<dyn SonarDriver>, Problems> {
        Ok(Box::new(ProbeSonar(Ring {
            name: "probe".to_owned(),
            transducers: vec![Transducer { mount: Pose::new(RADIUS, 0.0, 0.0), half_beam: 0.2 }],
            min_range: 0.0,
            max_range: 5.0,
            slot_time: 0.001,
            program: FiringProgram { slots: FixedVec::filled(1, 1), period: 0.001, rings: 1 },
        })))
    }
}

/// Wants to go ahead, always.
struct Ahead;

impl Behaviour for Ahead {
    fn step(&mut self, _now: Time, _inputs: &Inputs, out: &mut Outputs) {
        out.base.drive(Twist::new(0.2, 0.0));
    }
}

impl Agent for Ahead {
    const KIND: &'static str = "ahead";
    const HELP: &'static str = "goes ahead";
    type Config = NoConfig;

    fn topics(_: &mut Wiring) {}

    fn build(_: NoConfig, _: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self)
    }
}

/// Nothing but the nearest distance may show in what avoidance decides.
fn mission_text(rate: u32, run: &str) -> String {
    format!(
        "[mission]\nclock = 'wall'\nduration = 86400\nrun = '{run}'\ncontrol_rate_hz = {rate}\n[record]\nenabled = false\n\
         [[robot]]\nname = 'r'\nhardware = 'elsewhere'\nbase = {{ driver = 'probe' }}\nsonar = {{ driver = 'probe' }}\n\
         [robot.agent.avoidance]\npriority = 10\nslow_clearance = 0.05\nhalt_time = 0.2\napproach_speed = 1.0\n\
         approach_distance = 1.0\n[robot.agent.ahead]\npriority = 5\n"
    )
}

/// One of the two processes. Prints the share of a core that it needed, and what it measured.
fn take_part(role: &str) -> Result<(), String> {
    let parts: Vec<_> = role.splitn(4, ' ').collect();
    let [role, rate, seconds, run] = parts[..] else { return Err(format!("no role: {role}")) };
    let text = mission_text(rate.parse().map_err(|_| rate)?, run);
    let registry = Registry::standard().with_base::<ProbeKind>().with_sonar::<ProbeKind>().with_agent::<Ahead>();
    let files = [("latency.toml".to_owned(), text.into_bytes())];
    let loaded = mission::load_files(files, "latency.toml", &registry).map_err(|problems| problems.to_string())?;
    let options = RunOptions {
        duration: Some(Duration::from_secs(seconds.parse().map_err(|_| seconds)?)),
        record: Recording::Off,
        hardware_of: (role == "hardware").then(|| "r".to_owned()),
        ..RunOptions::default()
    };
    let ended = mission::run(loaded, &registry, options).map_err(|error| error.to_string())?;
    let used = clock_gettime(ClockId::ProcessCPUTime);
    let used = used.tv_sec as f64 + used.tv_nsec as f64 * 1e-9;
    let mut told = format!("{}\n", used / ended.elapsed.as_secs_f64());
    probe(|probe| {
        let _ = writeln!(told, "{}", probe.unanswered);
        for took in &probe.took {
            let _ = writeln!(told, "{}", took.as_nanos());
        }
    });
    print!("{told}");
    Ok(())
}

fn start(role: &str, rate: u32, seconds: u64, run: &str) -> std::io::Result<Child> {
    let mut command = Command::new(env::current_exe()?);
    command.env(ROLE, format!("{role} {rate} {seconds} {run}")).stdout(Stdio::piped()).spawn()
}

fn numbers(child: Child) -> Result<Vec<f64>, String> {
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    String::from_utf8_lossy(&output.stdout).lines().map(|line| line.parse().map_err(|_| line.to_owned())).collect()
}

/// What the cores do beside the two processes.
#[derive(Clone, Copy, PartialEq)]
enum Cores {
    /// Nothing: they fall asleep between two steps, and take their time to wake up.
    Asleep,
    /// They are kept awake by a thread that steps aside for every other.
    Awake,
    /// A thread wants each of them as much as the two processes do.
    Busy,
}

/// Occupies all cores until it is over.
fn occupy(cores: Cores, over: &Arc<AtomicBool>) {
    let count = if cores == Cores::Asleep { 0 } else { thread::available_parallelism().map_or(1, usize::from) };
    for _ in 0..count {
        let over = over.clone();
        thread::spawn(move || {
            let humble = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle);
            if cores == Cores::Awake
                && let Err(error) = set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Min, humble)
            {
                eprintln!("the cores are busy, not only awake: {error:?}");
            }
            while !over.load(Ordering::Relaxed) {}
        });
    }
}

fn row(name: &str, rate: u32, seconds: u64, cores: Cores) -> Result<(), String> {
    let run = format!("latency-{}-{rate}-{}", std::process::id(), cores as u8);
    let over = Arc::new(AtomicBool::new(false));
    occupy(cores, &over);
    let start = |role, seconds| start(role, rate, seconds, &run).map_err(|error| error.to_string());
    // The hardware ends first, so that nothing is shown in vain.
    let mission = start("mission", seconds + 6)?;
    let hardware = start("hardware", seconds + 3)?;
    let (mission, hardware) = (numbers(mission)?, numbers(hardware)?);
    over.store(true, Ordering::Relaxed);
    let ([of_mission, ..], [of_hardware, unanswered, took @ ..]) = (&mission[..], &hardware[..]) else {
        return Err("a process has said nothing".to_owned());
    };
    let mut took = took.to_vec();
    took.sort_by(f64::total_cmp);
    let at = |share: f64| took.get((took.len() as f64 * share) as usize).map_or(f64::NAN, |nanos| nanos * 1e-3);
    println!(
        "{name:<28} {:>7} {unanswered:>10} {:>9.0} {:>9.0} {:>9.0} {:>11.1} {:>11.1}",
        took.len(),
        at(0.5),
        at(0.99),
        at(0.999),
        100.0 * of_hardware,
        100.0 * of_mission
    );
    Ok(())
}

fn main() -> ExitCode {
    if let Ok(role) = env::var(ROLE) {
        return take_part(&role).map_or_else(
            |error| {
                eprintln!("{error}");
                ExitCode::FAILURE
            },
            |()| ExitCode::SUCCESS,
        );
    }
    let seconds = env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(60);
    println!("from sonar reading to command through another process, µs; share of a core, %");
    println!(
        "{:<28} {:>7} {:>10} {:>9} {:>9} {:>9} {:>11} {:>11}",
        "", "samples", "unanswered", "median", "99 %", "99.9 %", "hardware", "mission"
    );
    let rows = [
        ("20 Hz", 20, Cores::Asleep),
        ("20 Hz, cores awake", 20, Cores::Awake),
        ("100 Hz", 100, Cores::Asleep),
        ("100 Hz, cores awake", 100, Cores::Awake),
        ("100 Hz, cores busy", 100, Cores::Busy),
    ];
    for (name, rate, cores) in rows {
        if let Err(error) = row(name, rate, seconds, cores) {
            eprintln!("{name}: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
