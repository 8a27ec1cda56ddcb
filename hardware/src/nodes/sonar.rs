//! The sonar as a node.

use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Outputs, Wiring},
    robot_model::Ring,
    time::Time,
    topics::{FiringProgram, SonarDecision, SonarScan},
};

use super::{IN_THE_FUTURE, trouble::Trouble};
use crate::driver::{DriverError, SonarDriver};

/// Stands in for the sonar of a robot that has none.
pub struct NoSonar {
    ring: Ring,
}

impl Default for NoSonar {
    fn default() -> Self {
        let ring = Ring {
            name: "none".to_owned(),
            transducers: Vec::new(),
            min_range: 0.0,
            max_range: 0.0,
            slot_time: 1.0,
            program: FiringProgram::default(),
        };
        Self { ring }
    }
}

impl SonarDriver for NoSonar {
    fn ring(&self) -> &Ring {
        &self.ring
    }

    fn set_program(&mut self, _now: Time, _program: &FiringProgram) {}

    fn poll(&mut self, _now: Time, _scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        Ok(())
    }
}

/// The sonar: publishes scans, and fires as arbitration has decided.
pub struct SonarNode {
    driver: Box<dyn SonarDriver>,
    program: FiringProgram,
    scans: Vec<SonarScan>,
    count: u64,
    trouble: Trouble,
}

impl SonarNode {
    /// A node over this driver.
    #[must_use]
    pub fn new(driver: Box<dyn SonarDriver>) -> Self {
        Self {
            driver,
            program: FiringProgram::default(),
            scans: Vec::with_capacity(16),
            count: 0,
            trouble: Trouble::new("sonar"),
        }
    }

    /// The topics that it reads and writes.
    #[must_use]
    pub fn wiring() -> Wiring {
        let mut wiring = Wiring::default();
        wiring.reads::<SonarDecision>().writes::<SonarScan>();
        wiring
    }

    fn obey(&mut self, now: Time, inputs: &Inputs) {
        if let Some(decision) = inputs.latest::<SonarDecision>().filter(|decision| decision.program != self.program) {
            self.driver.set_program(now, &decision.program);
            self.program = decision.program;
        }
    }

    fn report(&mut self, now: Time, result: Result<(), DriverError>, out: &mut Outputs) {
        match result {
            Ok(()) if self.trouble.is_on() => {
                self.trouble.end(out);
                // What the ring was told meanwhile, or what it knew before, may be lost.
                self.program = FiringProgram::default();
            }
            // Of a log's end: the base ends the mission; it plays the same log.
            Ok(()) | Err(DriverError::EndOfLog { .. }) => {}
            Err(error) => self.trouble.happen(now, &error, out),
        }
    }
}

impl Behaviour for SonarNode {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        self.scans.clear();
        self.obey(now, inputs);
        let mut result = self.driver.poll(now, &mut self.scans);
        let heard = self.scans.len();
        self.scans.retain(|scan| scan.stamp.secs_since(now) <= IN_THE_FUTURE);
        if self.scans.len() < heard && result.is_ok() {
            let device = self.driver.ring().name.clone();
            result = Err(DriverError::Garbled { device, what: "a scan is from the future".into() });
        }
        for scan in &self.scans {
            out.publish(*scan);
        }
        self.count += self.scans.len() as u64;
        self.report(now, result, out);
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        if let Some(failure) = self.trouble.last_words() {
            last_words.failure(failure);
        }
        last_words.fact("scans", self.count as f64);
    }
}

#[cfg(test)]
mod tests;
