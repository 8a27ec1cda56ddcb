//! Topics of naming places.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FixedVec, Label, Opening, Payload};
use crate::{geometry::Pose, time::Time};

/// A way out of a place, as seen by a robot that has just come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Way {
    /// To the left.
    Left,
    /// Straight on.
    Ahead,
    /// To the right.
    Right,
}

impl Way {
    /// All of them, from left to right.
    pub const ALL: [Self; 3] = [Self::Left, Self::Ahead, Self::Right];
}

/// Asks what a place is. Topic `place/order`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::PlaceOrder.v1")]
pub struct PlaceOrder {
    /// When it was asked.
    pub stamp: Time,
    /// Names the order; the report repeats it. A new number replaces a running order, 0 calls it off. The same number again
    /// changes nothing.
    pub order: u32,
    opening: u32,
    /// The place's start pose, map frame: in the middle of the corridor, facing along it, the front sonar level with the near corner.
    pub start: Pose,
    /// Distance between the corridor's walls, m; 0 if it is not known.
    pub width: f64,
}

impl PlaceOrder {
    /// An order, with what the corridor follower has seen of the place.
    #[must_use]
    pub fn new(stamp: Time, order: u32, opening: Opening, start: Pose, width: f64) -> Self {
        Self { stamp, order, opening: opening.number(), start, width }
    }

    /// Which sides are open, as seen on arrival; [`Opening::Lost`] if that is not known.
    #[must_use]
    pub fn opening(&self) -> Opening {
        Opening::numbered(self.opening)
    }
}

impl Payload for PlaceOrder {
    const TOPIC: &'static str = "place/order";
    const QUEUE: usize = 4;
}

/// What is thought of the place that is being looked at. Topic `place/belief`; published when it changes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::PlaceBelief.v1")]
pub struct PlaceBelief {
    /// When it was thought.
    pub stamp: Time,
    /// The order that is carried out.
    pub order: u32,
    /// How many features have been looked for.
    pub looks: u32,
    /// Probability of each kind of place, in the order of the catalogue.
    pub beliefs: FixedVec<f64>,
    /// The most probable one.
    pub best: Label,
    /// The feature that is looked for next; empty if none is.
    pub looking_for: Label,
}

impl Payload for PlaceBelief {
    const TOPIC: &'static str = "place/belief";
    const QUEUE: usize = 8;
}

/// What a place is. Topic `place/report`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::PlaceReport.v1")]
pub struct PlaceReport {
    /// When it was decided.
    pub stamp: Time,
    /// The order that this answers.
    pub order: u32,
    /// How many features were looked for.
    pub looks: u32,
    /// The kind of place, by its name in the catalogue; empty if it can't be any of them.
    pub kind: Label,
    /// The same for people.
    pub title: Label,
    /// Its probability.
    pub belief: f64,
    /// The place's start pose, map frame: corrected for what was found out about the corridor's direction.
    pub start: Pose,
    /// Ways out, in the order of [`Way::ALL`]: 1 if it is one.
    ways: [u32; 3],
    /// 1 if the probability is above the threshold at which the classifier is content.
    sure: u32,
    /// Where a robot stands that has left by each way, map frame.
    pub ports: [Pose; 3],
    /// What it cost: metres driven, radians turned (both without sign), seconds.
    pub driven: f64,
    /// See `driven`.
    pub turned: f64,
    /// See `driven`.
    pub took: f64,
}

impl PlaceReport {
    /// A report that answers this order.
    #[must_use]
    pub fn new(stamp: Time, order: u32) -> Self {
        Self { stamp, order, ..Self::default() }
    }

    /// Says whether this is sure enough, and which ways lead on.
    #[must_use]
    pub fn with(mut self, sure: bool, ways: &[Way]) -> Self {
        self.sure = u32::from(sure);
        self.ways = Way::ALL.map(|way| u32::from(ways.contains(&way)));
        self
    }

    /// True if the classifier is content.
    #[must_use]
    pub fn is_sure(&self) -> bool {
        self.sure == 1
    }

    /// The ways that lead on, from left to right.
    pub fn ways(&self) -> impl Iterator<Item = Way> + '_ {
        Way::ALL.into_iter().zip(self.ways).filter(|(_, open)| *open == 1).map(|(way, _)| way)
    }
}

impl Payload for PlaceReport {
    const TOPIC: &'static str = "place/report";
    const QUEUE: usize = 4;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_come_out_as_they_went_in() {
        let report = PlaceReport::new(Time::START, 3).with(true, &[Way::Right, Way::Left]);
        assert_eq!(report.ways().collect::<Vec<_>>(), [Way::Left, Way::Right]);
        assert!(report.is_sure() && !PlaceReport::default().is_sure());
    }

    #[test]
    fn an_order_keeps_what_the_follower_saw() {
        for opening in [Opening::Left, Opening::Right, Opening::Both, Opening::DeadEnd, Opening::Lost] {
            assert_eq!(PlaceOrder::new(Time::START, 1, opening, Pose::default(), 1.12).opening(), opening);
        }
    }
}
