//! A warm step asks for no memory of its own. iceoryx2 0.10 asks for one small piece for each sample that is published, and
//! frees it at once.
#![allow(clippy::unwrap_used, missing_docs)]

mod link_support;

use allocation_counter::measure;
use link_support::{BACKENDS, Claim, Root};
use orienteer_runtime::{
    link::{Backend, Bus},
    topics::{Odometry, SonarScan},
};

/// Requests for memory, and samples published, in a thousand warm steps.
fn a_thousand_steps(bus: &Bus) -> (u64, u64) {
    let robot = bus.robot("huey").unwrap().open();
    let mut scans = robot.publisher::<SonarScan>().unwrap();
    let mut odometry = robot.publisher::<Odometry>().unwrap();
    let mut claims: Vec<_> = (0..6).map(|_| robot.publisher::<Claim>().unwrap()).collect();
    let mut scan_readers: Vec<_> = (0..4).map(|_| robot.subscriber::<SonarScan>().unwrap()).collect();
    let mut odometry_reader = robot.subscriber::<Odometry>().unwrap();
    let mut claim_reader = robot.subscriber::<Claim>().unwrap();
    let bell = robot.bell().unwrap();

    let mut published = 0;
    let mut step = |overflowing: bool| {
        let rounds = if overflowing { 20 } else { 1 };
        published += 1 + rounds * 7;
        for _ in 0..rounds {
            scans.publish(SonarScan::unfired(16)).unwrap();
            for claim in claims.iter_mut().rev() {
                claim.publish(Claim::default()).unwrap();
            }
        }
        odometry.publish(Odometry::default()).unwrap();
        bell.ring();
        let mut read = 0;
        for reader in &mut scan_readers {
            read += reader.drain(|scan| assert_eq!(scan.len(), 16));
        }
        read += usize::from(odometry_reader.take().is_some());
        (read + claim_reader.drain(|_| ()), published)
    };
    assert_eq!(step(false).0, 4 + 1 + 6);
    let (_, before) = step(true); // Warm: every queue has been full once.
    let mut after = before;
    let requests = measure(|| after = (0..1000).map(|n| step(n % 10 == 0).1).last().unwrap()).count_total;
    (requests, after - before)
}

#[test]
fn a_warm_step_asks_for_no_memory() {
    for backend in BACKENDS {
        let root = Root::new();
        let (requests, published) = a_thousand_steps(&root.open(backend));
        match backend {
            Backend::Direct => assert_eq!(requests, 0),
            Backend::Shared | Backend::Local => assert!(requests <= published, "{requests} for {published} samples"),
        }
    }
}
