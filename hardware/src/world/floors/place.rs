//! Places of a floor, as they truly are.

use nalgebra::Point2;
use orienteer_runtime::geometry::Pose;
use serde::{Deserialize, Serialize};

use super::{Flank, Heading, Hypothesis, View, frame::NEAR_LINE, mm};

/// Where something is to be found out: corridors meet or end, or doorways open beside one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Its name, also in the world file.
    pub name: String,
    /// Where the centre lines meet, or the middle between the jambs; at a dead end half a corridor's width before the end wall. m.
    pub at: [f64; 2],
    /// Corridors that lead away, counter-clockwise from the east.
    pub arms: Vec<Arm>,
    /// Doorways beside the corridor, none at places where corridors meet.
    pub doorways: Vec<Doorway>,
}

/// A corridor that leads away from a place, and what the place is for a robot that comes along it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Arm {
    /// Where it leads.
    pub heading: Heading,
    /// From wall to wall, m.
    pub width: f64,
    /// How far from the place's middle the walls on both sides begin, m.
    pub mouth: f64,
    /// What a robot meets that arrives here.
    pub meets: Hypothesis,
    /// Where such a robot stops to explore the place: in the middle of the corridor, its foremost sonar level with the near
    /// line (Randazza 1989); at a dead end in the middle of the place. m and rad.
    pub start: Pose,
}

/// An opening beside a corridor, with a room behind it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Doorway {
    /// Its middle, in the corridor's wall, m.
    pub at: [f64; 2],
    /// On which side of the corridor it is: the heading out of the corridor.
    pub side: Heading,
    /// From jamb to jamb, m.
    pub width: f64,
    /// The jamb in this direction is the end of a thin wall, with the room behind it.
    pub edge: Heading,
    /// The jamb in this direction is a corner: the wall goes on square to the corridor.
    pub corner: Heading,
    /// How thick the wall between corridor and room is, m.
    pub thickness: f64,
}

impl Place {
    /// A place from its arms, each with heading, width and mouth, and its doorways. `None` if it is none of the thirteen
    /// hypotheses from one of its arms.
    #[must_use]
    pub(super) fn new(at: Point2<f64>, arms: &[(Heading, f64, f64)], doorways: Vec<Doorway>) -> Option<Self> {
        let headings: Vec<Heading> = arms.iter().map(|(heading, ..)| *heading).collect();
        let arm = |&(heading, width, mouth): &(Heading, f64, f64)| {
            let meets = Hypothesis::of(view(&headings, &doorways, heading))?;
            let back = if meets == Hypothesis::DeadEnd { 0.0 } else { mouth + NEAR_LINE };
            let stop = at + heading.vector() * back;
            let start = Pose { x: mm(stop.x), y: mm(stop.y), heading: heading.back().radians() };
            Some(Arm { heading, width: mm(width), mouth: mm(mouth), meets, start })
        };
        let arms = arms.iter().map(arm).collect::<Option<_>>()?;
        Some(Self { name: String::new(), at: [mm(at.x), mm(at.y)], arms, doorways })
    }

    /// Its position as a point, m.
    #[must_use]
    pub fn point(&self) -> Point2<f64> {
        Point2::from(self.at)
    }

    /// The corridor that leads away toward this heading.
    #[must_use]
    pub fn arm(&self, heading: Heading) -> Option<&Arm> {
        self.arms.iter().find(|arm| arm.heading == heading)
    }

    /// What a robot meets here that arrives by the corridor in this direction; `None` if there is no such corridor.
    #[must_use]
    pub fn seen_from(&self, arm: Heading) -> Option<Hypothesis> {
        self.arm(arm).map(|arm| arm.meets)
    }
}

/// What a robot sees at the mouth of a place that has these corridors and doorways, when it comes from the one toward `from`.
fn view(corridors: &[Heading], doorways: &[Doorway], from: Heading) -> View {
    let ahead = from.back();
    let flank = |side: Heading| {
        if corridors.contains(&side) {
            return Flank::Corridor;
        }
        match doorways.iter().find(|doorway| doorway.side == side) {
            Some(doorway) if doorway.edge == from => Flank::EdgeThenCorner,
            Some(_) => Flank::CornerThenEdge,
            None => Flank::Wall,
        }
    };
    View { left: flank(ahead.left()), ahead: corridors.contains(&ahead), right: flank(ahead.right()) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use Heading::{East, North, South, West};

    use super::*;

    fn place(headings: &[Heading], doorways: Vec<Doorway>) -> Place {
        let arms: Vec<_> = headings.iter().map(|heading| (*heading, 1.12, 0.56)).collect();
        Place::new(Point2::new(3.0, 4.0), &arms, doorways).unwrap()
    }

    fn doorway(side: Heading, edge: Heading) -> Doorway {
        Doorway { at: [0.0, 0.0], side, width: 1.12, edge, corner: edge.back(), thickness: 0.14 }
    }

    #[test]
    fn a_t_is_three_things() {
        let place = place(&[East, North, West], vec![]);
        assert_eq!(place.seen_from(East), Some(Hypothesis::H1));
        assert_eq!(place.seen_from(West), Some(Hypothesis::H5));
        assert_eq!(place.seen_from(North), Some(Hypothesis::H11));
        assert_eq!(place.seen_from(South), None);
    }

    #[test]
    fn a_doorway_seen_from_behind_has_its_jambs_exchanged() {
        let there = place(&[North, South], vec![doorway(East, North)]);
        assert_eq!((there.seen_from(South), there.seen_from(North)), (Some(Hypothesis::H3), Some(Hypothesis::H7)));
        let both = place(&[North, South], vec![doorway(East, South), doorway(West, North)]);
        assert_eq!((both.seen_from(South), both.seen_from(North)), (Some(Hypothesis::H9), Some(Hypothesis::H9)));
    }

    #[test]
    fn robots_stop_before_the_near_line_and_at_the_middle_of_a_dead_end() {
        let bend = place(&[East, North], vec![]);
        let start = bend.arm(East).unwrap().start;
        assert_eq!((start.x, start.y, start.heading), (3.64, 4.0, West.radians()));
        let end = place(&[South], vec![]);
        let start = end.arm(South).unwrap().start;
        assert_eq!((end.seen_from(South), start.x, start.y), (Some(Hypothesis::DeadEnd), 3.0, 4.0));
    }

    #[test]
    fn a_plain_corridor_is_no_place() {
        assert!(Place::new(Point2::origin(), &[(East, 1.12, 0.0), (West, 1.12, 0.0)], vec![]).is_none());
    }
}
