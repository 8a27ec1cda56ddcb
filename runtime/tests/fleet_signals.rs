//! A fleet that hangs can be ended all the same.
#![allow(clippy::unwrap_used)]

mod fleet_support;

use std::{
    env,
    io::{BufRead, BufReader},
    process::{Child, Command, Stdio},
    thread,
    time::Duration,
};

use fleet_support::{plan, robot};
use orienteer_runtime::{
    agent::{Behaviour, Inputs, Outputs},
    fleet::{self, FleetPlan},
    link::{Backend, Bus, BusOptions},
    recording::{ChunkLimits, Ending, Mission, Reader, Recorder, RobotInfo, Sink},
    time::Time,
};

/// Its step never ends that begins at or after two seconds.
struct Endless;

impl Behaviour for Endless {
    fn step(&mut self, now: Time, _inputs: &Inputs, _out: &mut Outputs) {
        if now < HANGS {
            return;
        }
        println!("in the step");
        loop {
            thread::park();
        }
    }
}

const HANGS: Time = Time::from_nanos(2_000_000_000);

/// The variable by which the test knows itself in its child: where the recording goes.
const CHILD: &str = "FLEET_SIGNALS_CHILD";

/// Not a test: the process that the test starts.
#[test]
#[ignore = "no test, but the entry of the process that the test below starts"]
fn run_a_fleet_that_hangs() {
    let Some(path) = env::var_os(CHILD) else { return };
    let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
    let mut robots = vec![robot(0, &bus, None)];
    robots[0].nodes[2].factory = Box::new(|_| Ok(Box::new(Endless)));
    let infos =
        robots.iter().map(|robot| RobotInfo::new(&robot.name, robot.nodes.iter().map(|node| node.context.node.to_string())));
    let mission = Mission { robots: infos.collect(), ..Mission::default() };
    let recorder = Recorder::start(Sink::File(path.into()), &mission, ChunkLimits::default()).unwrap();
    fleet::run(FleetPlan { recorder: Some(recorder), ..plan(robots, 1) }).unwrap();
}

fn signal(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn who_asks_twice_ends_a_fleet_that_hangs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hangs.mcap");
    let mut command = Command::new("env");
    command.arg("--default-signal=INT,TERM,HUP").arg(env::current_exe().unwrap());
    command.args(["--ignored", "--exact", "run_a_fleet_that_hangs", "--nocapture"]).env(CHILD, &path);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().contains("in the step")), "it has not begun");

    // As `timeout` does it: the same wish, told twice.
    signal(&child, "-INT");
    signal(&child, "-INT");
    thread::sleep(Duration::from_millis(1500));
    assert!(child.try_wait().unwrap().is_none(), "one wish is no reason to leave a recording open");

    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let recording = Reader::open(&path).unwrap();
    assert_eq!((recording.ending(), recording.end_time()), (&Ending::Complete, Time::from_nanos(1_950_000_000)));
}
