//! Experiments that anyone can repeat.
//!
//! A [`Suite`] runs one experiment over many seeds and compares what it measured with what the literature reports and with
//! the goal that Orienteer sets itself. Every figure that the README quotes comes from here.
//!
//! Suites run whole missions, with actors, links and arbitration, exactly as `orienteer run` does; only the observer that
//! measures is theirs.

mod arbitration;
mod at_a_place;
mod avoidance;
mod classify;
mod config;
mod corridor;
mod detectors;
mod determinism;
mod diagrams;
mod echo;
mod faults;
mod geographer;
mod kill;
mod parallel;
mod wire;

use serde::Serialize;

pub use parallel::in_parallel;

/// One experiment.
pub struct Suite {
    /// Its name on the command line.
    pub name: &'static str,
    /// One line of help.
    pub help: &'static str,
    /// Runs it.
    pub run: fn(&Effort) -> Result<Vec<Row>, SuiteError>,
}

/// All suites, in the order in which they are run.
pub const SUITES: [Suite; 13] = [
    arbitration::SUITE,
    echo::SUITE,
    corridor::SUITE,
    avoidance::SUITE,
    determinism::SUITE,
    faults::SUITE,
    detectors::SUITE,
    diagrams::SUITE,
    classify::SUITE,
    geographer::SUITE,
    config::SUITE,
    wire::SUITE,
    kill::SUITE,
];

/// The suite of this name.
#[must_use]
pub fn suite(name: &str) -> Option<&'static Suite> {
    SUITES.iter().find(|suite| suite.name == name)
}

/// How much work to put into a suite.
pub struct Effort {
    /// Seeds per row, if not the suite's own number.
    pub seeds: Option<u64>,
    /// A tenth of the seeds.
    pub quick: bool,
    /// Threads to use.
    pub threads: usize,
    /// Told after each run: how many of how many are done.
    pub progress: Box<dyn Fn(&str, u64, u64) + Send + Sync>,
}

impl Effort {
    /// The number of seeds for a row that usually takes `usual`.
    #[must_use]
    pub fn seeds(&self, usual: u64) -> u64 {
        let seeds = self.seeds.unwrap_or(usual);
        if self.quick { seeds.div_ceil(10) } else { seeds }.max(1)
    }
}

/// One figure of a suite.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What was measured, with the conditions.
    pub row: String,
    /// The figure reported in the literature; empty if none is.
    pub reported: String,
    /// The goal, as a person would write it: `≤ 5`.
    pub goal: String,
    /// What was measured.
    pub measured: f64,
    /// Unit of `measured`.
    pub unit: String,
    /// True if the goal was met.
    pub holds: bool,
}

impl Row {
    /// A figure that must not exceed its goal.
    #[must_use]
    pub fn at_most(row: impl Into<String>, goal: f64, measured: f64, unit: &str) -> Self {
        Self::new(row, format!("≤ {goal}"), measured, unit, measured <= goal)
    }

    /// A figure that must reach its goal.
    #[must_use]
    pub fn at_least(row: impl Into<String>, goal: f64, measured: f64, unit: &str) -> Self {
        Self::new(row, format!("≥ {goal}"), measured, unit, measured >= goal)
    }

    /// A figure that must be met exactly.
    #[must_use]
    pub fn exactly(row: impl Into<String>, goal: f64, measured: f64, unit: &str) -> Self {
        Self::new(row, format!("= {goal}"), measured, unit, (measured - goal).abs() < f64::EPSILON)
    }

    /// A figure that has no goal, to be read with the others.
    #[must_use]
    pub fn information(row: impl Into<String>, measured: f64, unit: &str) -> Self {
        Self::new(row, String::new(), measured, unit, true)
    }

    fn new(row: impl Into<String>, goal: String, measured: f64, unit: &str, holds: bool) -> Self {
        Self { row: row.into(), reported: String::new(), goal, measured, unit: unit.to_owned(), holds }
    }

    /// Adds the figure reported in the literature.
    #[must_use]
    pub fn reported(mut self, figure: impl Into<String>) -> Self {
        self.reported = figure.into();
        self
    }
}

/// A suite could not be carried out.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct SuiteError(pub String);

impl SuiteError {
    /// From anything that can be told.
    pub fn from_display(error: impl std::fmt::Display) -> Self {
        Self(error.to_string())
    }
}
