//! Feature detector: finds out whether a feature is there by going round it.
//!
//! Asked with a [`FeatureRequest`], the robot drives to where a feature is expected, follows its walls, and answers with a
//! [`FeatureReport`]: found with three points, not found and why, or aborted (Randazza 1989, §4). There are four features, and a
//! manoeuvre for each:
//!
//! | feature | the robot | costs about (way + turns, cm + °) |
//! |---|---|---|
//! | wall | follows it half a metre one way and a metre the other | 700 |
//! | concave corner | follows the first wall into the corner, the second out of it, and both back | 1050 |
//! | convex corner | passes the end of the first wall, goes round it, follows the second; and back | 1080 |
//! | wall edge | does the same through a doorway, between the posts | 2000 |
//!
//! * [`wall_tests`](wall_beside): is there a wall beside, or ahead?
//! * `manoeuvre`: looking, turning, aligning, following;
//! * `recovery`: what to do when somebody comes between;
//! * `detectors`: the four manoeuvres, each an `async fn` that reads as it goes;
//! * [`shape`](is_such_a_feature): whether the three points make such a feature.
//!
//! The published listing does not work as it is printed. What was changed: the place from which an edge is told from a corner; which way the robot
//! turns to a doorpost; the count of steps before one; an alignment to what is ahead ends as soon as the front sonar hears the nearest; a
//! robot that turned by more than 25° to face a wall has met something else; medians instead of means; an alignment that fails ends the
//! detector; the robot aligns itself at the start to a side that has one wall all along; points are where the sonar heard the wall.

mod detectors;
mod manoeuvre;
mod recovery;
mod shape;
mod wall_tests;

use std::{cell::Cell, rc::Rc};

