//! Corridors as robots need them that keep out of each other's way: also those of which nobody knows where they end.

use nalgebra::{Point2, Vector2};

use super::Presence;
use crate::geographer::map::{Arm, Exit, TopologicalMap};

/// What is no farther from a corridor's middle is in it, m.
pub(super) const HALF: f64 = 0.8;
/// A corridor is not longer than this, unless it is known to be, m.
const LONGEST: f64 = 20.0;
/// Two corridors that nobody has gone may meet so far from where they begin, m.
const CROSSING: f64 = 12.0;
/// Nearer than this there is no other place, m.
const NEAREST: f64 = 1.0;

/// A corridor, as far as it is known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lane {
    from: Point2<f64>,
    /// Unit vector.
    along: Vector2<f64>,
    /// At most, m.
    length: f64,
    /// Where it ends, or may end.
    pub end: Option<Exit>,
    /// Somebody has gone it.
    is_known: bool,
}

impl Lane {
    /// What lies behind an arm. A corridor that nobody has gone may lead to the next place straight ahead that has an arm toward it.
    pub fn of(map: &TopologicalMap, exit: Exit) -> Option<Self> {
        let (at, heading) = (map.place(exit.0)?.at, map.compass()?.heading(exit.1));
        let along = Vector2::new(heading.cos(), heading.sin());
        let lane = Self { from: at, along, length: LONGEST, end: None, is_known: false };
        if let Some((length, end)) = map.corridor(exit) {
            return Some(Self { length, end: Some(end), is_known: true, ..lane });
        }
        let straight_ahead = map.places().filter(|(_, place)| lane.offset(place.at).is_some_and(|along| along > NEAREST));
        let distance = |place: &Point2<f64>| (place - at).dot(&along);
        let next = straight_ahead.min_by(|a, b| distance(&a.1.at).total_cmp(&distance(&b.1.at)));
        let Some((next, place)) = next else { return Some(lane) };
        let arm = exit.1.back();
        let end = (place.arms[arm.index()] != Arm::Closed).then_some((next, arm));
        Some(Self { length: distance(&place.at), end, ..lane })
    }

    /// How far along it a point is, m, if it is in it.
    fn offset(&self, point: Point2<f64>) -> Option<f64> {
        let to = point - self.from;
        let (along, across) = (to.dot(&self.along), to.perp(&self.along));
        (across.abs() < HALF && (0.0..self.length).contains(&along)).then_some(along)
    }

    /// True if this point is in it, and not at its beginning.
    pub fn has(&self, point: Point2<f64>) -> bool {
        self.offset(point).is_some_and(|along| along > 0.5 * NEAREST)
    }

    /// True if a robot is in it, or at its end.
    pub fn holds(&self, mate: &Presence) -> bool {
        let at_its_end = self.end.is_some_and(|(end, _)| mate.at == Some(end));
        at_its_end || self.has(mate.pose.point()) || mate.spot.is_some_and(|spot| self.has(spot))
    }

    /// True if who goes the one may meet who goes the other.
    pub fn meets(&self, other: &Option<Self>, mine: Exit, theirs: Exit) -> bool {
        let Some(other) = other else { return false };
        let same = mine == theirs || self.end == Some(theirs) || other.end == Some(mine);
        let same_end = self.end.zip(other.end).is_some_and(|(a, b)| a.0 == b.0);
        same || same_end || (!self.is_known && !other.is_known && self.crosses(other))
    }

    /// True if somebody who goes the one and somebody who goes the other may come to the same place.
    fn crosses(&self, other: &Self) -> bool {
        let turn = self.along.perp(&other.along);
        if turn.abs() < 0.5 {
            return false;
        }
        let between = other.from - self.from;
        let (mine, theirs) = (between.perp(&other.along) / turn, between.perp(&self.along) / turn);
        let reach = |lane: &Self| NEAREST..lane.length.min(CROSSING);
        reach(self).contains(&mine) && reach(other).contains(&theirs)
    }
}
