//! Topics of feature detection.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Payload;
use crate::{geometry::Pose, time::Time};

/// What a feature is (Randazza 1989, §4.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureKind {
    /// A straight wall, half a metre or more to each side of where it is expected.
    Wall,
    /// Two walls at a right angle that the robot goes round outside.
    Convex,
    /// Two walls at a right angle that the robot stays inside of.
    Concave,
    /// The end of a wall that meets no other, such as the jamb of a doorway.
    Edge,
}

/// How a detector ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureOutcome {
    /// The feature is there: the robot went along all of it.
    Found,
    /// Something that should be there is missing, or something that should not be there is.
    NotFound,
    /// The robot could not look: it was overridden, or something was in its way. It says nothing either way.
    Abort,
}

/// Why a detector did not find its feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureReason {
    /// There is none: it was found.
    None,
    /// No wall could be seen ahead of where the feature is expected.
    NoWallAhead,
    /// What was ahead was met at such an angle that it can't be the wall.
    Skewed,
    /// A wall ended before it should.
    WallTooShort,
    /// A wall did not end where it should.
    WallTooLong,
    /// No wall was beside the robot where one should be.
    NoWallBeside,
    /// A wall was beside the robot where none should be.
    WallBeside,
    /// The robot could not bring itself parallel or perpendicular to a wall.
    NotAligned,
    /// The three points that were recorded do not make such a feature.
    WrongShape,
    /// A higher priority took the base.
    Overridden,
    /// The base could not go on.
    Blocked,
    /// Something that was waited for did not come in time.
    TimedOut,
}

/// Which side of the robot, as it stands in messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// To the left of its heading.
    Left,
    /// To the right.
    Right,
}

impl Side {
    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Side::Left => Side::Right,
            Side::Right => Side::Left,
        }
    }

    /// +1 for left, −1 for right: the sign of `y` and of angles on that side.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Side::Left => 1.0,
            Side::Right => -1.0,
        }
    }
}

/// Asks the feature detector to look for a feature. Topic `feature/request`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::FeatureRequest.v1")]
pub struct FeatureRequest {
    /// When it was asked.
    pub stamp: Time,
    /// Names the request; the report repeats it. A new number replaces a running request, 0 calls it off. The same number again
    /// changes nothing.
    pub request: u32,
    kind: u32,
    side: u32,
    strategy: u32,
    /// Where to stand first, map frame: facing the wall that is to be followed. A detector that finds on its way that the robot does not
    /// stand as parallel to the walls as it thinks turns this about the robot by as much.
    pub at: Pose,
    /// How far off the feature may be along the wall, m.
    pub error: f64,
}

/// What a [`FeatureRequest`] says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatureSearch {
    /// What to look for.
    pub kind: FeatureKind,
    /// On which side the wall is kept while it is followed.
    pub side: Side,
    /// The way to the place: straight, or forward before sideways.
    pub forward_first: bool,
    /// Where to stand first, map frame.
    pub at: Pose,
    /// How far off the feature may be along the wall, m.
    pub error: f64,
}

impl FeatureRequest {
    /// A request for this search.
    #[must_use]
    pub fn new(stamp: Time, request: u32, search: &FeatureSearch) -> Self {
        let FeatureSearch { kind, side, forward_first, at, error } = *search;
        let kind = 1 + KINDS.iter().position(|known| *known == kind).unwrap_or_default() as u32;
        let side = if side == Side::Left { 1 } else { 2 };
        Self { stamp, request, kind, side, strategy: u32::from(forward_first), at, error }
    }

    /// What to look for; `None` if it makes no sense.
    #[must_use]
    pub fn search(&self) -> Option<FeatureSearch> {
        let kind = *KINDS.get((self.kind as usize).checked_sub(1)?)?;
        let side = match self.side {
            1 => Side::Left,
            2 => Side::Right,
            _ => return None,
        };
        let sound = self.at.is_sound() && (0.0..10.0).contains(&self.error);
        sound.then_some(FeatureSearch { kind, side, forward_first: self.strategy == 1, at: self.at, error: self.error })
    }
}

impl Payload for FeatureRequest {
    const TOPIC: &'static str = "feature/request";
    const QUEUE: usize = 4;
}

