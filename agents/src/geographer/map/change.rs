//! Changes of the map: what robots of a team tell each other, so that all of them have the same map.
//!
//! Each robot applies all changes, its own among them, in the order in which it hears them, and that order is the same for all. So a place has the same number and name
//! for everyone.

use nalgebra::{Matrix2, Point2};
use orienteer_runtime::{
    time::Time,
    topics::{Label, PlacesChange},
};
use petgraph::graph::NodeIndex;

use super::{Arm, Exit, Place, TopologicalMap};
use crate::geographer::compass::Quarter;

/// [`PlacesChange::what`], by kind of change.
const DIRECTION: u32 = 1;
const FOUND: u32 = 2;
const SEEN_AGAIN: u32 = 3;
const JOINED: u32 = 4;
const GIVEN_UP: u32 = 5;
const RENAMED: u32 = 6;

/// A change of the map.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// The floor's first direction, rad. Only the first one that is said counts.
    Compass(f64),
    /// A place nobody has been to. Its name is the map's matter.
    Found(Place),
    /// A known place is something else than it was thought to be.
    Renamed {
        /// Which one.
        place: NodeIndex,
        /// What it is. Where and how often it was seen do not matter.
        to: Place,
    },
    /// A known place was come to again, and its middle was there.
    SeenAgain {
        /// Which one.
        place: NodeIndex,
        /// Where, map frame, m.
        at: Point2<f64>,
        /// Covariance of `at`, m².
        covariance: Matrix2<f64>,
    },
    /// A corridor was gone from one end to the other.
    Joined {
        /// Where it was entered.
        from: Exit,
        /// Where it was left.
        to: Exit,
        /// From middle to middle, m.
        length: f64,
    },
    /// An arm could not be gone.
    GivenUp(Exit),
}

/// What came of a change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effect {
    /// The place that it is about.
    pub place: Option<NodeIndex>,
    /// There is a place, a corridor or a way more than before, or one less.
    pub is_news: bool,
}

/// Nearer to each other than this two places are one: two robots have found it at the same time, m.
const ONE: f64 = 1.0;

impl TopologicalMap {
    /// Makes a change. `None` if it names places that are not there: it changes nothing.
    pub fn apply(&mut self, change: Change) -> Option<Effect> {
        let known = |place: NodeIndex| self.place(place).map(|_| place);
        let (place, is_news) = match change {
            Change::Compass(heading) => return Some(Effect { place: None, is_news: self.set_compass(heading) }),
            Change::Found(place) => {
                let same = self.places().find(|(_, known)| (known.at - place.at).norm() < ONE).map(|(known, _)| known);
                if let Some(known) = same {
                    self.seen_again(known, place.at, &place.covariance);
                }
                (same.unwrap_or_else(|| self.add(place)), same.is_none())
            }
            Change::Renamed { place, to } => (known(place)?, self.rename(place, to)),
            Change::SeenAgain { place, at, covariance } => {
                let place = known(place)?;
                self.seen_again(place, at, &covariance);
                (place, false)
            }
            Change::Joined { from, to, length } => {
                known(from.0).and(known(to.0))?;
                (to.0, self.join(from, to, length))
            }
            Change::GivenUp((place, arm)) => (known(place)?, self.give_up(place, arm)),
        };
        Some(Effect { place: Some(place), is_news })
    }
}

impl Change {
    /// As others hear it; `number` counts the robot's changes.
    #[must_use]
    pub fn told(&self, stamp: Time, number: u32) -> PlacesChange {
        let told = PlacesChange { stamp, number, ..PlacesChange::default() };
        let index = |place: NodeIndex| place.index() as u32;
        let arm = |arm: Quarter| arm.index() as u32;
        match self {
            Self::Compass(heading) => PlacesChange { what: DIRECTION, heading: *heading, ..told },
            Self::Found(place) => PlacesChange { what: FOUND, ..named(place, told) },
            Self::Renamed { place, to } => PlacesChange { what: RENAMED, place: index(*place), ..named(to, told) },
            Self::SeenAgain { place, at, covariance } => {
                PlacesChange { what: SEEN_AGAIN, place: index(*place), at: (*at).into(), covariance: packed(covariance), ..told }
            }
            Self::Joined { from, to, length } => PlacesChange {
                what: JOINED,
                place: index(from.0),
                arm: arm(from.1),
                to: index(to.0),
                to_arm: arm(to.1),
                length: *length,
                ..told
            },
            Self::GivenUp((place, given_up)) => {
                PlacesChange { what: GIVEN_UP, place: index(*place), arm: arm(*given_up), ..told }
            }
        }
    }

