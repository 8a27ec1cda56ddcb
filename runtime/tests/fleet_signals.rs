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
    fleet,
    link::{Backend, Bus, BusOptions},
    time::Time,
};

/// Its first step never ends.
struct Endless;

impl Behaviour for Endless {
    fn step(&mut self, _now: Time, _inputs: &Inputs, _out: &mut Outputs) {
        println!("in the step");
        loop {
            thread::park();
        }
    }
}

/// The variable by which the test knows itself in its child.
const CHILD: &str = "FLEET_SIGNALS_CHILD";

/// Not a test: the process that the test starts.
#[test]
#[ignore = "no test, but the entry of the process that the test below starts"]
fn run_a_fleet_that_hangs() {
    if env::var_os(CHILD).is_none() {
        return;
    }
    let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
    let mut robots = vec![robot(0, &bus, None)];
    robots[0].nodes[2].factory = Box::new(|_| Ok(Box::new(Endless)));
    fleet::run(plan(robots, 1)).unwrap();
}

fn signal(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn who_asks_twice_ends_a_fleet_that_hangs() {
    let mut command = Command::new("env");
    command.arg("--default-signal=INT,TERM,HUP").arg(env::current_exe().unwrap());
    command.args(["--ignored", "--exact", "run_a_fleet_that_hangs", "--nocapture"]).env(CHILD, "");
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
}
