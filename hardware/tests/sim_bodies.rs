//! Bodies that meet.
#![allow(clippy::unwrap_used)]

use std::{
    sync::{Arc, Mutex},
    time::Duration,
};

use orienteer_hardware::{
    base::presets,
    sim::{Arena, SimBody, SimBodyConfig},
    world::{World, plan::WorldPlan},
};
use orienteer_runtime::{
    geometry::{Pose, Twist},
    random::Streams,
    time::Time,
    topics::flags,
};

fn arena(plan: &str) -> Arc<Arena> {
    let plan = WorldPlan::parse(plan).unwrap();
    let world = World::from_plan(&plan, &|_| Err(std::io::ErrorKind::NotFound.into())).unwrap();
    Arena::new(world, Streams::new(1)).unwrap()
}

fn robot(arena: &Arc<Arena>, name: &str, start: Pose) -> Arc<Mutex<SimBody>> {
    arena.add(name, start, SimBodyConfig { base: presets::b12_huey(), odometry: Default::default() }).unwrap()
}

/// Where a robot stops that drives at another, looked after every `beat` ms, and how often it has run into it.
fn run_into(beat: u64) -> (f64, u32) {
    let arena = arena("[[room]]\ncorners = [[0, 0], [20, 8]]");
    let driver = robot(&arena, "driver", Pose::new(2.0, 4.0, 0.0));
    for (i, x) in [6.0, 9.0, 15.0].into_iter().enumerate() {
        // One beside the way, one in it, one behind.
        robot(&arena, &format!("r{i}"), Pose::new(x, if i == 0 { 5.0 } else { 4.0 }, 0.0));
    }
    let mut driver = driver.lock().unwrap();
    driver.set_demand(Twist::new(0.4, 0.0));
    for millis in (beat..=30_000).step_by(beat as usize) {
        driver.advance(Time::START + Duration::from_millis(millis));
    }
    (driver.pose().x + driver.radius(), driver.truth().collisions)
}

#[test]
fn whoever_is_far_at_the_beginning_of_a_long_look_is_run_into_all_the_same() {
    let often = run_into(10);
    assert!((often.0 - (9.0 - presets::b12_huey().radius)).abs() < 1e-6 && often.1 == 1, "{often:?}");
    assert_eq!(run_into(50), often);
    assert_eq!(run_into(30_000), often);
}

#[test]
fn bodies_are_shown_where_they_stood_at_the_end_of_the_step() {
    let arena = arena("[[room]]\ncorners = [[0, 0], [20, 8]]\n[[person]]\npath = [[2, 2], [8, 2]]\nspeed = 1.0");
    let body = robot(&arena, "driver", Pose::new(2.0, 4.0, 0.0));
    let stand = || arena.with_bodies(|bodies| (bodies.robots()[0].center, bodies.people()[0].center));
    let before = stand();
    body.lock().unwrap().set_demand(Twist::new(0.4, 0.0));
    body.lock().unwrap().advance(Time::START + Duration::from_secs(2));
    assert_eq!(stand(), before);
    arena.advance(Duration::from_secs(2));
    let after = stand();
    assert!((after.0.x - before.0.x - 0.8).abs() < 0.2 && (after.1.x - before.1.x - 2.0).abs() < 1e-9, "{after:?}");
}

/// How often a robot has collided after each leg (m/s and s) of a drive that begins 70 cm before a wall, and whether its bumper
/// is pressed.
fn after_each(legs: &[(Twist, f64)]) -> Vec<(u32, bool)> {
    let arena = arena("[[room]]\ncorners = [[0, 0], [20, 8]]");
    let body = robot(&arena, "driver", Pose::new(19.0, 4.0, 0.0));
    let mut body = body.lock().unwrap();
    let counted = legs.iter().map(|(twist, seconds)| {
        body.set_demand(*twist);
        for _ in 0..(seconds * 20.0) as u32 {
            let next = body.now() + Duration::from_millis(50);
            body.advance(next);
        }
        (body.truth().collisions, body.odometry().flags & flags::CONTACT != 0)
    });
    counted.collect()
}

/// Who stands at what it has hit and is told to go on has not driven into anything new, and its bumper stays pressed.
#[test]
fn pushing_again_at_what_was_hit_is_the_same_collision() {
    let (on, turn) = (Twist::new(0.4, 0.0), Twist::new(0.0, 0.5));
    let legs = [(on, 3.0), (Twist::STOP, 0.5), (on, 1.0), (turn, 0.5), (on, 1.0)];
    assert_eq!(after_each(&legs), [(1, true); 5]);
}

/// The count must not stay at one for good: who has come away and returns drives into it once more, here or elsewhere.
#[test]
fn coming_back_is_another_collision() {
    let (on, back, aside) = (Twist::new(0.4, 0.0), Twist::new(-0.4, 0.0), Twist::new(0.0, 0.5));
    let legs = [(on, 3.0), (back, 2.0), (on, 3.0), (back, 2.0), (aside, 0.6), (on, 4.0)];
    assert_eq!(after_each(&legs), [(1, true), (1, false), (2, true), (2, false), (2, false), (3, true)]);
}
