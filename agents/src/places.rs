//! How places are laid out, and where a robot stands to look at them or to leave them (Randazza 1989, §4.1).
//!
//! A place is looked at from its *start pose*: in the middle of the corridor, facing along it, the front sonar level with the near
//! corner. Where its features must be follows from the width of the corridor, taken for that of the ways that branch off as
//! well, and from the size of the sonar ring:
//!
//! ```text
//!        FL │     │ FR          far line
//!   ────────┘     └────────
//!     L        A        R       what is ahead, to the left, to the right
//!   ────────┐  ^  ┌────────
//!        NL │  S  │ NR          near line, level with the front sonar
//! ```
//!
//! * a corner that is gone round, or an edge: half a metre before it, as the front sonar sees it when it follows the wall to it;
//! * a corner that is gone into: a metre before the wall opposite;
//! * a wall: in the middle of the place.
//!
//! The ways out are left, ahead and right; a robot stands in one when its rear sonar is level with the place's edge.

use std::f64::consts::FRAC_PI_2;

use orienteer_runtime::{
    geometry::Pose,
    robot_model::Ring,
    topics::{FeatureKind, FeatureSearch, Side, Way},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where about a place, as seen from its start pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(from = "Spot", into = "Spot")]
pub enum Whereabouts {
    /// Where the robot's own corridor ends, to a side.
    Near(Side),
    /// Where the way ahead begins, to a side.
    Far(Side),
    /// To a side, where a way could branch off.
    Beside(Side),
    /// Ahead, where the corridor could go on.
    Ahead,
}

impl Whereabouts {
    /// True if there can be such a feature: a wall or a concave corner is beside or ahead, a convex corner or an edge near or far.
    #[must_use]
    pub fn may_hold(self, kind: FeatureKind) -> bool {
        match self {
            Self::Near(_) | Self::Far(_) => matches!(kind, FeatureKind::Convex | FeatureKind::Edge),
            Self::Beside(_) => matches!(kind, FeatureKind::Wall | FeatureKind::Concave),
            Self::Ahead => kind == FeatureKind::Wall,
        }
    }
}

/// [`Whereabouts`] as a file has them: one word each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Spot {
    /// Where the robot's own corridor ends, on the left.
    NearLeft,
    /// Where the robot's own corridor ends, on the right.
    NearRight,
    /// Where the way ahead begins, on the left.
    FarLeft,
    /// Where the way ahead begins, on the right.
    FarRight,
    /// To the left, where a way could branch off.
    Left,
    /// To the right, where a way could branch off.
    Right,
    /// Ahead, where the corridor could go on.
    Ahead,
}

impl From<Spot> for Whereabouts {
    fn from(spot: Spot) -> Self {
        match spot {
            Spot::NearLeft => Self::Near(Side::Left),
            Spot::NearRight => Self::Near(Side::Right),
            Spot::FarLeft => Self::Far(Side::Left),
            Spot::FarRight => Self::Far(Side::Right),
            Spot::Left => Self::Beside(Side::Left),
            Spot::Right => Self::Beside(Side::Right),
            Spot::Ahead => Self::Ahead,
        }
    }
}

impl From<Whereabouts> for Spot {
    fn from(whereabouts: Whereabouts) -> Self {
        match whereabouts {
            Whereabouts::Near(Side::Left) => Self::NearLeft,
            Whereabouts::Near(Side::Right) => Self::NearRight,
            Whereabouts::Far(Side::Left) => Self::FarLeft,
            Whereabouts::Far(Side::Right) => Self::FarRight,
            Whereabouts::Beside(Side::Left) => Self::Left,
            Whereabouts::Beside(Side::Right) => Self::Right,
            Whereabouts::Ahead => Self::Ahead,
        }
    }
}

/// Half a metre before a corner.
const BEFORE_A_CORNER: f64 = 0.50;
/// A metre before the wall that makes a corner.
const BEFORE_A_WALL: f64 = 1.00;
/// How far off a feature may be along a wall, m.
const ERROR: f64 = 0.30;

/// The corridor and the robot, by which places are reckoned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reckoning {
    /// Width of the corridor, and of what branches off, m.
    pub width: f64,
    /// How far the sonars' faces are from the robot's centre, m.
    pub face: f64,
}

impl Reckoning {
    /// By the ring that a robot wears.
    #[must_use]
    pub fn new(width: f64, ring: &Ring) -> Self {
        let front = ring.nearest_to(0.0).and_then(|front| ring.transducers.get(front));
        Self { width, face: front.map_or(0.0, |front| front.mount.x.hypot(front.mount.y)) }
    }

    /// The middle of the place, from the start pose `from`; heading as there.
    #[must_use]
    pub fn middle(&self, from: Pose) -> Pose {
        from.then(Pose::new(self.face + 0.5 * self.width, 0.0, 0.0))
    }

    /// Where a robot stands when it has left the place that way, facing along it: its rear sonar level with the edge of the place.
    #[must_use]
    pub fn port(&self, way: Way, from: Pose) -> Pose {
        let heading = match way {
            Way::Left => FRAC_PI_2,
            Way::Ahead => 0.0,
            Way::Right => -FRAC_PI_2,
        };
        let out = Pose::new(0.5 * self.width + self.face, 0.0, 0.0);
        self.middle(from).then(Pose::new(0.0, 0.0, heading)).then(out)
    }

