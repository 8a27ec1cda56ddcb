//! Drivers of one's own: what they are refused for, and what becomes of them.
#![allow(clippy::unwrap_used, missing_docs)]

use orienteer::{
    Registry,
    hardware::{
        driver::{DriverError, SonarDriver},
        drivers::{SonarKind, Site},
    },
    mission::{self, RunError},
    runtime::{
        agents::NoConfig,
        config::{Problem, Problems},
        robot_model::{Ring, Transducer},
        time::Time,
        topics::{FiringProgram, SonarScan},
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
