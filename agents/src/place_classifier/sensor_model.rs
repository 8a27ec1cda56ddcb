//! How a look for a feature ends, if the feature is there and if it is not.
//!
//! The rates of three outcomes are those that the detectors reach in simulation (`orienteer reproduce detectors`), those of two are more cautious. Both have a
//! floor, so that no kind of place is ever ruled out for good.

use orienteer_runtime::topics::{FeatureKind, FeatureOutcome, FeatureReason, FeatureReport};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::catalogue::Standing;

/// How a look ended, as far as it tells about the place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The feature was found.
    Found,
    /// It was not.
    NotFound,
    /// The robot could not go on where it had to: there may be a wall.
    Blocked,
    /// Somebody came between, which says nothing about the place.
    Interrupted,
}

impl Ending {
    /// As the feature detector reports it. What somebody was in the way of may be there.
    #[must_use]
    pub fn of(report: &FeatureReport) -> Self {
        match (report.outcome(), report.reason()) {
            (FeatureOutcome::Found, _) => Self::Found,
            _ if report.is_disturbed() => Self::Interrupted,
            _ => Self::seeming(report),
        }
    }

    /// The same, as if nobody had come between.
    #[must_use]
    pub fn seeming(report: &FeatureReport) -> Self {
        match (report.outcome(), report.reason()) {
            (FeatureOutcome::Found, _) => Self::Found,
            (FeatureOutcome::NotFound, _) => Self::NotFound,
            (FeatureOutcome::Abort, FeatureReason::Overridden) => Self::Interrupted,
            (FeatureOutcome::Abort, _) => Self::Blocked,
        }
    }
}

/// What the classifier makes of the outcomes of looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outcomes {
    /// Found and not found are certain, and prune the hypotheses (Randazza 1989). An abort says nothing.
    Certain,
    /// Found and not found are probable. An abort says nothing.
    TwoValued,
    /// That the robot could not go on is evidence as well: at some kinds of places the way leads through a wall. An abort because a higher priority
    /// took the base says nothing.
    ThreeValued,
}

impl Outcomes {
    /// Names of the outcomes that count.
    #[must_use]
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::Certain | Self::TwoValued => &["found", "not found"],
            Self::ThreeValued => &["found", "not found", "blocked"],
        }
    }

    /// The number of an ending, in the order of [`names`](Self::names); `None` if it says nothing.
    #[must_use]
    pub fn number(self, ending: Ending) -> Option<usize> {
        match (self, ending) {
            (_, Ending::Found) => Some(0),
            (_, Ending::NotFound) => Some(1),
            (Self::ThreeValued, Ending::Blocked) => Some(2),
            (_, Ending::Blocked | Ending::Interrupted) => None,
        }
    }

    /// How probable each outcome is, where a feature of this kind stands so.
    #[must_use]
    pub fn probabilities(self, kind: FeatureKind, standing: Standing) -> &'static [f64] {
        let edge = kind == FeatureKind::Edge;
        match (self, standing) {
            (Self::Certain, Standing::Present) => &[1.0, 0.0],
            (Self::Certain, _) => &[0.0, 1.0],
            (Self::TwoValued, Standing::Present) if edge => &[0.97, 0.03],
            (Self::TwoValued, Standing::Present) => &[0.98, 0.02],
            (Self::TwoValued, _) => &[0.01, 0.99],
            (Self::ThreeValued, Standing::Present) if edge => &[0.965, 0.005, 0.03],
            (Self::ThreeValued, Standing::Present) => &[0.985, 0.005, 0.01],
            (Self::ThreeValued, Standing::Absent) => &[0.003, 0.977, 0.02],
            (Self::ThreeValued, Standing::Blocked) => &[0.003, 0.007, 0.99],
        }
    }
}