/// What a detector found. Topic `feature/report`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::FeatureReport.v2")]
pub struct FeatureReport {
    /// When the detector ended.
    pub stamp: Time,
    /// The request that this answers.
    pub request: u32,
    outcome: u32,
    reason: u32,
    /// How many of the three points were recorded: partial results count.
    pub points_known: u32,
    disturbed: u64,
    /// The points, map frame, in the order in which a robot meets them that keeps the feature on its right. The heading of each is
    /// the robot's own when it recorded it.
    pub points: [Pose; 3],
    /// How surely the outcome is right, 0 to 1; an abort is no outcome.
    pub certainty: f64,
    /// What it cost: metres driven, radians turned (both without sign), seconds.
    pub driven: f64,
    /// See `driven`.
    pub turned: f64,
    /// See `driven`.
    pub took: f64,
}

const KINDS: [FeatureKind; 4] = [FeatureKind::Wall, FeatureKind::Convex, FeatureKind::Concave, FeatureKind::Edge];
const OUTCOMES: [FeatureOutcome; 3] = [FeatureOutcome::Abort, FeatureOutcome::Found, FeatureOutcome::NotFound];
const REASONS: [FeatureReason; 12] = [
    FeatureReason::TimedOut,
    FeatureReason::None,
    FeatureReason::NoWallAhead,
    FeatureReason::Skewed,
    FeatureReason::WallTooShort,
    FeatureReason::WallTooLong,
    FeatureReason::NoWallBeside,
    FeatureReason::WallBeside,
    FeatureReason::NotAligned,
    FeatureReason::WrongShape,
    FeatureReason::Overridden,
    FeatureReason::Blocked,
];

impl FeatureReport {
    /// A report with this ending.
    #[must_use]
    pub fn new(stamp: Time, request: u32, outcome: FeatureOutcome, reason: FeatureReason) -> Self {
        let number = |at: Option<usize>| at.unwrap_or_default() as u32;
        let outcome = number(OUTCOMES.iter().position(|known| *known == outcome));
        let reason = number(REASONS.iter().position(|known| *known == reason));
        Self { stamp, request, outcome, reason, ..Self::default() }
    }

    /// How the detector ended. What is no outcome that is known is an abort.
    #[must_use]
    pub fn outcome(&self) -> FeatureOutcome {
        OUTCOMES.get(self.outcome as usize).copied().unwrap_or(FeatureOutcome::Abort)
    }

    /// Says whether somebody came between.
    #[must_use]
    pub fn disturbed_if(mut self, disturbed: bool) -> Self {
        self.disturbed = u64::from(disturbed);
        self
    }

    /// True if somebody came between, or stood in the way soon after. What was not found then may be there.
    #[must_use]
    pub fn is_disturbed(&self) -> bool {
        self.disturbed != 0
    }

    /// Why the feature was not found.
    #[must_use]
    pub fn reason(&self) -> FeatureReason {
        REASONS.get(self.reason as usize).copied().unwrap_or(FeatureReason::TimedOut)
    }
}

impl Payload for FeatureReport {
    const TOPIC: &'static str = "feature/report";
    const QUEUE: usize = 4;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_comes_out_again() {
        for kind in KINDS {
            for side in [Side::Left, Side::Right] {
                let search =
                    FeatureSearch { kind, side, forward_first: side == Side::Left, at: Pose::new(1.0, -2.0, 0.5), error: 0.2 };
                assert_eq!(FeatureRequest::new(Time::START, 3, &search).search(), Some(search));
            }
        }
        for outcome in OUTCOMES {
            for reason in REASONS {
                let report = FeatureReport::new(Time::START, 1, outcome, reason);
                assert_eq!((report.outcome(), report.reason()), (outcome, reason));
            }
        }
    }

    #[test]
    fn what_makes_no_sense_is_no_request_and_an_abort() {
        assert_eq!(FeatureRequest::default().search(), None);
        let search = FeatureSearch {
            kind: FeatureKind::Wall,
            side: Side::Left,
            forward_first: false,
            at: Pose::default(),
            error: f64::NAN,
        };
        assert_eq!(FeatureRequest::new(Time::START, 1, &search).search(), None);
        let strange = FeatureReport { outcome: 77, reason: 99, ..FeatureReport::default() };
        assert_eq!((strange.outcome(), strange.reason()), (FeatureOutcome::Abort, FeatureReason::TimedOut));
    }
}
