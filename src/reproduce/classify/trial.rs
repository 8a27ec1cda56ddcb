//! One visit to one place.

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
    time::Time,
    topics::{Opening, PlaceOrder, PlaceReport, PoseEstimate, Truth},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::{SuiteError, at_a_place::AtAPlace};
use crate::{
    Registry,
    agents::place_classifier::{Catalogue, Selection},
    hardware::world::floors::Hypothesis,
};

/// One trial.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    /// Where.
    pub at: AtAPlace,
    hinted: bool,
    selection: Selection,
}

/// What came of it.
#[derive(Debug, Clone)]
pub(super) struct Named {
    /// The kind of place, by its number in the catalogue; −1 if it is none or nothing was reported.
    kind: f64,
    /// How many features were looked for.
    pub looks: f64,
    /// Way and turns, cm and degrees.
    pub cost: f64,
    /// Seconds.
    pub took: f64,
    /// How far the robot stands from the start pose at the end, m.
    pub off: f64,
    pub collisions: u32,
}

impl Named {
    /// True if that is the place's name.
    pub fn is(&self, place: Hypothesis) -> bool {
        self.kind == place as usize as f64
    }
}

/// No place takes longer, s.
const LONGEST: f64 = 7200.0;

impl Trial {
    /// A visit to this place, as this seed has it.
    pub fn new(place: Hypothesis, seed: u64, hinted: bool, selection: Selection) -> Self {
        Self { at: AtAPlace::perturbed(place, seed, "visit"), hinted, selection }
    }

    /// Runs it.
    pub fn run(&self) -> Result<Named, SuiteError> {
        let registry = Registry::standard().with_agent::<Visitor>();
        let opening = if self.hinted { 1 + self.at.place as usize / 4 } else { 0 };
        let agents = format!(
            "[robot.agent.place-classifier]\nselection = \"{}\"\n\n[robot.agent.visitor]\nopening = {opening}\nwidth = {:?}\n",
            super::name_of(self.selection),
            self.at.width(),
        );
        let robot = self.at.run(&registry, &agents, LONGEST)?;
        let fact = |name: &str| robot.fact(name).unwrap_or_default();
        let named = Named {
            kind: robot.fact("kind").unwrap_or(-1.0),
            looks: fact("looks_taken"),
            cost: fact("cost"),
            took: fact("took"),
            off: fact("off"),
            collisions: fact("collisions") as u32,
        };
        if !named.is(self.at.place) {
            tracing::debug!(place = self.at.place.id(), seed = self.at.seed, hinted = self.hinted, ?named, "named wrong");
        }
        Ok(named)
    }
}

/// Has the place named where the robot stands at the start.
struct Visitor {
    config: VisitorConfig,
    catalogue: Catalogue,
    order: Option<PlaceOrder>,
    report: Option<PlaceReport>,
    /// Where the robot truly is.
    truth: Option<Truth>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct VisitorConfig {
    /// 0 if nothing was seen on arrival; 1, 2, 3 if the right, the left or both sides are open.
    opening: u32,
    /// Width of the corridor, as the follower would have measured it, m.
    width: f64,
}

impl Behaviour for Visitor {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        self.truth = inputs.latest::<Truth>().copied().or(self.truth);
        if let Some(report) = inputs.fresh::<PlaceReport>() {
            self.report = Some(*report);
            out.end_mission();
        }
        let Some(estimate) = inputs.latest::<PoseEstimate>() else { return };
        let opening = match self.config.opening {
            1 => Opening::Right,
            2 => Opening::Left,
            3 => Opening::Both,
            _ => Opening::Lost,
        };
        let order = self.order.get_or_insert_with(|| PlaceOrder::new(now, 1, opening, estimate.pose, self.config.width));
        out.publish(*order);
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        let Some(report) = self.report else { return };
        let kind = self.catalogue.hypothesis.iter().position(|hypothesis| hypothesis.id == report.kind.as_str());
        last_words.fact("kind", kind.map_or(-1.0, |kind| kind as f64));
        last_words.fact("looks_taken", f64::from(report.looks));
        last_words.fact("cost", 100.0 * report.driven + report.turned.to_degrees());
        last_words.fact("took", report.took);
        // The start pose is the origin of such a world.
        if let Some(truth) = self.truth {
            last_words.fact("off", truth.pose.x.hypot(truth.pose.y));
        }
    }
}

impl Agent for Visitor {
    const KIND: &'static str = "visitor";
    const HELP: &'static str = "has a place named";
    type Config = VisitorConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<PoseEstimate>().reads::<PlaceReport>().reads_if_any::<Truth>().writes::<PlaceOrder>();
    }

    fn build(config: VisitorConfig, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self { config, catalogue: Catalogue::corridors(), order: None, report: None, truth: None })
    }
}
