//! The node over a driver that does what a test says.
#![allow(clippy::unwrap_used)]

use std::{
    sync::{Arc, Mutex},
    time::Duration,
};

use orienteer_runtime::topics::Echo;

use super::*;

/// What the driver hears and was told.
#[derive(Default)]
struct Notes {
    programs: Vec<FiringProgram>,
    /// How far ahead of the step the scans of a poll are, s.
    ahead: Vec<f64>,
    fails: bool,
}

struct Scripted {
    ring: Ring,
    notes: Arc<Mutex<Notes>>,
}

impl SonarDriver for Scripted {
    fn ring(&self) -> &Ring {
        &self.ring
    }

    fn set_program(&mut self, _now: Time, program: &FiringProgram) {
        self.notes.lock().unwrap().programs.push(*program);
    }

    fn poll(&mut self, now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        let notes = self.notes.lock().unwrap();
        let scan = |ahead: &f64| SonarScan::from_echoes(now + Duration::from_secs_f64(*ahead), 1, &[Echo::Range(1.0)]);
        scans.extend(notes.ahead.iter().map(scan));
        match notes.fails {
            true => Err(DriverError::LinkLost { device: "the sonar".into(), why: "a loose plug".into() }),
            false => Ok(()),
        }
    }
}

/// A sonar that is told to fire the same program in each step.
struct Bench {
    node: SonarNode,
    inputs: Inputs,
    out: Outputs,
    notes: Arc<Mutex<Notes>>,
    now: Time,
    program: FiringProgram,
}

impl Bench {
    fn new() -> Self {
        let notes = Arc::new(Mutex::new(Notes::default()));
        let ring = crate::rings::find("denning-16").unwrap().ring;
        let program = ring.program;
        let node = SonarNode::new(Box::new(Scripted { ring, notes: notes.clone() }));
        let wiring = SonarNode::wiring();
        Self { node, inputs: Inputs::offline(&wiring), out: Outputs::offline(&wiring), notes, now: Time::START, program }
    }

    /// A control period. Returns how far ahead of it the published scans are, s.
    fn step(&mut self) -> Vec<f64> {
        self.now = self.now + Duration::from_millis(50);
        self.out.settle();
        let mut decision = SonarDecision::default();
        (decision.stamp, decision.program) = (self.now, self.program);
        self.inputs.put(decision);
        self.node.step(self.now, &self.inputs, &mut self.out);
        self.out.published::<SonarScan>().iter().map(|scan| scan.stamp.secs_since(self.now)).collect()
    }

    fn with(&self, change: impl FnOnce(&mut Notes)) {
        change(&mut self.notes.lock().unwrap());
    }

    /// How often the driver was told the program since the last call.
    fn told(&self) -> usize {
        let programs = std::mem::take(&mut self.notes.lock().unwrap().programs);
        assert!(programs.iter().all(|program| *program == self.program));
        programs.len()
    }
}

/// One such scan would make all that comes after it look old; a driver on its own thread may be a little ahead.
#[test]
fn a_scan_from_the_future_goes_to_nobody() {
    let mut bench = Bench::new();
    bench.with(|notes| notes.ahead = vec![0.0, IN_THE_FUTURE + 0.01, IN_THE_FUTURE - 0.01, 3600.0]);
    assert_eq!(bench.step(), [0.0, IN_THE_FUTURE - 0.01]);
    bench.with(|notes| notes.ahead = vec![0.0]);
    assert_eq!(bench.step(), [0.0], "it is back");
}

/// A ring that was away may have lost its program, or never got it.
#[test]
fn a_ring_that_is_back_is_told_its_program_again() {
    let mut bench = Bench::new();
    bench.step();
    bench.step();
    assert_eq!(bench.told(), 1, "it is not told what it knows");
    bench.with(|notes| notes.fails = true);
    bench.step();
    bench.step();
    bench.with(|notes| notes.fails = false);
    bench.told();
    bench.step();
    bench.step();
    assert_eq!(bench.told(), 1);
    bench.step();
    assert_eq!(bench.told(), 0, "once is enough");
}
