//! Those who explore the same floor, and who of them has the right of way.
//!
//! Two robots can't pass each other in a corridor. So, before it leaves a place, a robot says where it wants to go, and goes if nobody keeps it from that:
//!
//! * a place belongs to whoever is at it, until they have come to the next one;
//! * a corridor belongs to whoever went into it, and with it the place at its end;
//! * where the end of a corridor is not known, it may be any place that lies straight ahead, and two such corridors that cross may end at the same one;
//! * whoever wanted it earlier is first; of those who want it at once the one that comes first in the mission.
//!
//! All hear the same, so all decide alike. What can't be foreseen is left to the [stop line](Team::ahead): nobody comes nearer to a place at which another robot is.

use std::collections::BTreeMap;

use nalgebra::{Point2, Vector2};
use orienteer_runtime::{
    geometry::Pose,
    time::Time,
    topics::{NOWHERE, Whereabouts},
};
use petgraph::graph::NodeIndex;

use super::{
    compass::Quarter,
    map::{Arm, Corridor, Exit, TopologicalMap},
};

/// Who has not been heard of for so long holds nothing any more; their body is where it was, s.
const SILENT: f64 = 5.0;
/// Nobody comes nearer to another robot, or to a place where one is, along a corridor, m.
const STOP_LINE: f64 = 3.0;
/// What is no farther from a corridor's middle is in it, m.
const HALF: f64 = 0.8;
/// A corridor is not longer than this, unless it is known to be, m.
const LONGEST: f64 = 20.0;
/// Two corridors that nobody has gone may meet so far from where they begin, m.
const CROSSING: f64 = 12.0;
/// Nearer than this there is no other place, m.
const NEAREST: f64 = 1.0;

/// What a robot says of itself.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sign {
    /// Since when it goes, or wants to go, `way`.
    pub since: Time,
    /// Where it is, map frame.
    pub pose: Pose,
    /// Middle of the place that it is at, named or not, map frame, m.
    pub spot: Option<Point2<f64>>,
    /// The place that it is at, until it has come to the next.
    pub at: Option<NodeIndex>,
    /// The corridor that it is in, or wants to go into.
    pub way: Option<Exit>,
    /// What it goes to explore.
    pub goal: Option<Exit>,
    /// The robot that is in its way.
    pub held_up_by: Option<u32>,
    /// It has found nothing more to explore.
    pub is_idle: bool,
}

impl Sign {
    /// As others hear it.
    #[must_use]
    pub fn told(&self, stamp: Time) -> Whereabouts {
        let place = |place: NodeIndex| place.index() as u32;
        let exit = |exit: Option<Exit>| exit.map_or([NOWHERE; 2], |(at, arm)| [place(at), arm.index() as u32]);
        Whereabouts {
            stamp,
            since: self.since,
            pose: self.pose,
            spot: self.spot.unwrap_or_default().into(),
            has_spot: u32::from(self.spot.is_some()),
            at: self.at.map_or(NOWHERE, place),
            way: exit(self.way),
            goal: exit(self.goal),
            held_up_by: self.held_up_by.unwrap_or(NOWHERE),
            is_idle: u32::from(self.is_idle),
        }
    }

    /// What was heard.
    #[must_use]
    pub fn heard(told: &Whereabouts) -> Self {
        let known = |number: u32| (number != NOWHERE).then_some(number);
        let place = |number: u32| known(number).map(|number| NodeIndex::new(number as usize));
        let exit = |[at, arm]: [u32; 2]| Some((place(at)?, *Quarter::ALL.get(arm as usize)?));
        Self {
            since: told.since,
            pose: told.pose,
            spot: (told.has_spot == 1).then(|| Point2::from(told.spot)),
            at: place(told.at),
            way: exit(told.way),
            goal: exit(told.goal),
            held_up_by: known(told.held_up_by),
            is_idle: told.is_idle == 1,
        }
    }
}

/// What is known of those who explore the same floor.
#[derive(Debug, Clone, Default)]
pub struct Team {
    me: u32,
    /// What each robot said last, the robot itself among them, and when that was.
    signs: BTreeMap<u32, (Time, Sign)>,
}

