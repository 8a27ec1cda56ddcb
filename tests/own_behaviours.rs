//! Behaviours of one's own that are wrong: a person learns of it, and the robot stands.
#![allow(clippy::unwrap_used, missing_docs)]

use std::fs;

use orienteer::{
    Registry,
    mission::{self, Recording, RunOptions},
    runtime::{
        agent::{Agent, Behaviour, BuildError, Inputs, Outputs, RobotContext, Wiring},
        agents::NoConfig,
        geometry::Twist,
        time::Time,
    },
};

const HALL: &str = "[[room]]\ncorners = [[0, 0], [8, 6]]\n";

fn load(kind: &str, registry: &Registry) -> mission::Loaded {
    let mission = format!(
        "[mission]\nduration = 4\nlinks = 'direct'\n[world]\nfile = 'hall.toml'\n[[robot]]\nname = 'r'\n\
         base = {{ driver = 'sim' }}\nsonar = {{ driver = 'sim' }}\nstart = {{ x = 3, y = 3 }}\n[robot.agent.{kind}]\n"
    );
    let files = [("mission.toml", mission.as_str()), ("hall.toml", HALL)];
    let files = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
    mission::load_files(files, "mission.toml", registry).unwrap()
}

/// Can't be built, and does not say so as it should.
struct Unbuilt;

impl Behaviour for Unbuilt {
    fn step(&mut self, _now: Time, _inputs: &Inputs, _out: &mut Outputs) {}
}

impl Agent for Unbuilt {
    const KIND: &'static str = "unbuilt";
    const HELP: &'static str = "panics when it is built";
    type Config = NoConfig;

    fn topics(_wiring: &mut Wiring) {}

    fn build(_config: NoConfig, _robot: &RobotContext) -> Result<Self, BuildError> {
        panic!("no screws left")
    }
}

#[test]
fn one_that_panics_when_it_is_built_is_refused_at_its_place() {
    std::panic::set_hook(Box::new(|_| {}));
    let registry = Registry::standard().with_agent::<Unbuilt>();
    let Err(mission::RunError::Config(problems)) = mission::compose(load("unbuilt", &registry), &registry, 1) else {
        unreachable!("it was built")
    };
    let problem = &problems.list()[0];
    assert_eq!(problem.location().unwrap().line, 11, "{problem}");
    assert!(problem.message().contains("`unbuilt` can't be built: it panicked: no screws left"), "{problem}");
}

/// Divides by zero, from one second to two and from three on.
struct Reckless;

impl Behaviour for Reckless {
    fn step(&mut self, now: Time, _inputs: &Inputs, out: &mut Outputs) {
        let sound = (now.as_secs_f64() as u64).is_multiple_of(2);
        out.base.drive(if sound { Twist::new(0.1, 0.0) } else { Twist::new(f64::NAN, 0.0) });
    }
}

impl Agent for Reckless {
    const KIND: &'static str = "reckless";
    const HELP: &'static str = "divides by zero";
    type Config = NoConfig;
    const CLAIMS: bool = true;

    fn topics(_wiring: &mut Wiring) {}

    fn build(_config: NoConfig, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self)
    }
}

#[test]
fn who_asks_for_what_is_no_number_is_told_each_time_that_it_begins() {
    let registry = Registry::standard().with_agent::<Reckless>();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("reckless.mcap");
    let options = RunOptions { record: Recording::File(file.clone()), ..RunOptions::default() };
    let outcome = mission::run(load("reckless", &registry), &registry, options).unwrap();
    let driving = outcome.robots[0].fact("driving_s").unwrap();
    assert!((1.5..2.1).contains(&driving), "two of four seconds: {driving}");
    // The recording is not compressed, so that its log lines stand in it as they are.
    let bytes = fs::read(&file).unwrap();
    let line = b"asks for a motion or a limit that is no number";
    assert_eq!(bytes.windows(line.len()).filter(|window| window == line).count(), 2);
}
