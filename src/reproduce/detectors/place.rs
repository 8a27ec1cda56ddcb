//! The worlds of the twelve places that Randazza (1989) names, one place in each.
//!
//! The robot comes up a corridor along y and stands at the origin; the near line is 8 cm before it. Everything that branches off is 7 m long, so that
//! ends do not matter; a doorway leads into a room behind a wall 14 cm thick.

use std::fmt::Write as _;

use crate::{
    agents::feature_detector::Whereabouts,
    runtime::topics::{FeatureKind, Side},
};

/// What a place has on one side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Branch {
    /// A wall.
    None,
    /// A corridor.
    Corridor,
    /// A doorway, with a corner at its near or its far end and a thin wall at the other.
    Doorway { corner_is_near: bool },
}

/// One of the twelve places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    /// Its number, 1 to 12.
    pub number: u32,
    /// The corridor goes on.
    ahead: bool,
    left: Branch,
    right: Branch,
}

const CORRIDOR: Branch = Branch::Corridor;
const CORNER_NEAR: Branch = Branch::Doorway { corner_is_near: true };
const CORNER_FAR: Branch = Branch::Doorway { corner_is_near: false };

const fn place(number: u32, ahead: bool, left: Branch, right: Branch) -> Place {
    Place { number, ahead, left, right }
}

/// All twelve, in order.
pub(super) const PLACES: [Place; 12] = [
    place(1, true, Branch::None, CORRIDOR),
    place(2, false, Branch::None, CORRIDOR),
    place(3, true, Branch::None, CORNER_NEAR),
    place(4, true, Branch::None, CORNER_FAR),
    place(5, true, CORRIDOR, Branch::None),
    place(6, false, CORRIDOR, Branch::None),
    place(7, true, CORNER_FAR, Branch::None),
    place(8, true, CORNER_NEAR, Branch::None),
    place(9, true, CORNER_NEAR, CORNER_FAR),
    place(10, true, CORNER_FAR, CORNER_NEAR),
    place(11, false, CORRIDOR, CORRIDOR),
    place(12, true, CORRIDOR, CORRIDOR),
];

/// The features that the detectors are asked for, with the listing's names for them.
pub(super) const FEATURES: [(&str, FeatureKind, Whereabouts); 13] = {
    use FeatureKind::{Concave, Convex, Edge, Wall};
    use Side::{Left, Right};
    use Whereabouts::{Ahead, Beside, Far, Near};
    [
        ("NRC", Convex, Near(Right)),
        ("NRE", Edge, Near(Right)),
        ("NLC", Convex, Near(Left)),
        ("NLE", Edge, Near(Left)),
        ("FRC", Convex, Far(Right)),
        ("FLC", Convex, Far(Left)),
        ("FRE", Edge, Far(Right)),
        ("FLE", Edge, Far(Left)),
        ("WL", Wall, Beside(Left)),
        ("WR", Wall, Beside(Right)),
        ("WA", Wall, Ahead),
        ("KL", Concave, Beside(Left)),
        ("KR", Concave, Beside(Right)),
    ]
};

/// The lengths of a world, m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lengths {
    /// Of the corridor that the robot comes along.
    pub corridor: f64,
    /// Of what branches off: a corridor's width, a doorway's.
    pub branch: f64,
}

/// Randazza's corridors.
pub(super) const NOMINAL: Lengths = Lengths { corridor: 1.12, branch: 1.12 };

/// Where the near line is, m from the robot.
const NEAR: f64 = 0.08;
const THICK: f64 = 0.14;
const FAR_END: f64 = 7.0;
/// How far a room reaches beyond the doorway on the side of its thin wall, m.
const ROOM: f64 = 4.0;

impl Place {
    fn branch(&self, side: Side) -> Branch {
        match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
    }

    /// True if that feature belongs to this place.
    pub fn has(&self, kind: FeatureKind, whereabouts: Whereabouts) -> bool {
        let door = |side: Side| match self.branch(side) {
            Branch::Doorway { corner_is_near } => Some(corner_is_near),
            _ => None,
        };
        let corridor = |side: Side| self.branch(side) == CORRIDOR;
        match (kind, whereabouts) {
            (FeatureKind::Convex, Whereabouts::Near(side)) => corridor(side) || door(side) == Some(true),
            (FeatureKind::Convex, Whereabouts::Far(side)) => self.ahead && (corridor(side) || door(side) == Some(false)),
            (FeatureKind::Edge, Whereabouts::Near(side)) => door(side) == Some(false),
            (FeatureKind::Edge, Whereabouts::Far(side)) => door(side) == Some(true),
            (FeatureKind::Wall, Whereabouts::Beside(side)) => self.ahead && self.branch(side) == Branch::None,
            (FeatureKind::Wall, Whereabouts::Ahead) => !self.ahead && corridor(Side::Left) && corridor(Side::Right),
            (FeatureKind::Concave, Whereabouts::Beside(side)) => !self.ahead && self.branch(side) == Branch::None,
            _ => false,
        }
    }

    /// The world, as text.
    pub fn world(&self, lengths: Lengths) -> String {
        let Lengths { corridor, branch } = lengths;
        let (far, middle) = (NEAR + branch, NEAR + 0.5 * branch);
        let end = if self.ahead { FAR_END } else { far };
        let mut text = format!("[[corridor]]\nalong = [[0.0, {:?}], [0.0, {end:?}]]\nwidth = {corridor:?}\n", -FAR_END);
        for (side, sign) in [(Side::Left, -1.0), (Side::Right, 1.0)] {
            match self.branch(side) {
                Branch::None => {}
                Branch::Corridor => {
                    let _ = write!(
                        text,
                        "[[corridor]]\nalong = [[0.0, {middle:?}], [{:?}, {middle:?}]]\nwidth = {branch:?}\n",
                        sign * FAR_END
                    );
                }
                Branch::Doorway { corner_is_near } => {
                    let (from, to) = if corner_is_near { (NEAR, far + ROOM) } else { (NEAR - ROOM, far) };
                    let wall = sign * (0.5 * corridor + THICK);
                    let back = wall + sign * ROOM;
                    let _ = write!(
                        text,
                        "[[room]]\nname = \"{side:?}\"\ncorners = [[{:?}, {from:?}], [{:?}, {to:?}]]\n\
                         doors = [{{ at = [{wall:?}, {middle:?}], width = {branch:?} }}]\n",
                        wall.min(back),
                        wall.max(back)
                    );
                }
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_features_is_that_of_the_listing() {
        let expected = [
            "NRC FRC WL",
            "NRC KL",
            "NRC FRE WL",
            "NRE FRC WL",
            "NLC FLC WR",
            "NLC KR",
            "NLE FLC WR",
            "NLC FLE WR",
            "NRE NLC FRC FLE",
            "NRC NLE FLC FRE",
            "NRC NLC WA",
            "NRC NLC FRC FLC",
        ];
        for (place, expected) in PLACES.iter().zip(expected) {
            let has: Vec<_> = FEATURES.iter().filter(|(_, kind, at)| place.has(*kind, *at)).map(|(name, ..)| *name).collect();
            assert_eq!(has.join(" "), expected, "place {}", place.number);
        }
    }
}