    /// What was heard; `None` if it says nothing, or what can't be: one number that is none would spoil the map of all.
    #[must_use]
    pub fn heard(told: &PlacesChange) -> Option<Self> {
        let numbers = [told.length, told.heading, told.belief].into_iter().chain(told.at).chain(told.covariance);
        if !numbers.into_iter().all(f64::is_finite) || told.length < 0.0 {
            return None;
        }
        let quarter = |arm: u32| Quarter::ALL.get(arm as usize).copied();
        let place = |number: u32| NodeIndex::new(number as usize);
        let exit = |number: u32, arm: u32| Some((place(number), quarter(arm)?));
        let (at, covariance) = (Point2::from(told.at), unpacked(told.covariance));
        Some(match told.what {
            DIRECTION => Self::Compass(told.heading),
            FOUND => Self::Found(place_of(told)?),
            RENAMED => Self::Renamed { place: place(told.place), to: place_of(told)? },
            SEEN_AGAIN => Self::SeenAgain { place: place(told.place), at, covariance },
            JOINED => Self::Joined { from: exit(told.place, told.arm)?, to: exit(told.to, told.to_arm)?, length: told.length },
            GIVEN_UP => Self::GivenUp(exit(told.place, told.arm)?),
            _ => return None,
        })
    }
}

/// What is told of a place.
fn named(place: &Place, told: PlacesChange) -> PlacesChange {
    PlacesChange {
        at: place.at.into(),
        covariance: packed(&place.covariance),
        seen: place.seen.index() as u32,
        ways: (0..4).filter(|arm| place.arms[*arm] != Arm::Closed).map(|arm| 1 << arm).sum(),
        belief: place.belief,
        kind: Label::new(&place.kind),
        title: Label::new(&place.title),
        ..told
    }
}

/// A place as it was told.
fn place_of(told: &PlacesChange) -> Option<Place> {
    let way = |arm: Quarter| if told.ways & (1 << arm.index()) == 0 { Arm::Closed } else { Arm::Unexplored };
    Some(Place {
        name: String::new(),
        at: Point2::from(told.at),
        covariance: unpacked(told.covariance),
        kind: told.kind.to_string(),
        title: told.title.to_string(),
        belief: told.belief,
        seen: *Quarter::ALL.get(told.seen as usize)?,
        arms: Quarter::ALL.map(way),
        visits: 1,
    })
}

fn packed(covariance: &Matrix2<f64>) -> [f64; 3] {
    [covariance.m11, covariance.m12, covariance.m22]
}

