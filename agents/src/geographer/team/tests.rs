//! Who keeps whom from going where.
#![allow(clippy::unwrap_used)]

use nalgebra::Matrix2;

use super::*;
use crate::geographer::{
    compass::Quarter,
    map::{Arm, Change, Place},
};

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
fn team(mate: Presence) -> Team {
    let mut team = Team::of(1);
    team.hear(0, &mate.told(Time::from_secs_f64(9.0)));
    team
}

fn far_away() -> Presence {
    Presence { pose: Pose::new(-50.0, -50.0, 0.0), since: Time::from_secs_f64(9.0), ..Presence::default() }
}

const NOW: Time = Time::from_nanos(9_000_000_000);

#[test]
fn presences_come_out_as_they_went_in() {
    let presence = Presence {
        since: Time::from_secs_f64(3.0),
        pose: Pose::new(1.0, 2.0, 0.5),
        spot: Some(Point2::new(3.0, 4.0)),
        at: Some(place(7)),
        way: Some((place(7), NORTH)),
        goal: Some((place(2), WEST)),
        held_up_by: Some(2),
        is_idle: true,
        is_shut_in: true,
        stands_by: true,
    };
    for presence in [presence, Presence::default()] {
        assert_eq!(Presence::heard(&presence.told(Time::START)), presence);
    }
    assert_eq!(Presence::heard(&Whereabouts::default()), Presence::default());
}

#[test]
fn who_is_at_the_end_of_a_corridor_is_in_the_way() {
    let mut map = map(&[(0.0, 0.0, ALL), (8.0, 0.0, ALL)]);
    let at_the_end = team(Presence { at: Some(place(1)), ..far_away() });
    assert_eq!(at_the_end.in_the_way(&map, (place(0), EAST), NOW), Some(0), "it may lead there");
    assert_eq!(at_the_end.in_the_way(&map, (place(0), NORTH), NOW), None);
    map.apply(Change::Joined { from: (place(0), NORTH), to: (place(1), NORTH), length: 16.0 });
    assert_eq!(at_the_end.in_the_way(&map, (place(0), NORTH), NOW), Some(0), "it leads there");
}

#[test]
fn who_is_in_a_corridor_is_in_the_way() {
    let map = map(&[(0.0, 0.0, ALL)]);
    let inside = team(Presence { pose: Pose::new(5.0, 0.3, 1.0), ..far_away() });
    assert_eq!(inside.in_the_way(&map, (place(0), EAST), NOW), Some(0));
    assert_eq!(inside.in_the_way(&map, (place(0), WEST), NOW), None);
    let unnamed = team(Presence { spot: Some(Point2::new(0.2, 9.0)), ..far_away() });
    assert_eq!(unnamed.in_the_way(&map, (place(0), NORTH), NOW), Some(0));
}

#[test]
fn two_that_may_meet_do_not_go_at_once() {
    // The second place faces the first, the third one looks across.
    let map = map(&[(0.0, 0.0, ALL), (12.0, 0.1, ALL), (6.0, -8.0, ALL)]);
    for theirs in [(place(1), WEST), (place(2), NORTH)] {
        let going = team(Presence { way: Some(theirs), ..far_away() });
        assert_eq!(going.in_the_way(&map, (place(0), EAST), NOW), Some(0), "{theirs:?}");
        assert_eq!(going.in_the_way(&map, (place(0), SOUTH), NOW), None, "{theirs:?}");
    }
}

#[test]
fn who_wanted_it_first_goes_first() {
    let map = map(&[(0.0, 0.0, ALL), (12.0, 0.0, ALL)]);
    let wants = |since: f64| team(Presence { way: Some((place(1), WEST)), since: Time::from_secs_f64(since), ..far_away() });
    let exit = (place(0), EAST);
    assert_eq!(wants(8.0).in_the_way(&map, exit, NOW), Some(0), "earlier");
    assert_eq!(wants(9.0).in_the_way(&map, exit, NOW), Some(0), "at once, and first in the mission");
    assert_eq!(wants(9.5).in_the_way(&map, exit, NOW), None, "later");
}

#[test]
fn a_corridor_that_is_known_crosses_none() {
    let mut map = map(&[(0.0, 0.0, ALL), (12.0, 0.0, ALL), (6.0, -8.0, ALL)]);
    map.apply(Change::Joined { from: (place(0), EAST), to: (place(1), WEST), length: 12.0 });
    let across = team(Presence { way: Some((place(2), NORTH)), ..far_away() });
    assert_eq!(across.in_the_way(&map, (place(0), EAST), NOW), None);
}

