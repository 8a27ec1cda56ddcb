//! Bells between processes: here two buses of one process, which know as little of each other.
#![allow(clippy::unwrap_used, missing_docs)]

mod link_support;

use std::time::Duration;

use link_support::{Claim, Reading, Root, drained};
use orienteer_runtime::link::{Backend, Bus, LinkError, RobotBus, Wake};

const RUN: &str = "mission";

fn robot_on(bus: &Bus) -> RobotBus {
    bus.robot("huey").unwrap().open()
}

fn owner_and_guest(root: &Root) -> (RobotBus, RobotBus) {
    let owner = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
    let guest = Bus::attach(RUN, &root.options(None)).unwrap();
    (robot_on(&owner), robot_on(&guest))
}

/// As an actix arbiter is: one thread, and tasks that stay on it.
fn in_a_runtime(test: impl Future<Output = ()>) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(tokio::task::LocalSet::new().run_until(test));
}

#[test]
fn a_ring_wakes_the_other_side_both_ways() {
    in_a_runtime(async {
        let root = Root::new();
        let (owner, guest) = owner_and_guest(&root);
        let (owners_bell, guests_bell) = (owner.bell().unwrap(), guest.bell().unwrap());
        let (mut owners_doorbell, mut guests_doorbell) = (owner.doorbell().unwrap(), guest.doorbell().unwrap());
        for _ in 0..50 {
            owners_bell.ring();
            assert_eq!(guests_doorbell.wait().await.unwrap(), Wake::Rung);
            guests_bell.ring();
            assert_eq!(owners_doorbell.wait().await.unwrap(), Wake::Rung);
            assert_eq!(guests_doorbell.wait().await.unwrap(), Wake::Rung); // It hears its own bell, too.
        }
    });
}

#[test]
fn a_ring_wakes_one_that_already_waits() {
    in_a_runtime(async {
        let root = Root::new();
        let (owner, guest) = owner_and_guest(&root);
        let bell = owner.bell().unwrap();
        let mut doorbell = guest.doorbell().unwrap();
        let ringing = tokio::task::spawn_local(async move {
            loop {
                tokio::time::sleep(Duration::from_millis(2)).await;
                bell.ring();
            }
        });
        let mut rung = 0;
        while rung < 20 {
            if doorbell.wait().await.unwrap() == Wake::Rung {
                rung += 1;
            }
        }
        ringing.abort();
        assert!(ringing.await.unwrap_err().is_cancelled());
    });
}

#[test]
fn rings_before_the_wait_count_once() {
    in_a_runtime(async {
        let root = Root::new();
        let (owner, guest) = owner_and_guest(&root);
        let bell = owner.bell().unwrap();
        let mut doorbell = guest.doorbell().unwrap();
        for _ in 0..10 {
            bell.ring();
        }
        assert_eq!(doorbell.wait().await.unwrap(), Wake::Rung);
        assert_eq!(doorbell.wait().await.unwrap(), Wake::Timeout);
    });
}

#[test]
fn the_owner_does_not_wake_itself() {
    in_a_runtime(async {
        let root = Root::new();
        let (owner, guest) = owner_and_guest(&root);
        let (own, guests) = (owner.bell().unwrap(), guest.bell().unwrap());
        let mut doorbell = owner.doorbell().unwrap();
        own.ring();
        assert_eq!(doorbell.wait().await.unwrap(), Wake::Timeout);
        own.ring();
        guests.ring();
        assert_eq!(doorbell.wait().await.unwrap(), Wake::Rung);
        guests.ring();
        assert_eq!(doorbell.wait().await.unwrap(), Wake::Rung);
    });
}

#[test]
fn robots_have_bells_of_their_own() {
    in_a_runtime(async {
        let root = Root::new();
        let bus = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
        let guest = Bus::attach(RUN, &root.options(None)).unwrap();
        let luey = bus.robot("luey").unwrap().open().bell().unwrap();
        let mut doorbell = robot_on(&guest).doorbell().unwrap();
        luey.ring();
        assert_eq!(doorbell.wait().await.unwrap(), Wake::Timeout);
    });
}

#[test]
fn samples_rung_for_from_another_thread_all_arrive() {
    const ROUNDS: u32 = 2000;
    let root = Root::new();
    let bus = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
    let guest = Bus::attach(RUN, &root.options(None)).unwrap();
    let ticket = bus.robot("huey").unwrap();
    let robot = robot_on(&guest);
    let mut echoes = robot.publisher().unwrap();
    let mut readings = robot.subscriber::<Reading>().unwrap();
    let echoing = std::thread::spawn(move || {
        let robot = ticket.open();
        let (bell, mut publisher) = (robot.bell().unwrap(), robot.publisher().unwrap());
        let mut claims = robot.subscriber::<Claim>().unwrap();
        for value in 1..=ROUNDS {
            publisher.publish(Reading { writer: 0, value }).unwrap();
            bell.ring();
            // Not before the other side has seen it, so that nothing is overwritten.
            while drained(&mut claims).last().map(|claim| claim.value) != Some(value) {
                std::thread::yield_now();
            }
        }
    });
    in_a_runtime(async {
        let mut doorbell = robot.doorbell().unwrap();
        let mut next = 1;
        while next <= ROUNDS {
            doorbell.wait().await.unwrap();
            for reading in drained(&mut readings) {
                assert_eq!(reading.value, next);
                echoes.publish(Claim { writer: 0, value: next }).unwrap();
                next += 1;
            }
        }
    });
    echoing.join().unwrap();
}

#[test]
fn a_doorbell_needs_shared_links_and_a_runtime() {
    let root = Root::new();
    for backend in [Backend::Local, Backend::Direct] {
        let robot = robot_on(&root.open(backend));
        robot.bell().unwrap().ring(); // Nobody can hear it, and that is fine.
        let refused = robot.doorbell().unwrap_err();
        assert!(matches!(refused, LinkError::NeedsShared { .. }));
        assert!(refused.hint().contains("shared"));
    }
    let robot = robot_on(&root.open(Backend::Shared));
    assert!(matches!(robot.doorbell(), Err(LinkError::NoRuntime)));
}