use crate::clock_ring::{Clockwork, RingFilter};
use orienteer_runtime::{
    agent::{Aborted, Agent, Behaviour, BuildError, Finish, Inputs, Outputs, Pilot, RobotContext, Script, Wiring},
    time::Time,
    topics::{
        BaseDecision, FeatureKind, FeatureOutcome, FeatureReason, FeatureReport, FeatureRequest, FeatureSearch, Odometry,
        PoseEstimate, SonarScan,
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use manoeuvre::{Ended, Manoeuvre};
use recovery::LastOverride;
pub use shape::is_such_a_feature;
pub use wall_tests::{Beside, wall_ahead, wall_beside};

/// Parameters of the feature detector. The lengths belong together, and to Huey's body, ring and corridors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FeatureDetectorConfig {
    /// Speed along walls, m/s (Randazza 1989, §1.4).
    #[schemars(range(min = 0.01, max = 1.0))]
    pub speed: f64,
    /// Speed from one look to the next, m/s.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub travel_speed: f64,
    /// Speed in doorways, m/s.
    #[schemars(range(min = 0.005, max = 0.5))]
    pub creep_speed: f64,
    /// Rates of turns up to 5 degrees, up to 90, and from there on, degrees/s.
    #[schemars(inner(range(min = 0.5, max = 180.0)))]
    pub turn_rates_deg: [f64; 3],
    /// Passes of the sonar that make a ring.
    #[schemars(range(min = 1, max = 100))]
    pub readings: u32,
    /// How they become one.
    pub filter: RingFilter,
    /// How often to look before a wall is missing.
    #[schemars(range(min = 1, max = 10))]
    pub tries: u32,
    /// Distance that is kept from walls, m from the sonar's face.
    #[schemars(range(min = 0.1, max = 2.0))]
    pub clearance: f64,
    /// How long a wall must be, m.
    #[schemars(range(min = 0.5, max = 5.0))]
    pub wall_length: f64,
    /// How far past a wall's end the sonar goes on hearing it at that speed and clearance, m.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub wall_overshoot: f64,
    /// Thickness of a wall that ends in a doorway, m.
    #[schemars(range(min = 0.02, max = 0.5))]
    pub wall_thickness: f64,
    /// Distance that is kept from a doorpost, m from the sonar's face.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub doorpost_distance: f64,
    /// What is nearer than this beside the robot in a doorway is its post, m.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub doorpost: f64,
    /// Steps of 5 cm in which a post must come abeam.
    #[schemars(range(min = 1, max = 50))]
    pub doorpost_steps: u32,
    /// How often a detector may begin a part of its manoeuvre again, since somebody came between.
    #[schemars(range(min = 0, max = 100))]
    pub recoveries: u32,
    /// How often a wall or a corner that is there is found; measured, see `orienteer reproduce detectors`.
    #[schemars(range(min = 0.5, max = 1.0))]
    pub hit_rate: f64,
    /// How often an edge that is there is found.
    #[schemars(range(min = 0.5, max = 1.0))]
    pub edge_hit_rate: f64,
    /// How often a feature is found that is not there.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub false_alarm_rate: f64,
}

impl Default for FeatureDetectorConfig {
    fn default() -> Self {
        Self {
            speed: 0.08,
            travel_speed: 0.25,
            creep_speed: 0.04,
            turn_rates_deg: [8.0, 24.0, 45.0],
            readings: 12,
            filter: RingFilter::Median,
            tries: 2,
            clearance: 0.40,
            wall_length: 1.00,
            wall_overshoot: 0.14,
            wall_thickness: 0.14,
            doorpost_distance: 0.31,
            doorpost: 0.38,
            doorpost_steps: 6,
            recoveries: 8,
            hit_rate: 0.98,
            edge_hit_rate: 0.97,
            false_alarm_rate: 0.01,
        }
    }
}

impl FeatureDetectorConfig {
    /// How surely an outcome is right if the feature is as likely there as not.
    fn certainty(&self, kind: FeatureKind, outcome: FeatureOutcome) -> f64 {
        let hit = if kind == FeatureKind::Edge { self.edge_hit_rate } else { self.hit_rate };
        match outcome {
            FeatureOutcome::Found => hit / (hit + self.false_alarm_rate),
            FeatureOutcome::NotFound => (1.0 - self.false_alarm_rate) / (2.0 - self.false_alarm_rate - hit),
            FeatureOutcome::Abort => 0.0,
        }
    }
}

/// The agent.
#[derive(Debug)]
pub struct FeatureDetector {
    config: Rc<FeatureDetectorConfig>,
    clockwork: Rc<Clockwork>,
    wiring: Wiring,
    /// The request that it carries out, or has carried out.
    request: u32,
    script: Option<Script>,
    counts: Rc<Counts>,
    last_override: Rc<LastOverride>,
}

/// How many detectors ended in each way.
#[derive(Debug, Default)]
struct Counts {
    found: Cell<u32>,
    not_found: Cell<u32>,
    aborted: Cell<u32>,
}

impl Counts {
    fn count(&self, outcome: FeatureOutcome) {
        let count = match outcome {
            FeatureOutcome::Found => &self.found,
            FeatureOutcome::NotFound => &self.not_found,
            FeatureOutcome::Abort => &self.aborted,
        };
        count.set(count.get() + 1);
    }
}

impl FeatureDetector {
    fn take_requests(&mut self, inputs: &Inputs, out: &mut Outputs) {
        let Some(request) = inputs.fresh::<FeatureRequest>().filter(|request| request.request != self.request) else { return };
        self.request = request.request;
        if self.script.take().is_some() {
            out.base.release();
        }
        let Some(search) = request.search() else { return };
        let (number, counts) = (request.request, self.counts.clone());
        let (config, clockwork) = (self.config.clone(), self.clockwork.clone());
        let last_override = self.last_override.clone();
        self.script = Some(Script::new(&self.wiring, move |pilot| async move {
            let report = run(&pilot, config, clockwork, number, search, last_override).await;
            counts.count(report.outcome());
            pilot.publish(report);
            Ok(())
        }));
    }
}

/// Runs one detector to its end.
async fn run(
    pilot: &Pilot,
    config: Rc<FeatureDetectorConfig>,
    clockwork: Rc<Clockwork>,
    request: u32,
    search: FeatureSearch,
    last_override: Rc<LastOverride>,
) -> FeatureReport {
    let began = pilot.now();
    let travelled = || pilot.latest::<PoseEstimate>().map_or(0.0, |estimate| estimate.travelled);
    let before = travelled();
    let manoeuvre = Manoeuvre::new(pilot.clone(), config.clone(), clockwork, last_override.clone());
    let (ended, shared) = recovery::watched(pilot, detectors::detect(&manoeuvre, &search)).await;
    let mut points = manoeuvre.points();
    if !detectors::in_order(&search) {
        points.reverse();
    }
    let (outcome, reason) = match ended {
        Ok(()) if is_such_a_feature(search.kind, &points) => (FeatureOutcome::Found, FeatureReason::None),
        Ok(()) => (FeatureOutcome::NotFound, FeatureReason::WrongShape),
        Err(Ended::NotFound(reason)) => (FeatureOutcome::NotFound, reason),
        Err(Ended::Aborted(Aborted::Blocked)) => (FeatureOutcome::Abort, FeatureReason::Blocked),
        Err(Ended::Aborted(Aborted::Overridden { .. })) => (FeatureOutcome::Abort, FeatureReason::Overridden),
        Err(Ended::Aborted(Aborted::Busy | Aborted::Lapsed | Aborted::TimedOut)) => {
            (FeatureOutcome::Abort, FeatureReason::TimedOut)
        }
    };
    let blocked = reason == FeatureReason::Blocked;
    let disturbed = shared || recovery::is_disturbed(&last_override, began, pilot.now(), blocked);
    let mut report = FeatureReport::new(pilot.now(), request, outcome, reason).disturbed_if(disturbed);
    for (to, point) in report.points.iter_mut().zip(&points) {
        *to = *point;
    }
    report.points_known = points.len().min(report.points.len()) as u32;
    report.certainty = config.certainty(search.kind, outcome);
    (report.driven, report.turned) = (travelled() - before, manoeuvre.turned());
    report.took = pilot.now().secs_since(began);
    pilot.say(format!("{:?} {outcome:?}, {reason:?}, after {:.0} s", search.kind, report.took));
    report
}

impl Behaviour for FeatureDetector {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        self.take_requests(inputs, out);
        let Some(script) = &mut self.script else { return };
        if script.step(now, inputs, out).is_some() {
            self.script = None;
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        let Counts { found, not_found, aborted } = &*self.counts;
        for (name, count) in [("found", found), ("not_found", not_found), ("aborted", aborted)] {
            last_words.fact(name, f64::from(count.get()));
        }
    }
}

impl Agent for FeatureDetector {
    const KIND: &'static str = "feature-detector";
    const HELP: &'static str = "finds walls, corners and wall ends by going round them";
    type Config = FeatureDetectorConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<SonarScan>().reads::<BaseDecision>().reads::<Odometry>().reads::<PoseEstimate>().reads::<FeatureRequest>();
        wiring.writes::<FeatureReport>();
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        if robot.platform.turning_radius > 0.0 {
            return Err(BuildError::new("the detectors need a base that can turn on the spot"));
        }
        let clockwork = Clockwork::new(&robot.ring).map_err(BuildError::new)?;
        let mut wiring = Wiring::default();
        Self::topics(&mut wiring);
        Ok(Self {
            config: Rc::new(config),
            clockwork: Rc::new(clockwork),
            wiring,
            request: 0,
            script: None,
            counts: Rc::default(),
            last_override: Rc::default(),
        })
    }
}