#[test]
fn whoever_is_silent_holds_nothing_but_is_where_they_were() {
    let map = map(&[(0.0, 0.0, ALL), (8.0, 0.0, ALL)]);
    let mut team = team(Presence { at: Some(place(1)), pose: Pose::new(0.0, 6.0, 0.0), ..far_away() });
    team.settle(Time::from_secs_f64(13.0));
    assert_eq!(team.in_the_way(&map, (place(0), EAST), NOW), Some(0));
    team.settle(Time::from_secs_f64(14.5));
    assert_eq!(team.in_the_way(&map, (place(0), EAST), NOW), None);
    assert_eq!(team.in_the_way(&map, (place(0), NORTH), NOW), Some(0));
    assert!(team.is_through() && team.stands_by(0) && team.speaks_for_all());
}

#[test]
fn the_stop_line_is_before_robots_and_the_places_where_they_are() {
    let ahead = |mate: Presence| team(mate).ahead(Pose::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
    assert_eq!(ahead(Presence { pose: Pose::new(0.3, 2.9, 0.0), ..Presence::default() }), Some(0));
    assert_eq!(ahead(Presence { pose: Pose::new(0.3, 3.1, 0.0), ..Presence::default() }), None);
    assert_eq!(ahead(Presence { pose: Pose::new(1.0, 2.0, 0.0), ..Presence::default() }), None);
    assert_eq!(ahead(Presence { pose: Pose::new(0.0, -1.0, 0.0), ..Presence::default() }), None);
    assert_eq!(ahead(Presence { spot: Some(Point2::new(0.0, 2.5)), ..far_away() }), Some(0));
}

#[test]
fn the_later_one_makes_way_and_the_idle_one_for_all() {
    let waits = |held_up_by| Presence { held_up_by: Some(held_up_by), ..far_away() };
    assert!(team(waits(1)).asks_to_go(false).is_some(), "the first one asks the second");
    assert!(team(waits(2)).asks_to_go(true).is_none(), "it asks somebody else");
    let mut first = Team::of(0);
    first.hear(1, &waits(0).told(Time::START));
    assert!(first.asks_to_go(false).is_none());
    assert!(first.asks_to_go(true).is_some());
    first.hear(1, &Presence { is_shut_in: true, ..waits(0) }.told(Time::START));
    assert!(first.asks_to_go(false).is_some(), "the later one can't");
}

#[test]
fn of_two_who_meet_in_a_corridor_the_later_one_turns_back() {
    // Whoever is in a corridor still holds the place that it came from.
    let waits = |at, held_up_by| Presence { held_up_by: Some(held_up_by), at: Some(at), ..far_away() };
    assert!(team(waits(place(0), 1)).has_to_turn_back(0));
    assert!(!team(waits(place(0), 2)).has_to_turn_back(0), "it waits for somebody else");
    let mut first = Team::of(0);
    first.hear(1, &waits(place(1), 0).told(Time::START));
    assert!(!first.has_to_turn_back(1));
    first.hear(1, &Presence { is_shut_in: true, ..waits(place(1), 0) }.told(Time::START));
    assert!(first.has_to_turn_back(1), "the later one can't");
    assert!(!first.has_to_turn_back(2), "nobody knows of it");
}

#[test]
fn whoever_is_first_of_those_who_explore_speaks_for_all() {
    let explores = Presence { stands_by: false, ..far_away() };
    assert!(!team(explores).speaks_for_all());
    assert!(team(Presence { stands_by: true, ..far_away() }).speaks_for_all(), "who stands by has no map");
}

#[test]
fn who_came_to_no_place_keeps_only_its_corridor() {
    let left = far_away().stays_at(place(0), Some(Point2::origin())).wants((place(0), EAST), Some((place(0), EAST)), NOW);
    assert_eq!((left.at, left.spot), (Some(place(0)), Some(Point2::origin())));
    let came = left.comes_to(Point2::new(9.0, 0.0));
    assert_eq!((came.at, came.spot, came.way, came.goal), (None, Some(Point2::new(9.0, 0.0)), Some((place(0), EAST)), None));
    let passed = came.passes();
    assert_eq!((passed.at, passed.spot, passed.way), (None, None, Some((place(0), EAST))));
    assert_eq!(passed.standing_by().astray(), Presence { pose: left.pose, stands_by: true, ..Presence::default() });
}
