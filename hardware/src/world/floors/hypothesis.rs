//! What a place can turn out to be for a robot that arrives at it.
//!
//! The twelve hypotheses are those of Randazza (1989), appendix A, in her order. Each says what lies to the left, ahead and to
//! the right of a robot that has stopped at the mouth of a place, so the same place is another hypothesis from another
//! corridor: a T is a branch to the right, a branch to the left, or met head-on.
//!
//! ```text
//!        H3: doorway right,             H4: doorway right,
//!        near corner, far edge          near edge, far corner
//!
//!           │   │ │  room                  │   │
//!           │   └─┘                        │   └──────
//!           │                              │
//!           │   ┌──────                    │   ┌─┐
//!           │ ▲ │                          │ ▲ │ │  room
//! ```
//!
//! A *doorway* is an opening beside the corridor that leads into a room and not into a corridor. One of its jambs is a
//! *corner*, where the wall goes on square to the corridor, as at the mouth of a corridor; the other is an *edge*, the end of
//! the thin wall between corridor and room.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

/// One side of a place, as a robot sees it that has just come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Flank {
    /// The wall of the corridor goes on.
    Wall,
    /// A corridor leads away.
    Corridor,
    /// A doorway, with the corner on the robot's side of it and the edge beyond.
    CornerThenEdge,
    /// A doorway, with the edge on the robot's side of it and the corner beyond.
    EdgeThenCorner,
}

/// What surrounds a robot that has stopped at the mouth of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct View {
    /// What is on the left.
    pub left: Flank,
    /// Whether the corridor goes on straight ahead.
    pub ahead: bool,
    /// What is on the right.
    pub right: Flank,
}

/// What a place is from where a robot comes: one of the twelve of Randazza (1989), or the end of a corridor, which she leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Hypothesis {
    /// T, branch right.
    H1,
    /// L right.
    H2,
    /// Doorway right, near corner and far edge.
    H3,
    /// Doorway right, near edge and far corner.
    H4,
    /// T, branch left.
    H5,
    /// L left.
    H6,
    /// Doorway left, near edge and far corner.
    H7,
    /// Doorway left, near corner and far edge.
    H8,
    /// Doorways on both sides: left near corner and far edge, right near edge and far corner.
    H9,
    /// Doorways on both sides: left near edge and far corner, right near corner and far edge.
    H10,
    /// T, met head-on.
    H11,
    /// Intersection.
    H12,
    /// The corridor ends.
    #[serde(rename = "dead-end")]
    DeadEnd,
}

impl Hypothesis {
    /// All of them, the dead end last.
    pub const ALL: [Self; 13] = [
        Self::H1,
        Self::H2,
        Self::H3,
        Self::H4,
        Self::H5,
        Self::H6,
        Self::H7,
        Self::H8,
        Self::H9,
        Self::H10,
        Self::H11,
        Self::H12,
        Self::DeadEnd,
    ];

    /// What the robot sees in it.
    #[must_use]
    pub const fn view(self) -> View {
        use Flank::{CornerThenEdge, Corridor, EdgeThenCorner, Wall};
        let (left, ahead, right) = match self {
            Self::H1 => (Wall, true, Corridor),
            Self::H2 => (Wall, false, Corridor),
            Self::H3 => (Wall, true, CornerThenEdge),
            Self::H4 => (Wall, true, EdgeThenCorner),
            Self::H5 => (Corridor, true, Wall),
            Self::H6 => (Corridor, false, Wall),
            Self::H7 => (EdgeThenCorner, true, Wall),
            Self::H8 => (CornerThenEdge, true, Wall),
            Self::H9 => (CornerThenEdge, true, EdgeThenCorner),
            Self::H10 => (EdgeThenCorner, true, CornerThenEdge),
            Self::H11 => (Corridor, false, Corridor),
            Self::H12 => (Corridor, true, Corridor),
            Self::DeadEnd => (Wall, false, Wall),
        };
        View { left, ahead, right }
    }

    /// The hypothesis of which this is the view; `None` if it is none of the thirteen, a plain corridor for instance.
    ///
    /// ```
    /// use orienteer_hardware::world::floors::{Flank, Hypothesis, View};
    /// let view = View { left: Flank::Corridor, ahead: false, right: Flank::Corridor };
    /// assert_eq!(Hypothesis::of(view), Some(Hypothesis::H11));
    /// ```
    #[must_use]
    pub fn of(view: View) -> Option<Self> {
        Self::ALL.into_iter().find(|hypothesis| hypothesis.view() == view)
    }

    /// `H1` … `H12`, or `dead-end`, as configurations and ground truths write it.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::H1 => "H1",
            Self::H2 => "H2",
            Self::H3 => "H3",
            Self::H4 => "H4",
            Self::H5 => "H5",
            Self::H6 => "H6",
            Self::H7 => "H7",
            Self::H8 => "H8",
            Self::H9 => "H9",
            Self::H10 => "H10",
            Self::H11 => "H11",
            Self::H12 => "H12",
            Self::DeadEnd => "dead-end",
        }
    }

    /// What a person calls it.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::H1 => "T, branch right",
            Self::H2 => "L right",
            Self::H3 => "doorway right, near corner and far edge",
            Self::H4 => "doorway right, near edge and far corner",
            Self::H5 => "T, branch left",
            Self::H6 => "L left",
            Self::H7 => "doorway left, near edge and far corner",
            Self::H8 => "doorway left, near corner and far edge",
            Self::H9 => "doorways on both sides, far edge left and near edge right",
            Self::H10 => "doorways on both sides, near edge left and far edge right",
            Self::H11 => "T, met head-on",
            Self::H12 => "intersection",
            Self::DeadEnd => "dead end",
        }
    }
}

impl fmt::Display for Hypothesis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

impl FromStr for Hypothesis {
    type Err = String;

    /// Reads an [`id`](Hypothesis::id); capitals don't matter.
    fn from_str(text: &str) -> Result<Self, String> {
        let meant = |hypothesis: &Self| hypothesis.id().eq_ignore_ascii_case(text);
        Self::ALL.into_iter().find(meant).ok_or_else(|| "H1 to H12 or dead-end is needed".to_owned())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn no_two_look_alike() {
        let views: HashSet<View> = Hypothesis::ALL.into_iter().map(Hypothesis::view).collect();
        assert_eq!(views.len(), 13);
        let corridor = View { left: Flank::Wall, ahead: true, right: Flank::Wall };
        assert_eq!(Hypothesis::of(corridor), None);
    }

    #[test]
    fn left_and_right_ones_are_mirror_images() {
        use Hypothesis::{DeadEnd, H1, H2, H3, H4, H5, H6, H7, H8, H9, H10, H11, H12};
        let pairs = [(H1, H5), (H2, H6), (H3, H8), (H4, H7), (H9, H10), (H11, H11), (H12, H12), (DeadEnd, DeadEnd)];
        for (one, other) in pairs {
            let View { left, ahead, right } = one.view();
            assert_eq!(Hypothesis::of(View { left: right, ahead, right: left }), Some(other), "{one}");
        }
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        for hypothesis in Hypothesis::ALL {
            assert_eq!(hypothesis.id().to_lowercase().parse(), Ok(hypothesis));
            assert_eq!(serde_json::to_value(hypothesis).unwrap(), hypothesis.id());
        }
        assert!("H13".parse::<Hypothesis>().is_err() && "".parse::<Hypothesis>().is_err());
    }
}