impl Team {
    /// The team of the robot that has this place in the mission.
    #[must_use]
    pub fn of(me: u32) -> Self {
        Self { me, signs: BTreeMap::new() }
    }

    /// A robot has said where it is. Whoever has said nothing for long lets go of what it held.
    pub fn hear(&mut self, robot: u32, told: &Whereabouts) {
        self.signs.insert(robot, (told.stamp, Sign::heard(told)));
    }

    /// Time passes.
    pub fn settle(&mut self, now: Time) {
        for (_, sign) in self.signs.values_mut().filter(|(said, _)| now.since(*said).as_secs_f64() > SILENT) {
            *sign = Sign { pose: sign.pose, is_idle: true, ..Sign::default() };
        }
    }

    /// What the robot itself was heard to say.
    #[must_use]
    pub fn own(&self) -> Option<&Sign> {
        self.signs.get(&self.me).map(|(_, sign)| sign)
    }

    fn mates(&self) -> impl Iterator<Item = (u32, &Sign)> {
        self.signs.iter().filter(|(robot, _)| **robot != self.me).map(|(robot, (_, sign))| (*robot, sign))
    }

    /// Who keeps the robot, which has wanted it since then, from leaving by this way.
    #[must_use]
    pub fn in_the_way(&self, map: &TopologicalMap, exit: Exit, since: Time) -> Option<u32> {
        let mine = Stretch::of(map, exit)?;
        let keeps = |robot: u32, mate: &Sign| {
            let is_first = (mate.since, robot) < (since, self.me);
            let way = mate.way.filter(|_| is_first);
            mine.holds(mate) || way.is_some_and(|way| mine.meets(&Stretch::of(map, way), exit, way))
        };
        self.mates().find(|(robot, mate)| keeps(*robot, mate)).map(|(robot, _)| robot)
    }

    /// Who goes to explore this already.
    #[must_use]
    pub fn explores(&self, exit: Exit) -> Option<u32> {
        self.mates().find(|(_, mate)| mate.goal == Some(exit)).map(|(robot, _)| robot)
    }

    /// Who is in a corridor, or at one of its ends.
    #[must_use]
    pub fn is_in(&self, map: &TopologicalMap, corridor: &Corridor) -> Option<u32> {
        let is_in = |mate: &Sign| {
            let at_an_end = mate.at.is_some_and(|at| at == corridor.from.0 || at == corridor.to.0);
            at_an_end || Stretch::of(map, corridor.from).is_some_and(|stretch| stretch.has(mate.pose.point()))
        };
        self.mates().find(|(_, mate)| is_in(mate)).map(|(robot, _)| robot)
    }

    /// Who is so near ahead of the robot, or at a place so near ahead, that it has to wait. `here` is in the map frame, along the corridor.
    #[must_use]
    pub fn ahead(&self, here: Pose) -> Option<u32> {
        let is_ahead = |at: Point2<f64>| {
            let off = here.between(Pose::new(at.x, at.y, 0.0));
            (0.0..STOP_LINE).contains(&off.x) && off.y.abs() < HALF
        };
        let near = |mate: &Sign| is_ahead(mate.pose.point()) || mate.spot.is_some_and(is_ahead);
        self.mates().find(|(_, mate)| near(mate)).map(|(robot, _)| robot)
    }

    /// Where somebody is who waits for the robot to go away. A robot that has time makes way for all, of two who wait for each other the one that comes later in
    /// the mission.
    #[must_use]
    pub fn asks_to_go(&self, has_time: bool) -> Option<Point2<f64>> {
        let asks = |robot: u32, mate: &Sign| mate.held_up_by == Some(self.me) && (has_time || robot < self.me);
        self.mates().find(|(robot, mate)| asks(*robot, mate)).map(|(_, mate)| mate.pose.point())
    }

