//! A robot at one of the twelve places of Randazza (1989), and what it reports.

use orienteer_runtime::{random::Streams, robot::RobotReport};
use rand_distr::{Distribution, Normal};

use super::SuiteError;
use crate::{
    Registry,
    hardware::world::floors::{Hypothesis, MOST_PERTURBED, Perturbation, junction_world},
    mission::{self, Recording, RunOptions},
};

/// A place, and a robot that stands about where it is looked at from.
#[derive(Debug, Clone)]
pub(super) struct AtAPlace {
    /// Which of the twelve.
    pub place: Hypothesis,
    /// The seed behind all that errs.
    pub seed: u64,
    perturbation: Perturbation,
    /// Where the robot stands, off the start pose: m to the right, m ahead, degrees to the left.
    off: (f64, f64, f64),
    noisy: bool,
}

/// The twelve places: all but the dead end, which the listing does not know.
pub(super) const PLACES: usize = Hypothesis::ALL.len() - 1;
/// How far off its start pose the robot is, one standard deviation: m in either direction, degrees.
const OFF: (f64, f64) = (0.05, 2.0);
/// Randazza's corridors, m wide.
const WIDTH: f64 = 1.12;

impl AtAPlace {
    /// In the nominal world, at the very start pose, with sonars and wheels that do not err.
    pub fn exact(place: Hypothesis) -> Self {
        Self { place, perturbation: Perturbation::NONE, off: (0.0, 0.0, 0.0), noisy: false, seed: 1 }
    }

    /// In a world and at a pose that this seed and purpose perturb, with all noise on.
    pub fn perturbed(place: Hypothesis, seed: u64, purpose: &str) -> Self {
        let mut random = Streams::new(seed).stream(&format!("{place} {purpose}"), "trial");
        let perturbation = Perturbation::draw(MOST_PERTURBED, &mut random);
        let mut normal = |deviation: f64| Normal::new(0.0, deviation).map_or(0.0, |normal| normal.sample(&mut random));
        let off = (normal(OFF.0), normal(OFF.0), normal(OFF.1));
        Self { place, perturbation, off, noisy: true, seed }
    }

    /// Width of the corridor, as the follower would have measured it, m.
    pub fn width(&self) -> f64 {
        WIDTH * self.perturbation.corridor
    }

    /// Runs a mission with these agents (tables as a mission has them) until one ends it, or for so long, s. Returns what the robot has to say.
    pub fn run(&self, registry: &Registry, agents: &str, longest: f64) -> Result<RobotReport, SuiteError> {
        let world = junction_world(self.place, &self.perturbation).map_err(SuiteError::from_display)?.text();
        let files = [("trial.toml".to_owned(), self.mission(agents, longest)), ("world.toml".to_owned(), world)];
        let files = files.map(|(name, text)| (name, text.into_bytes()));
        let loaded = mission::load_files(files, "trial.toml", registry).map_err(SuiteError::from_display)?;
        let options = RunOptions { threads: Some(1), record: Recording::Off, ..RunOptions::default() };
        let outcome = mission::run(loaded, registry, options).map_err(SuiteError::from_display)?;
        outcome.robots.into_iter().next().ok_or_else(|| SuiteError("the mission had no robot".into()))
    }

    fn mission(&self, agents: &str, longest: f64) -> String {
        let (right, ahead, left) = self.off;
        let (ring, odometry) = if self.noisy {
            ("", "")
        } else {
            (
                ", model = { noise = 0.0, spurious = 0.0, quantum = 0.03048, incidence_limit = [{ limit_deg = 30.0 }] }",
                ", odometry = { turn_excess = [], distance_noise = 0.0, turn_noise = 0.0 }",
            )
        };
        format!(
            r#"
[mission]
duration = {longest}
seed = {seed}
links = "direct"

[world]
file = "world.toml"

[[robot]]
name = "huey"
base = {{ driver = "sim", platform = "b12-huey"{odometry} }}
sonar = {{ driver = "sim", ring = "denning-16"{ring} }}
start = {{ x = {right:?}, y = {ahead:?}, heading_deg = {heading:?} }}

[robot.agent.where-am-i]

[robot.agent.avoidance]

[robot.agent.feature-detector]

{agents}"#,
            seed = self.seed,
            heading = 90.0 + left,
        )
    }
}