    /// How to look for a feature there, from the start pose `from` (map frame). `None` where there can't be such a feature: a wall or a
    /// concave corner is beside or ahead, a convex corner or an edge is near or far.
    ///
    /// ```
    /// use orienteer_agents::places::{Reckoning, Whereabouts};
    /// use orienteer_runtime::{geometry::Pose, topics::{FeatureKind, Side}};
    ///
    /// let huey = Reckoning { width: 1.12, face: 0.08 };
    /// let near = Whereabouts::Near(Side::Right);
    /// let search = huey.search(FeatureKind::Convex, near, Pose::default()).unwrap();
    /// assert!((search.at.x - -0.50).abs() < 1e-9 && search.at.y == 0.0);
    /// assert_eq!(huey.search(FeatureKind::Wall, near, Pose::default()), None);
    /// ```
    #[must_use]
    pub fn search(&self, kind: FeatureKind, whereabouts: Whereabouts, from: Pose) -> Option<FeatureSearch> {
        use FeatureKind::{Concave, Convex, Edge, Wall};
        use Whereabouts::{Ahead, Beside, Far, Near};
        // Along the corridor, from the robot's centre: the near line, the middle of the place, the far line.
        let (near, half) = (self.face, 0.5 * self.width);
        let (middle, far, short) = (near + half, near + self.width, self.face + BEFORE_A_CORNER);
        let facing = |side: Side| side.sign() * FRAC_PI_2;
        let (at, side, forward_first) = match (kind, whereabouts) {
            (Convex | Edge, Near(side)) => (Pose::new(near - short, 0.0, facing(side)), side, false),
            (Convex, Far(side)) => (Pose::new(middle, side.sign() * (half + short), 0.0), side, true),
            // From beyond it, so the wall is kept on the other side.
            (Edge, Far(side)) => (Pose::new(far + short, 0.0, facing(side)), side.other(), false),
            (Wall, Beside(side)) => (Pose::new(middle, 0.0, facing(side)), Side::Left, false),
            (Wall, Ahead) => (Pose::new(middle, 0.0, 0.0), Side::Left, false),
            (Concave, Beside(side)) => (Pose::new(far - BEFORE_A_WALL - self.face, 0.0, facing(side)), side, false),
            _ => return None,
        };
        Some(FeatureSearch { kind, side, forward_first, at: from.then(at), error: ERROR })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Ports of the listing: 64 cm to either side, 128 cm ahead.
    #[test]
    fn ways_out_are_where_the_listing_has_them() {
        let huey = Reckoning { width: 1.12, face: 0.08 };
        let expected =
            [(Way::Left, (0.64, 0.64, FRAC_PI_2)), (Way::Ahead, (1.28, 0.0, 0.0)), (Way::Right, (0.64, -0.64, -FRAC_PI_2))];
        for (way, (x, y, heading)) in expected {
            let port = huey.port(way, Pose::default());
            assert!(port.distance(&Pose::new(x, y, 0.0)) < 1e-9 && (port.heading - heading).abs() < 1e-9, "{way:?}: {port:?}");
        }
    }

    /// The table of the listing: cm to the right and ahead, degrees clockwise, for a corridor of 1.12 m.
    #[test]
    fn in_hueys_corridor_all_is_where_the_listing_has_it() {
        use FeatureKind::{Concave, Convex, Edge, Wall};
        use Side::{Left, Right};
        use Whereabouts::{Ahead, Beside, Far, Near};
        let reckoning = Reckoning { width: 1.12, face: 0.08 };
        let table = [
            (Convex, Near(Right), (0, -50), 90, Right),
            (Edge, Near(Right), (0, -50), 90, Right),
            (Convex, Near(Left), (0, -50), -90, Left),
            (Edge, Near(Left), (0, -50), -90, Left),
            (Convex, Far(Right), (114, 64), 0, Right),
            (Convex, Far(Left), (-114, 64), 0, Left),
            (Edge, Far(Right), (0, 178), 90, Left),
            (Edge, Far(Left), (0, 178), -90, Right),
            (Wall, Beside(Left), (0, 64), -90, Left),
            (Wall, Beside(Right), (0, 64), 90, Left),
            (Wall, Ahead, (0, 64), 0, Left),
            (Concave, Beside(Left), (0, 12), -90, Left),
            (Concave, Beside(Right), (0, 12), 90, Right),
        ];
        for (kind, whereabouts, (right, ahead), clockwise, side) in table {
            let search = reckoning.search(kind, whereabouts, Pose::default()).unwrap();
            let at = Pose::new(0.01 * f64::from(ahead), -0.01 * f64::from(right), -f64::from(clockwise).to_radians());
            assert!(
                search.at.distance(&at) < 1e-9 && (search.at.heading - at.heading).abs() < 1e-9,
                "{kind:?} {whereabouts:?}: {search:?}"
            );
            assert_eq!(search.side, side, "{kind:?} {whereabouts:?}");
        }
    }
}
