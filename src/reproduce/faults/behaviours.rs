//! Those who misbehave, and one who looks on.

use std::{
    panic::resume_unwind,
    thread,
    time::{Duration, Instant},
};

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Inputs, Level, Outputs, RobotContext, Wiring},
    agents::NoConfig,
    time::Time,
    topics::CorridorOrder,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FAULT_AT, Notebook, lock, marked, notebook};

/// The step in which a behaviour that panics does so.
const LAST_STEP: u32 = 40;
/// How long one that sleeps does so.
const SLEEP: Duration = Duration::from_secs(2);
/// Samples, and log lines, of one who floods in a step.
const FLOOD: usize = 10_000;

/// Drives straight on, more or less.
pub struct Driver {
    panics: bool,
    steps: u32,
    notes: Notebook,
}

/// Parameters of a driver.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DriverConfig {
    /// True if it panics in its 40th step.
    pub panics: bool,
}

impl Behaviour for Driver {
    fn step(&mut self, _now: Time, _inputs: &Inputs, out: &mut Outputs) {
        self.steps += 1;
        let step = {
            let mut notes = lock(&self.notes.robot);
            let began = Instant::now();
            if self.panics && self.steps == LAST_STEP {
                notes.fault.get_or_insert(began);
            }
            notes.asked.push(began);
            notes.asked.len() - 1
        };
        if self.panics && self.steps == LAST_STEP {
            // As a panic, but without its lines on the terminal.
            resume_unwind(Box::new("on purpose, to see what the base does".to_owned()));
        }
        out.base.drive(marked(step));
    }
}

impl Agent for Driver {
    const KIND: &'static str = "test-driver";
    const HELP: &'static str = "drives straight on, and panics if told to";
    type Config = DriverConfig;

    fn topics(_wiring: &mut Wiring) {}

    fn build(config: Self::Config, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self { panics: config.panics, steps: 0, notes: notebook() })
    }
}

/// What a culprit does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mischief {
    /// Sleeps in one step.
    Sleep,
    /// Publishes and says far too much in every step.
    Flood,
}

/// Parameters of a culprit.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CulpritConfig {
    /// What it does.
    pub mischief: Mischief,
}

/// Harms others.
pub struct Culprit {
    mischief: Mischief,
    slept: bool,
    notes: Notebook,
}

impl Behaviour for Culprit {
    fn step(&mut self, now: Time, _inputs: &Inputs, out: &mut Outputs) {
        if now.as_secs_f64() < FAULT_AT {
            return;
        }
        lock(&self.notes.robot).fault.get_or_insert_with(Instant::now);
        match self.mischief {
            Mischief::Sleep if self.slept => {}
            Mischief::Sleep => {
                self.slept = true;
                thread::sleep(SLEEP);
            }
            Mischief::Flood => {
                for i in 0..FLOOD {
                    out.publish(CorridorOrder { stamp: now, order: 0 });
                    out.log(Level::TRACE, format!("line {i}"));
                }
            }
        }
    }
}

impl Agent for Culprit {
    const KIND: &'static str = "culprit";
    const HELP: &'static str = "sleeps in a step or floods its topics";
    const CLAIMS: bool = false;
    type Config = CulpritConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.writes::<CorridorOrder>();
    }

    fn build(config: Self::Config, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self { mischief: config.mischief, slept: false, notes: notebook() })
    }
}

/// Notes when it is stepped.
pub struct Bystander {
    notes: Notebook,
}

impl Behaviour for Bystander {
    fn step(&mut self, _now: Time, _inputs: &Inputs, _out: &mut Outputs) {
        lock(&self.notes.robot).steps.push(Instant::now());
    }
}

impl Agent for Bystander {
    const KIND: &'static str = "bystander";
    const HELP: &'static str = "notes when it is stepped";
    const CLAIMS: bool = false;
    type Config = NoConfig;

    fn topics(_wiring: &mut Wiring) {}

    fn build(_config: NoConfig, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self { notes: notebook() })
    }
}