fn unpacked([xx, xy, yy]: [f64; 3]) -> Matrix2<f64> {
    Matrix2::new(xx, xy, xy, yy)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn found(x: f64) -> Place {
        Place {
            name: String::new(),
            at: Point2::new(x, 2.0),
            covariance: Matrix2::new(0.04, 0.01, 0.01, 0.09),
            kind: "H4".into(),
            title: "T, branch right".into(),
            belief: 0.97,
            seen: Quarter::ALL[1],
            arms: [Arm::Unexplored, Arm::Closed, Arm::Closed, Arm::Unexplored],
            visits: 1,
        }
    }

    #[test]
    fn changes_come_out_as_they_went_in() {
        let (a, b) = (NodeIndex::new(0), NodeIndex::new(7));
        let changes = [
            Change::Compass(0.3),
            Change::Found(found(1.0)),
            Change::SeenAgain { place: b, at: Point2::new(1.0, -2.0), covariance: Matrix2::new(0.1, 0.02, 0.02, 0.3) },
            Change::Joined { from: (a, Quarter::ALL[3]), to: (b, Quarter::ALL[1]), length: 4.5 },
            Change::GivenUp((b, Quarter::ALL[2])),
            Change::Renamed { place: b, to: found(3.0) },
        ];
        for change in changes {
            assert_eq!(Change::heard(&change.told(Time::START, 1)), Some(change));
        }
        assert_eq!(Change::heard(&PlacesChange::default()), None);
    }

    #[test]
    fn what_is_no_number_changes_nothing() {
        let told = Change::Found(found(1.0)).told(Time::START, 1);
        assert!(Change::heard(&told).is_some());
        let nan = f64::NAN;
        for spoilt in [
            PlacesChange { at: [nan, 0.0], ..told },
            PlacesChange { covariance: [0.1, nan, 0.1], ..told },
            PlacesChange { belief: nan, ..told },
            PlacesChange { length: f64::INFINITY, ..told },
            PlacesChange { length: -1.0, ..told },
            PlacesChange { heading: nan, ..told },
        ] {
            assert_eq!(Change::heard(&spoilt), None, "{spoilt:?}");
        }
    }

    #[test]
    fn what_names_places_that_are_not_there_changes_nothing() {
        let mut map = TopologicalMap::default();
        let nowhere = (NodeIndex::new(9), Quarter::ALL[0]);
        assert_eq!(map.apply(Change::Joined { from: nowhere, to: nowhere, length: 1.0 }), None);
        assert_eq!(map.apply(Change::GivenUp(nowhere)), None);
        let again = Change::SeenAgain { place: nowhere.0, at: Point2::origin(), covariance: Matrix2::identity() };
        assert_eq!(map.apply(again), None);
        assert_eq!(map.apply(Change::Renamed { place: nowhere.0, to: found(1.0) }), None);
        assert_eq!((map.places().len(), map.corridors().count()), (0, 0));
    }

    #[test]
    fn a_place_that_is_something_else_keeps_the_corridors_that_were_gone() {
        let mut map = TopologicalMap::default();
        let a = place(&mut map, 1.0);
        let b = place(&mut map, 9.0);
        map.apply(Change::Joined { from: (a, Quarter::ALL[0]), to: (b, Quarter::ALL[2]), length: 8.0 });
        let to = Place { arms: [Arm::Closed, Arm::Unexplored, Arm::Closed, Arm::Closed], kind: "H2".into(), ..found(50.0) };
        map.apply(Change::Renamed { place: a, to });
        let place = map.place(a).unwrap();
        assert!(matches!(place.arms, [Arm::Leads, Arm::Unexplored, Arm::Closed, Arm::Closed]), "{:?}", place.arms);
        assert_eq!((place.kind.as_str(), place.at, place.name.as_str()), ("H2", Point2::new(1.0, 2.0), "A"));
    }

    #[test]
    fn a_place_that_two_have_found_at_once_is_one() {
        let mut map = TopologicalMap::default();
        let first = map.apply(Change::Found(found(1.0))).unwrap();
        assert!(first.is_news);
        let same = map.apply(Change::Found(found(1.4))).unwrap();
        assert_eq!(same, Effect { is_news: false, ..first });
        assert_ne!(place(&mut map, 4.0), first.place.unwrap());
        assert_eq!(map.places().len(), 2);
    }

    #[test]
    fn only_what_there_is_to_explore_is_news() {
        let mut map = TopologicalMap::default();
        let (a, b) = (place(&mut map, 1.0), place(&mut map, 9.0));
        let joined = Change::Joined { from: (a, Quarter::ALL[0]), to: (b, Quarter::ALL[2]), length: 8.0 };
        let again = Change::SeenAgain { place: a, at: Point2::new(1.0, 2.1), covariance: Matrix2::identity() };
        let closed = Change::GivenUp((a, Quarter::ALL[1]));
        let given_up = Change::GivenUp((a, Quarter::ALL[3]));
        let same = Change::Renamed { place: a, to: found(1.0) };
        for (change, is_news) in
            [(joined.clone(), true), (joined, false), (again, false), (closed, false), (given_up, true), (same, false)]
        {
            assert_eq!(map.apply(change.clone()).map(|effect| effect.is_news), Some(is_news), "{change:?}");
        }
    }

    /// Adds a place to a map.
    fn place(map: &mut TopologicalMap, x: f64) -> NodeIndex {
        map.apply(Change::Found(found(x))).unwrap().place.unwrap()
    }
}
