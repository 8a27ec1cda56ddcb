//! One run of one detector at one place.

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
    random::Streams,
    time::Time,
    topics::{FeatureOutcome, FeatureReport, FeatureRequest, PoseEstimate},
};
use rand_distr::{Distribution, Normal};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{super::SuiteError, place::FEATURES};
use crate::{
    Registry,
    agents::feature_detector::{Clockwork, Reckoning},
    hardware::world::floors::{Hypothesis, MOST_PERTURBED, Perturbation, junction_world},
    mission::{self, Recording, RunOptions},
};

/// One trial.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    /// Where.
    pub place: Hypothesis,
    /// Which of the [`FEATURES`].
    pub feature: usize,
    perturbation: Perturbation,
    /// Where the robot stands, off the start pose: m to the right, m ahead, degrees to the left.
    off: (f64, f64, f64),
    noisy: bool,
    seed: u64,
}

/// What came of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub outcome: FeatureOutcome,
    /// Way and turns, cm and degrees.
    pub cost: f64,
    /// Seconds.
    pub took: f64,
    pub collisions: u32,
}

/// How far off its start pose the robot is, one standard deviation: cm in either direction, degrees.
const OFF: (f64, f64) = (0.05, 2.0);
/// Randazza's corridors, m wide.
const WIDTH: f64 = 1.12;
/// No detector takes longer, s.
const LONGEST: f64 = 900.0;

impl Trial {
    /// In the nominal world, from the very start pose, with sonars and wheels that do not err.
    pub fn exact(place: Hypothesis, feature: usize) -> Self {
        Self { place, feature, perturbation: Perturbation::NONE, off: (0.0, 0.0, 0.0), noisy: false, seed: 1 }
    }

    /// In a world and from a pose that this seed perturbs, with all noise on.
    pub fn perturbed(place: Hypothesis, feature: usize, seed: u64) -> Self {
        let name = format!("{place} {feature}");
        let mut random = Streams::new(seed).stream(&name, "trial");
        let perturbation = Perturbation::draw(MOST_PERTURBED, &mut random);
        let mut normal = |deviation: f64| Normal::new(0.0, deviation).map_or(0.0, |normal| normal.sample(&mut random));
        let off = (normal(OFF.0), normal(OFF.0), normal(OFF.1));
        Self { place, feature, perturbation, off, noisy: true, seed }
    }

    /// Runs it.
    pub fn run(&self) -> Result<Seen, SuiteError> {
        let registry = Registry::standard().with_agent::<Asker>();
        let world = junction_world(self.place, &self.perturbation).map_err(SuiteError::from_display)?.text();
        let files = [("trial.toml".to_owned(), self.mission()), ("world.toml".to_owned(), world)];
        let files = files.map(|(name, text)| (name, text.into_bytes()));
        let loaded = mission::load_files(files, "trial.toml", &registry).map_err(SuiteError::from_display)?;
        let options = RunOptions { threads: Some(1), record: Recording::Off, ..RunOptions::default() };
        let outcome = mission::run(loaded, &registry, options).map_err(SuiteError::from_display)?;
        let fact = |name: &str| outcome.robots.first().and_then(|robot| robot.fact(name)).unwrap_or_default();
        let result = Seen {
            outcome: match fact("outcome") as i32 {
                FOUND => FeatureOutcome::Found,
                NOT_FOUND => FeatureOutcome::NotFound,
                _ => FeatureOutcome::Abort,
            },
            cost: fact("cost"),
            took: fact("took"),
            collisions: fact("collisions") as u32,
        };
        tracing::debug!(place = self.place.id(), feature = FEATURES[self.feature].0, seed = self.seed, ?result, "detector run");
        Ok(result)
    }

    fn mission(&self) -> String {
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
duration = {LONGEST}
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

[robot.agent.asker]
feature = {feature}
width = {width:?}
"#,
            seed = self.seed,
            heading = 90.0 + left,
            feature = self.feature,
            width = WIDTH * self.perturbation.corridor,
        )
    }
}

/// Asks for one feature, from where the robot stands at the start.
struct Asker {
    config: AskerConfig,
    reckoning: Reckoning,
    request: Option<FeatureRequest>,
    report: Option<FeatureReport>,
}

const FOUND: i32 = 1;
const NOT_FOUND: i32 = 2;

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct AskerConfig {
    /// Which of the features.
    feature: usize,
    /// Width of the corridor, as the follower would have measured it, m.
    width: f64,
}

impl Behaviour for Asker {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        if let Some(report) = inputs.fresh::<FeatureReport>() {
            self.report = Some(*report);
            out.end_mission();
        }
        let (Some((_, kind, whereabouts)), Some(estimate)) = (FEATURES.get(self.config.feature), inputs.latest::<PoseEstimate>())
        else {
            return;
        };
        if self.request.is_none() {
            let search = self.reckoning.search(*kind, *whereabouts, estimate.pose);
            self.request = search.map(|search| FeatureRequest::new(now, 1, &search));
        }
        if let Some(request) = self.request {
            out.publish(request);
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        let Some(report) = self.report else { return };
        let outcome = match report.outcome() {
            FeatureOutcome::Found => FOUND,
            FeatureOutcome::NotFound => NOT_FOUND,
            FeatureOutcome::Abort => 0,
        };
        last_words.fact("outcome", f64::from(outcome));
        last_words.fact("cost", 100.0 * report.driven + report.turned.to_degrees());
        last_words.fact("took", report.took);
    }
}

impl Agent for Asker {
    const KIND: &'static str = "asker";
    const HELP: &'static str = "asks for one feature";
    type Config = AskerConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<PoseEstimate>().reads::<FeatureReport>().writes::<FeatureRequest>();
    }

    fn build(config: AskerConfig, robot: &RobotContext) -> Result<Self, BuildError> {
        let face = Clockwork::new(&robot.ring).map_err(BuildError::new)?.face;
        let reckoning = Reckoning { width: config.width, face };
        Ok(Self { config, reckoning, request: None, report: None })
    }
}
