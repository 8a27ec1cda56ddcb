//! One run of one detector at one place.

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
    time::Time,
    topics::{FeatureOutcome, FeatureReport, FeatureRequest, PoseEstimate},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::{SuiteError, at_a_place::AtAPlace};
use crate::{
    Registry,
    agents::{place_classifier::Catalogue, places::Reckoning},
    hardware::world::floors::Hypothesis,
};

/// One trial.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    /// Where.
    pub at: AtAPlace,
    /// Which feature of the catalogue.
    pub feature: usize,
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

/// No detector takes longer, s.
const LONGEST: f64 = 900.0;

impl Trial {
    /// In the nominal world, from the very start pose, with sonars and wheels that do not err.
    pub fn exact(place: Hypothesis, feature: usize) -> Self {
        Self { at: AtAPlace::exact(place), feature }
    }

    /// In a world and from a pose that this seed perturbs, with all noise on.
    pub fn perturbed(place: Hypothesis, feature: usize, seed: u64) -> Self {
        Self { at: AtAPlace::perturbed(place, seed, &feature.to_string()), feature }
    }

    /// Runs it.
    pub fn run(&self) -> Result<Seen, SuiteError> {
        let registry = Registry::standard().with_agent::<Asker>();
        let agents = format!("[robot.agent.asker]\nfeature = {}\nwidth = {:?}\n", self.feature, self.at.width());
        let robot = self.at.run(&registry, &agents, LONGEST)?;
        let fact = |name: &str| robot.fact(name).unwrap_or_default();
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
        tracing::debug!(place = self.at.place.id(), feature = self.feature, seed = self.at.seed, ?result, "detector run");
        Ok(result)
    }
}

/// Asks for one feature, from where the robot stands at the start.
struct Asker {
    config: AskerConfig,
    catalogue: Catalogue,
    reckoning: Reckoning,
    request: Option<FeatureRequest>,
    report: Option<FeatureReport>,
}

const FOUND: i32 = 1;
const NOT_FOUND: i32 = 2;

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct AskerConfig {
    /// Which of the catalogue's features.
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
        let feature = self.catalogue.feature.get(self.config.feature);
        let (Some(feature), Some(estimate)) = (feature, inputs.latest::<PoseEstimate>()) else { return };
        if self.request.is_none() {
            let search = self.reckoning.search(feature.kind, feature.whereabouts, estimate.pose);
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
        let reckoning = Reckoning::new(config.width, &robot.ring);
        Ok(Self { config, catalogue: Catalogue::corridors(), reckoning, request: None, report: None })
    }
}
