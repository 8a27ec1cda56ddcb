//! Simulated robots whose bases are read by a thread of their own, as at wall time.
#![allow(clippy::unwrap_used)]

use orienteer_hardware::{
    base::presets,
    driver::{BaseDriver, SonarDriver},
    rings,
    sim::{Arena, SimBase, SimBodyConfig, SimSonar},
    world::{World, plan::WorldPlan},
};
use orienteer_runtime::{
    geometry::{Pose, Twist},
    random::Streams,
    time::Time,
    topics::SonarScan,
};

/// Drives for two seconds; the base is read every `beat` ms and the sonar every 50 ms.
fn scans(beat: u64) -> Vec<SonarScan> {
    let plan = WorldPlan::parse("[[room]]\ncorners = [[0, 0], [10, 8]]").unwrap();
    let world = World::from_plan(&plan, &|_| Err(std::io::ErrorKind::NotFound.into())).unwrap();
    let arena = Arena::new(world, Streams::new(1)).unwrap();
    let config = presets::b12_huey();
    let platform = config.platform();
    let start = Pose::new(3.0, 4.0, 0.3);
    let body = arena.add("huey", start, SimBodyConfig { base: config, odometry: Default::default() }).unwrap();
    let named = rings::find("denning-16").unwrap();
    let mut base = SimBase::new(body.clone(), platform);
    let mut sonar = SimSonar::new(arena, "huey", body, named.ring, &named.model).unwrap();
    base.command(Time::START, Twist::new(0.3, 0.1)).unwrap();
    let mut scans = Vec::new();
    for millis in (0..=2000).step_by(beat as usize) {
        let now = Time::from_nanos(millis * 1_000_000);
        base.poll(now).unwrap();
        if millis % 50 == 0 {
            sonar.poll(now, &mut scans).unwrap();
        }
    }
    scans
}

#[test]
fn no_slot_is_lost_to_a_guard_that_reads_the_base_often() {
    let (step_by_step, guarded) = (scans(50), scans(10));
    assert_eq!(step_by_step.len(), 80, "one of 25 ms after the other");
    assert_eq!(guarded.len(), step_by_step.len());
    assert!(guarded.iter().zip(&step_by_step).all(|(a, b)| a.stamp == b.stamp && a.fired == b.fired));
}

/// Hangs if each can wait for what the other holds.
#[test]
fn a_guard_and_the_world_do_not_wait_for_each_other() {
    let plan = WorldPlan::parse("[[room]]\ncorners = [[0, 0], [10, 8]]").unwrap();
    let world = World::from_plan(&plan, &|_| Err(std::io::ErrorKind::NotFound.into())).unwrap();
    let arena = Arena::new(world, Streams::new(1)).unwrap();
    let config = presets::b12_huey();
    let platform = config.platform();
    let body = arena.add("huey", Pose::new(3.0, 4.0, 0.0), SimBodyConfig { base: config, odometry: Default::default() }).unwrap();
    let mut base = SimBase::new(body, platform);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for millis in 0..50_000 {
                base.poll(Time::from_nanos(millis * 1_000_000)).unwrap();
            }
        });
        for _ in 0..50_000 {
            arena.advance(std::time::Duration::from_millis(1));
        }
    });
}
