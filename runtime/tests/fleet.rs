//! Fleets: stepping on any number of threads, pausing, stopping.
#![allow(clippy::unwrap_used)]

mod fleet_support;

use std::{ops::ControlFlow, time::Duration};

use fleet_support::{fly, robot};
use orienteer_runtime::{
    clock::Pace,
    fleet::{self, Ended, FleetControl, FleetPlan, Still},
    link::{Backend, Bus, BusOptions},
    time::Time,
};

#[test]
fn a_fleet_steps_every_robot_to_the_end_on_any_back_end_and_number_of_threads() {
    for backend in [Backend::Direct, Backend::Local, Backend::Shared] {
        for threads in [1, 2, 3] {
            let report = fly(backend, threads, 3, None);
            assert_eq!((report.ended, report.steps, report.time), (Ended::Complete, 101, Time::from_secs_f64(5.0)));
            for robot in &report.robots {
                // The follower hears the count of its own step, so all 101 counts: nothing is lost, not even the first.
                assert_eq!(robot.fact("sum"), Some(f64::from(101 * 102 / 2)), "{backend:?} on {threads} threads");
                assert_eq!((robot.fact("forward"), robot.fact("backward")), (Some(81.0), Some(20.0)));
                assert!(robot.fact("held_s.interrupter").unwrap() > 0.9);
            }
        }
    }
}

#[test]
fn a_paused_fleet_stands_still_until_it_may_step_and_a_stopped_one_ends() {
    let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
    let control = FleetControl::default();
    control.pause();
    control.step(3);
    let remote = control.clone();
    let watcher = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(150));
        remote.stop();
    });
    let plan = FleetPlan {
        robots: vec![robot(0, &bus, None)],
        environment: Box::new(Still),
        period: Duration::from_millis(50),
        duration: None,
        pace: Pace::AsFastAsPossible,
        leader: None,
        threads: 1,
        recorder: None,
        control,
        epoch: Default::default(),
        observer: Box::new(|_| ControlFlow::Continue(())),
    };
    let report = fleet::run(plan).unwrap();
    watcher.join().unwrap();
    assert_eq!(report.ended, Ended::Stopped);
    // The first step is free, three were allowed, and one more completes after the stop.
    assert!((4..=5).contains(&report.steps), "{}", report.steps);
}
