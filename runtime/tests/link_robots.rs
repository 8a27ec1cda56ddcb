//! Robots on a bus: their names, their threads, and that they never hear each other.
#![allow(clippy::unwrap_used, missing_docs)]

mod link_support;

use link_support::{Reading, Root, drained};
use orienteer_runtime::link::{Backend, LinkError};

fn reading(value: u32) -> Reading {
    Reading { writer: 0, value }
}

#[test]
fn ports_outlive_the_handles_they_came_from() {
    for backend in link_support::BACKENDS {
        let root = Root::new();
        let bus = root.open(backend);
        let robot = bus.robot("dewey").unwrap().open();
        let mut publisher = robot.publisher().unwrap();
        let mut subscriber = robot.subscriber::<Reading>().unwrap();
        drop(robot);
        assert!(matches!(bus.robot("dewey"), Err(LinkError::RobotTaken { robot }) if robot == "dewey"));
        drop(bus);
        publisher.publish(reading(5)).unwrap();
        assert_eq!(drained(&mut subscriber), [reading(5)]);
    }
}

#[test]
fn robots_and_runs_are_isolated() {
    for backend in link_support::BACKENDS {
        let root = Root::new();
        let (one, other) = (root.open(backend), root.open(backend));
        let buses = [("huey", &one), ("luey", &one), ("huey", &other)].map(|(name, bus)| bus.robot(name).unwrap().open());
        let mut ports: Vec<_> =
            buses.iter().map(|bus| (bus.publisher().unwrap(), bus.subscriber::<Reading>().unwrap())).collect();
        for (value, (publisher, _)) in (0..).zip(&mut ports) {
            assert_eq!(publisher.publish(reading(value)).unwrap(), 1);
        }
        for (value, (_, subscriber)) in (0..).zip(&mut ports) {
            assert_eq!(drained(subscriber), [reading(value)], "{backend:?}");
        }
    }
}

#[test]
fn a_robots_name_is_free_again_when_all_of_it_is_gone() {
    for backend in link_support::BACKENDS {
        let root = Root::new();
        let bus = root.open(backend);
        let ticket = bus.robot("huey").unwrap();
        assert!(matches!(bus.robot("huey"), Err(LinkError::RobotTaken { .. })));
        let subscriber = ticket.open().subscriber::<Reading>().unwrap();
        assert!(matches!(bus.robot("huey"), Err(LinkError::RobotTaken { .. })));
        drop(subscriber);
        bus.robot("huey").unwrap();
    }
}

#[test]
fn names_that_cannot_be_are_refused() {
    let root = Root::new();
    let bus = root.open(Backend::Direct);
    for name in ["", "a/b", "a b", "ä", &"x".repeat(65)] {
        let refused = bus.robot(name).unwrap_err();
        assert!(matches!(refused, LinkError::BadName { kind: "robot", .. }), "{name}");
    }
    bus.robot(&"x".repeat(64)).unwrap();
}

#[test]
fn robots_of_one_bus_live_on_threads_of_their_own() {
    for backend in link_support::BACKENDS {
        let root = Root::new();
        let bus = root.open(backend);
        let threads: Vec<_> = (0..4)
            .map(|n| {
                let ticket = bus.robot(&format!("robot-{n}")).unwrap();
                std::thread::spawn(move || {
                    let robot = ticket.open();
                    let mut publisher = robot.publisher().unwrap();
                    let mut subscriber = robot.subscriber::<Reading>().unwrap();
                    for value in 0..1000 {
                        publisher.publish(Reading { writer: n, value }).unwrap();
                        assert_eq!(drained(&mut subscriber), [Reading { writer: n, value }]);
                    }
                })
            })
            .collect();
        for thread in threads {
            thread.join().unwrap();
        }
    }
}
