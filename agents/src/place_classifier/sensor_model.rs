//! How a look for a feature ends, if the feature is there and if it is not.
//!
//! The rates are those that the detectors reach in simulation (`orienteer reproduce detectors`), with a floor of one in a hundred so that no kind of place is ever
//! ruled out for good.

use orienteer_runtime::topics::{FeatureKind, FeatureOutcome};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::catalogue::Standing;

/// What the classifier makes of the outcomes of looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outcomes {
    /// Found and not found are certain, and prune the hypotheses (Randazza 1989). An abort says nothing.
    Certain,
    /// Found and not found are probable. An abort says nothing: it may be anybody who stood in the way.
    TwoValued,
    /// An abort is evidence as well: somewhere the way leads through a wall. Not where people walk about.
    ThreeValued,
}

impl Outcomes {
    /// Names of the outcomes that count.
    #[must_use]
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::Certain | Self::TwoValued => &["found", "not found"],
            Self::ThreeValued => &["found", "not found", "abort"],
        }
    }

    /// The number of an outcome, in the order of [`names`](Self::names); `None` if it says nothing.
    #[must_use]
    pub fn number(self, outcome: FeatureOutcome) -> Option<usize> {
        match (self, outcome) {
            (_, FeatureOutcome::Found) => Some(0),
            (_, FeatureOutcome::NotFound) => Some(1),
            (Self::ThreeValued, FeatureOutcome::Abort) => Some(2),
            (_, FeatureOutcome::Abort) => None,
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
            (Self::ThreeValued, Standing::Present) if edge => &[0.90, 0.02, 0.08],
            (Self::ThreeValued, Standing::Present) => &[0.96, 0.02, 0.02],
            (Self::ThreeValued, Standing::Absent) => &[0.01, 0.95, 0.04],
            (Self::ThreeValued, Standing::Blocked) => &[0.01, 0.05, 0.94],
        }
    }
}
