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