    /// True if that robot, met in a corridor, waits for this one as well, and comes before it in the mission.
    #[must_use]
    pub fn has_to_turn_back(&self, by: u32) -> bool {
        by < self.me && self.mates().any(|(robot, mate)| robot == by && mate.at.is_none() && mate.held_up_by == Some(self.me))
    }

    /// Who is at a place, or on the way there.
    #[must_use]
    pub fn comes_to(&self, map: &TopologicalMap, place: NodeIndex) -> Option<u32> {
        let ends_there = |way: Exit| Stretch::of(map, way).and_then(|stretch| stretch.end).is_some_and(|end| end.0 == place);
        let comes = |mate: &Sign| mate.at == Some(place) || mate.way.is_some_and(ends_there);
        self.mates().find(|(_, mate)| comes(mate)).map(|(robot, _)| robot)
    }

    /// True for the first of those who have the map: what all would say need be said once.
    #[must_use]
    pub fn speaks_for_all(&self) -> bool {
        self.signs.keys().all(|robot| self.me <= *robot)
    }

    /// True if nobody has anything left to explore.
    #[must_use]
    pub fn is_through(&self) -> bool {
        self.signs.values().all(|(_, sign)| sign.is_idle)
    }
}

/// What lies behind an arm: a corridor, as far as it is known.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    from: Point2<f64>,
    /// Unit vector.
    along: Vector2<f64>,
    /// At most, m.
    length: f64,
    /// Where it ends, or may end.
    end: Option<Exit>,
    is_known: bool,
}

impl Stretch {
    /// A corridor that nobody has gone may lead to the next place straight ahead that has an arm toward it.
    fn of(map: &TopologicalMap, exit: Exit) -> Option<Self> {
        let (at, heading) = (map.place(exit.0)?.at, map.known_compass()?.heading(exit.1));
        let along = Vector2::new(heading.cos(), heading.sin());
        let stretch = Self { from: at, along, length: LONGEST, end: None, is_known: false };
        if let Some((length, end)) = map.corridor(exit) {
            return Some(Self { length, end: Some(end), is_known: true, ..stretch });
        }
        let straight_ahead = map.places().filter(|(_, place)| stretch.offset(place.at).is_some_and(|along| along > NEAREST));
        let distance = |place: &Point2<f64>| (place - at).dot(&along);
        let next = straight_ahead.min_by(|a, b| distance(&a.1.at).total_cmp(&distance(&b.1.at)));
        let Some((next, place)) = next else { return Some(stretch) };
        let arm = exit.1.back();
        let end = (place.arms[arm.index()] != Arm::Closed).then_some((next, arm));
        Some(Self { length: distance(&place.at), end, ..stretch })
    }

    /// How far along it a point is, m, if it is in it.
    fn offset(&self, point: Point2<f64>) -> Option<f64> {
        let to = point - self.from;
        let (along, across) = (to.dot(&self.along), to.perp(&self.along));
        (across.abs() < HALF && (0.0..self.length).contains(&along)).then_some(along)
    }

    fn has(&self, point: Point2<f64>) -> bool {
        self.offset(point).is_some_and(|along| along > 0.5 * NEAREST)
    }

    /// True if a robot is in it, or at its end.
    fn holds(&self, mate: &Sign) -> bool {
        let at_its_end = self.end.is_some_and(|(end, _)| mate.at == Some(end));
        at_its_end || self.has(mate.pose.point()) || mate.spot.is_some_and(|spot| self.has(spot))
    }

    /// True if who goes the one may meet who goes the other.
    fn meets(&self, other: &Option<Self>, mine: Exit, theirs: Exit) -> bool {
        let Some(other) = other else { return false };
        let same = mine == theirs || self.end == Some(theirs) || other.end == Some(mine);
        let same_end = self.end.zip(other.end).is_some_and(|(a, b)| a.0 == b.0);
        same || same_end || (!self.is_known && !other.is_known && self.crosses(other))
    }

