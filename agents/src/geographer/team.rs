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

mod stretch;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use nalgebra::Point2;
use orienteer_runtime::{
    geometry::Pose,
    time::Time,
    topics::{NOWHERE, Whereabouts},
};
use petgraph::graph::NodeIndex;

use super::{
    compass::Quarter,
    map::{Corridor, Exit, TopologicalMap},
};
use stretch::{HALF, Stretch};

/// Who has not been heard of for so long holds nothing any more; their body is where it was, s.
const SILENT: f64 = 5.0;
/// Nobody comes nearer to another robot, or to a place where one is, along a corridor, m.
const STOP_LINE: f64 = 3.0;

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
    /// Every way that it knows out of its place is somebody else's: it can't make way.
    pub is_shut_in: bool,
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
            state: u32::from(self.is_idle) | (u32::from(self.is_shut_in) << 1),
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
            is_idle: told.state & 1 != 0,
            is_shut_in: told.state & 2 != 0,
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

    /// Somebody who waits for the robot to go away, and where they are. A robot that has time makes way for all; of two who wait for each other the one that comes later in
    /// the mission, unless it can't.
    #[must_use]
    pub fn asks_to_go(&self, has_time: bool) -> Option<(u32, Point2<f64>)> {
        let asks = |robot: u32, mate: &Sign| mate.held_up_by == Some(self.me) && (has_time || robot < self.me || mate.is_shut_in);
        self.mates().find(|(robot, mate)| asks(*robot, mate)).map(|(robot, mate)| (robot, mate.pose.point()))
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
