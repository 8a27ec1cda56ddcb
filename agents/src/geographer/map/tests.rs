//! A map drawn by hand.
#![allow(clippy::unwrap_used)]

use super::*;

fn place(x: f64, y: f64, arms: [Arm; 4]) -> Place {
    Place {
        name: String::new(),
        at: Point2::new(x, y),
        covariance: Matrix2::identity() * 0.01,
        kind: "H1".into(),
        title: String::new(),
        belief: 1.0,
        seen: Quarter::ALL[0],
        arms,
        visits: 1,
    }
}

/// Two places in a line, with a branch at the second one.
fn line() -> (TopologicalMap, NodeIndex, NodeIndex) {
    use Arm::{Closed, Unexplored};
    let mut map = TopologicalMap::default();
    map.set_compass(0.0);
    let a = map.add(place(0.0, 0.0, [Unexplored, Closed, Closed, Closed]));
    let b = map.add(place(5.0, 0.0, [Closed, Unexplored, Unexplored, Unexplored]));
    map.join((a, Quarter::ALL[0]), (b, Quarter::ALL[2]), 5.0);
    (map, a, b)
}

/// The nearest arm, with nobody in the way.
fn nearest(map: &TopologicalMap, from: NodeIndex, facing: Quarter) -> Option<Route> {
    map.nearest_unexplored(from, facing, |_| true, |_| true)
}

#[test]
fn who_is_kept_from_an_arm_or_a_corridor_goes_elsewhere() {
    let (map, a, b) = line();
    let [ahead, left, _, right] = Quarter::ALL;
    assert_eq!(map.nearest_unexplored(b, ahead, |exit| exit != (b, right), |_| true), Some(vec![(b, left)]));
    assert_eq!(map.nearest_unexplored(a, ahead, |_| true, |_| false), None);
}

#[test]
fn names_go_on_after_z() {
    assert_eq!([0, 25, 26, 51, 52, 701, 702].map(name), ["A", "Z", "AA", "AZ", "BA", "ZZ", "AAA"]);
}

#[test]
fn the_nearest_arm_is_gone_first_and_straight_on_before_sideways() {
    let (map, a, b) = line();
    assert_eq!(map.unexplored(), 2);
    let [_, left, _, right] = Quarter::ALL;
    assert_eq!(nearest(&map, b, Quarter::ALL[0]), Some(vec![(b, right)]));
    assert_eq!(nearest(&map, b, left), Some(vec![(b, left)]));
    assert_eq!(nearest(&map, a, Quarter::ALL[0]).unwrap()[0], (a, Quarter::ALL[0]));
}

#[test]
fn a_place_is_recognised_where_it_should_be_and_nowhere_else() {
    let (map, a, b) = line();
    let (at, covariance) = map.reached(a, Quarter::ALL[0], 5.3).unwrap();
    assert_eq!(map.recognise(at, &covariance), Some(b));
    let (at, covariance) = map.reached(a, Quarter::ALL[1], 5.0).unwrap();
    assert_eq!(map.recognise(at, &covariance), None);
}

#[test]
fn who_comes_again_knows_better() {
    let (mut map, a, b) = line();
    let before = map.place(b).unwrap().clone();
    let (at, covariance) = map.reached(a, Quarter::ALL[0], 5.2).unwrap();
    map.seen_again(b, at, &covariance);
    let after = map.place(b).unwrap();
    assert!(after.at.x > before.at.x && after.at.x < at.x);
    assert!(after.covariance.trace() < before.covariance.trace());
    map.join((a, Quarter::ALL[0]), (b, Quarter::ALL[2]), 5.2);
    assert_eq!(map.corridors().count(), 1);
    assert!((map.corridors().next().unwrap().length - 5.1).abs() < 1e-9);
}

#[test]
fn who_has_passed_a_place_without_noticing_joins_nothing() {
    let (mut map, a, b) = line();
    let c = map.add(place(11.0, 0.2, [Arm::Closed, Arm::Closed, Arm::Unexplored, Arm::Closed]));
    map.join((a, Quarter::ALL[0]), (c, Quarter::ALL[2]), 11.0);
    assert_eq!(map.corridors().count(), 1);
    assert_eq!(map.corridor((a, Quarter::ALL[0])).unwrap().1, (b, Quarter::ALL[2]));
}

#[test]
fn a_corridor_that_leads_elsewhere_takes_the_place_of_the_one_that_was_thought_to_be_there() {
    let (mut map, a, b) = line();
    let c = map.add(place(2.5, 0.0, [Arm::Closed, Arm::Closed, Arm::Unexplored, Arm::Closed]));
    map.join((a, Quarter::ALL[0]), (c, Quarter::ALL[2]), 2.5);
    assert_eq!(map.corridor((a, Quarter::ALL[0])).unwrap().1, (c, Quarter::ALL[2]));
    assert_eq!((map.corridors().count(), map.place(b).unwrap().arms[2]), (1, Arm::Unexplored));
}

#[test]
fn what_could_not_be_gone_is_tried_again_at_the_end() {
    let (mut map, _, b) = line();
    let [_, left, _, right] = Quarter::ALL;
    map.give_up(b, right);
    assert_eq!(nearest(&map, b, Quarter::ALL[0]), Some(vec![(b, left)]));
    assert!((0..PERSISTENCE).all(|_| map.give_up(b, left)));
    assert_eq!(nearest(&map, b, Quarter::ALL[0]), Some(vec![(b, right)]));
}

#[test]
fn with_nothing_left_there_is_no_way() {
    let (mut map, _, b) = line();
    for quarter in [1, 3] {
        map.set_arm(b, Quarter::ALL[quarter], Arm::GivenUp(PERSISTENCE));
    }
    assert_eq!((map.unexplored(), nearest(&map, b, Quarter::ALL[0])), (0, None));
}
