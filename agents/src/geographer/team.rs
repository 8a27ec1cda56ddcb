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

mod lane;
mod presence;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use nalgebra::Point2;
use orienteer_runtime::{geometry::Pose, time::Time, topics::Whereabouts};
use petgraph::graph::NodeIndex;

use super::map::{Corridor, Exit, TopologicalMap};
use lane::{HALF, Lane};
pub use presence::Presence;

/// Who has not been heard of for so long explores no more, s.
const SILENT: f64 = 5.0;
/// Nobody comes nearer to another robot, or to a place where one is, along a corridor, m.
const STOP_LINE: f64 = 3.0;

/// What is known of those who explore the same floor.
#[derive(Debug, Clone, Default)]
pub struct Team {
    me: u32,
    /// What each robot said last, the robot itself among them, and when that was.
    presences: BTreeMap<u32, (Time, Presence)>,
}

impl Team {
    /// The team of the robot that has this place in the mission.
    #[must_use]
    pub fn of(me: u32) -> Self {
        Self { me, presences: BTreeMap::new() }
    }

    /// A robot has said where it is.
    pub fn hear(&mut self, robot: u32, told: &Whereabouts) {
        self.presences.insert(robot, (told.stamp, Presence::heard(told)));
    }

    /// Time passes. Whoever has said nothing for long lets go of what it held; its body is where it was.
    pub fn settle(&mut self, now: Time) {
        for (_, presence) in self.presences.values_mut().filter(|(said, _)| now.since(*said).as_secs_f64() > SILENT) {
            *presence = presence.standing_by();
        }
    }

    /// What the robot itself was heard to say.
    #[must_use]
    pub fn own(&self) -> Option<&Presence> {
        self.presences.get(&self.me).map(|(_, presence)| presence)
    }

    /// True if that robot explores no more, and will not go away.
    #[must_use]
    pub fn stands_by(&self, robot: u32) -> bool {
        self.presences.get(&robot).is_some_and(|(_, presence)| presence.stands_by)
    }

    fn mates(&self) -> impl Iterator<Item = (u32, &Presence)> {
        self.presences.iter().filter(|(robot, _)| **robot != self.me).map(|(robot, (_, presence))| (*robot, presence))
    }

    /// Who keeps the robot, which has wanted it since then, from leaving by this way.
    #[must_use]
    pub fn in_the_way(&self, map: &TopologicalMap, exit: Exit, since: Time) -> Option<u32> {
        let mine = Lane::of(map, exit)?;
        let keeps = |robot: u32, mate: &Presence| {
            let is_first = (mate.since, robot) < (since, self.me);
            let way = mate.way.filter(|_| is_first);
            mine.holds(mate) || way.is_some_and(|way| mine.meets(&Lane::of(map, way), exit, way))
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
        let is_in = |mate: &Presence| {
            let at_an_end = mate.at.is_some_and(|at| at == corridor.from.0 || at == corridor.to.0);
            at_an_end || Lane::of(map, corridor.from).is_some_and(|lane| lane.has(mate.pose.point()))
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
        let near = |mate: &Presence| is_ahead(mate.pose.point()) || mate.spot.is_some_and(is_ahead);
        self.mates().find(|(_, mate)| near(mate)).map(|(robot, _)| robot)
    }

    /// Somebody who waits for the robot to go away, and where they are. A robot that has time makes way for all; of two who wait for each other the one that comes later in
    /// the mission, unless it can't.
    #[must_use]
    pub fn asks_to_go(&self, has_time: bool) -> Option<(u32, Point2<f64>)> {
        let asks =
            |robot: u32, mate: &Presence| mate.held_up_by == Some(self.me) && (has_time || robot < self.me || mate.is_shut_in);
        self.mates().find(|(robot, mate)| asks(*robot, mate)).map(|(robot, mate)| (robot, mate.pose.point()))
    }

    /// True if of two that wait for each other this robot, which is in a corridor, has to turn back, and not that one: it comes later in the mission, or that one can't go.
    #[must_use]
    pub fn has_to_turn_back(&self, by: u32) -> bool {
        let Some((_, mate)) = self.presences.get(&by) else { return false };
        mate.is_shut_in || (by < self.me && mate.held_up_by == Some(self.me))
    }

    /// Who is at a place, or on the way there.
    #[must_use]
    pub fn comes_to(&self, map: &TopologicalMap, place: NodeIndex) -> Option<u32> {
        let ends_there = |way: Exit| Lane::of(map, way).and_then(|lane| lane.end).is_some_and(|end| end.0 == place);
        let comes = |mate: &Presence| mate.at == Some(place) || mate.way.is_some_and(ends_there);
        self.mates().find(|(_, mate)| comes(mate)).map(|(robot, _)| robot)
    }

    /// True for the first of those who have the map: what all would say need be said once.
    #[must_use]
    pub fn speaks_for_all(&self) -> bool {
        !self.mates().any(|(robot, mate)| robot < self.me && !mate.stands_by)
    }

    /// True if nobody has anything left to explore.
    #[must_use]
    pub fn is_through(&self) -> bool {
        self.presences.values().all(|(_, presence)| presence.is_idle || presence.stands_by)
    }
}