    fn crosses(&self, other: &Self) -> bool {
        let turn = self.along.perp(&other.along);
        if turn.abs() < 0.5 {
            return false;
        }
        let between = other.from - self.from;
        let (mine, theirs) = (between.perp(&other.along) / turn, between.perp(&self.along) / turn);
        let reach = |stretch: &Self| NEAREST..stretch.length.min(CROSSING);
        reach(self).contains(&mine) && reach(other).contains(&theirs)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::Matrix2;

    use super::*;
    use crate::geographer::map::{Change, Place};

    const ALL: [bool; 4] = [true; 4];
    const EAST: Quarter = Quarter::ALL[0];
    const NORTH: Quarter = Quarter::ALL[1];
    const WEST: Quarter = Quarter::ALL[2];
    const SOUTH: Quarter = Quarter::ALL[3];

    /// A map with places there; each has ways in these directions.
    fn map(places: &[(f64, f64, [bool; 4])]) -> TopologicalMap {
        let mut map = TopologicalMap::default();
        map.apply(Change::Compass(0.0));
        for (x, y, ways) in places {
            map.apply(Change::Found(Place {
                name: String::new(),
                at: Point2::new(*x, *y),
                covariance: Matrix2::identity() * 0.01,
                kind: "H1".into(),
                title: String::new(),
                belief: 1.0,
                seen: EAST,
                arms: ways.map(|way| if way { Arm::Unexplored } else { Arm::Closed }),
                visits: 1,
            }));
        }
        map
    }

    fn place(number: usize) -> NodeIndex {
        NodeIndex::new(number)
    }

    /// A robot at the first place, which comes second in the mission, and another one that says this.
    fn team(mate: Sign) -> Team {
        let mut team = Team::of(1);
        team.hear(0, &mate.told(Time::from_secs_f64(9.0)));
        team
    }

    fn far_away() -> Sign {
        Sign { pose: Pose::new(-50.0, -50.0, 0.0), since: Time::from_secs_f64(9.0), ..Sign::default() }
    }

    const NOW: Time = Time::from_nanos(9_000_000_000);

    #[test]
    fn signs_come_out_as_they_went_in() {
        let sign = Sign {
            since: Time::from_secs_f64(3.0),
            pose: Pose::new(1.0, 2.0, 0.5),
            spot: Some(Point2::new(3.0, 4.0)),
            at: Some(place(7)),
            way: Some((place(7), NORTH)),
            goal: Some((place(2), WEST)),
            held_up_by: Some(2),
            is_idle: true,
        };
        for sign in [sign, Sign::default()] {
            assert_eq!(Sign::heard(&sign.told(Time::START)), sign);
        }
        assert_eq!(Sign::heard(&Whereabouts::default()), Sign::default());
    }

    #[test]
    fn who_is_at_the_end_of_a_corridor_is_in_the_way() {
        let mut map = map(&[(0.0, 0.0, ALL), (8.0, 0.0, ALL)]);
        let at_the_end = team(Sign { at: Some(place(1)), ..far_away() });
        assert_eq!(at_the_end.in_the_way(&map, (place(0), EAST), NOW), Some(0), "it may lead there");
        assert_eq!(at_the_end.in_the_way(&map, (place(0), NORTH), NOW), None);
        map.apply(Change::Joined { from: (place(0), NORTH), to: (place(1), NORTH), length: 16.0 });
        assert_eq!(at_the_end.in_the_way(&map, (place(0), NORTH), NOW), Some(0), "it leads there");
    }

    #[test]
    fn who_is_in_a_corridor_is_in_the_way() {
        let map = map(&[(0.0, 0.0, ALL)]);
        let inside = team(Sign { pose: Pose::new(5.0, 0.3, 1.0), ..far_away() });
        assert_eq!(inside.in_the_way(&map, (place(0), EAST), NOW), Some(0));
        assert_eq!(inside.in_the_way(&map, (place(0), WEST), NOW), None);
        let unnamed = team(Sign { spot: Some(Point2::new(0.2, 9.0)), ..far_away() });
        assert_eq!(unnamed.in_the_way(&map, (place(0), NORTH), NOW), Some(0));
    }

    #[test]
    fn two_that_may_meet_do_not_go_at_once() {
        // The second place faces the first, the third one looks across.
        let map = map(&[(0.0, 0.0, ALL), (12.0, 0.1, ALL), (6.0, -8.0, ALL)]);
        for theirs in [(place(1), WEST), (place(2), NORTH)] {
            let going = team(Sign { way: Some(theirs), ..far_away() });
            assert_eq!(going.in_the_way(&map, (place(0), EAST), NOW), Some(0), "{theirs:?}");
            assert_eq!(going.in_the_way(&map, (place(0), SOUTH), NOW), None, "{theirs:?}");
        }
    }

    #[test]
    fn who_wanted_it_first_goes_first() {
        let map = map(&[(0.0, 0.0, ALL), (12.0, 0.0, ALL)]);
        let wants = |since: f64| team(Sign { way: Some((place(1), WEST)), since: Time::from_secs_f64(since), ..far_away() });
        let exit = (place(0), EAST);
        assert_eq!(wants(8.0).in_the_way(&map, exit, NOW), Some(0), "earlier");
        assert_eq!(wants(9.0).in_the_way(&map, exit, NOW), Some(0), "at once, and first in the mission");
        assert_eq!(wants(9.5).in_the_way(&map, exit, NOW), None, "later");
    }

    #[test]
    fn a_corridor_that_is_known_crosses_none() {
        let mut map = map(&[(0.0, 0.0, ALL), (12.0, 0.0, ALL), (6.0, -8.0, ALL)]);
        map.apply(Change::Joined { from: (place(0), EAST), to: (place(1), WEST), length: 12.0 });
        let across = team(Sign { way: Some((place(2), NORTH)), ..far_away() });
        assert_eq!(across.in_the_way(&map, (place(0), EAST), NOW), None);
    }

    #[test]
    fn whoever_is_silent_holds_nothing_but_is_where_they_were() {
        let map = map(&[(0.0, 0.0, ALL), (8.0, 0.0, ALL)]);
        let mut team = team(Sign { at: Some(place(1)), pose: Pose::new(0.0, 6.0, 0.0), ..far_away() });
        team.settle(Time::from_secs_f64(13.0));
        assert_eq!(team.in_the_way(&map, (place(0), EAST), NOW), Some(0));
        team.settle(Time::from_secs_f64(14.5));
        assert_eq!(team.in_the_way(&map, (place(0), EAST), NOW), None);
        assert_eq!(team.in_the_way(&map, (place(0), NORTH), NOW), Some(0));
        assert!(team.is_through());
    }

    #[test]
    fn the_stop_line_is_before_robots_and_the_places_where_they_are() {
        let ahead = |mate: Sign| team(mate).ahead(Pose::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
        assert_eq!(ahead(Sign { pose: Pose::new(0.3, 2.9, 0.0), ..Sign::default() }), Some(0));
        assert_eq!(ahead(Sign { pose: Pose::new(0.3, 3.1, 0.0), ..Sign::default() }), None);
        assert_eq!(ahead(Sign { pose: Pose::new(1.0, 2.0, 0.0), ..Sign::default() }), None);
        assert_eq!(ahead(Sign { pose: Pose::new(0.0, -1.0, 0.0), ..Sign::default() }), None);
        assert_eq!(ahead(Sign { spot: Some(Point2::new(0.0, 2.5)), ..far_away() }), Some(0));
    }

    #[test]
    fn the_later_one_makes_way_and_the_idle_one_for_all() {
        let waits = |held_up_by| Sign { held_up_by: Some(held_up_by), ..far_away() };
        assert!(team(waits(1)).asks_to_go(false).is_some(), "the first one asks the second");
        assert!(team(waits(2)).asks_to_go(true).is_none(), "it asks somebody else");
        let mut first = Team::of(0);
        first.hear(1, &waits(0).told(Time::START));
        assert!(first.asks_to_go(false).is_none());
        assert!(first.asks_to_go(true).is_some());
        assert!(team(waits(1)).has_to_turn_back(0) && !first.has_to_turn_back(1));
    }
}
