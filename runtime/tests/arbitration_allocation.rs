//! A warm step of arbitration allocates nothing.
#![allow(clippy::unwrap_used)]

use std::time::Duration;

use allocation_counter::measure;
use orienteer_runtime::{
    arbitration::{
        Clients,
        base::BaseArbiter,
        client::BaseHandle,
        sonar::{SafetyFloor, SonarArbiter},
    },
    geometry::{Limits, Twist},
    robot_model::{Ring, Transducer},
    time::Time,
    topics::{ClientId, FiringProgram, SonarClaim},
};

#[test]
fn a_warm_step_allocates_nothing() {
    let clients: Clients = [("a", 3), ("b", 3), ("c", 5), ("d", 9)].into_iter().collect();
    let transducer = Transducer { mount: Default::default(), half_beam: 0.2 };
    let mut program = FiringProgram::default();
    (0..16).for_each(|i| assert!(program.slots.push(1 << i)));
    let ring = Ring {
        name: "ring".into(),
        transducers: vec![transducer; 16],
        min_range: 0.2,
        max_range: 7.0,
        slot_time: 0.025,
        program,
    };
    let floor = SafetyFloor::new(&ring, 0b11, 0.2).unwrap();
    let mut sonar = SonarArbiter::new(&clients, &ring, floor);
    let mut base = BaseArbiter::new(&clients);
    let mut handles: Vec<BaseHandle> = (0..4).map(|i| BaseHandle::new(ClientId(i))).collect();
    let mut notices = Vec::new();
    let (mut now, mut told) = (Time::START, 0);
    let mut step = |i: u64| {
        now = now + Duration::from_millis(50);
        notices.clear();
        for (k, handle) in handles.iter_mut().enumerate() {
            // Everyone comes and goes, in another rhythm each.
            match (i / (k as u64 + 2)) % 4 {
                0 => handle.release(),
                1 => handle.wait_at_most(Duration::from_millis(100)),
                _ => handle.drive(Twist::new(0.1, i as f64)),
            }
            handle.limit(Limits { linear: 0.3, angular: 1.0 });
            base.claim(&handle.claim(now, Duration::from_millis(120)));
        }
        let decision = base.decide(now, &mut notices);
        handles.iter_mut().for_each(|handle| handle.hear(&notices, Some(&decision), None));
        let mut wanted = ring.program;
        wanted.slots[3] = 1 << (i % 16);
        sonar.claim(&SonarClaim {
            client: ClientId((i % 4) as u16),
            stamp: now,
            valid_until: now + Duration::from_secs(1),
            program: wanted,
        });
        assert!(sonar.decide(now).floor != 0);
        told += notices.len();
    };
    let cold = measure(|| (0..1000).for_each(&mut step)).count_total;
    assert_eq!(measure(|| (1000..2000).for_each(&mut step)).count_total, 0);
    assert!(cold > 0 && told > 1000, "{cold} allocations, {told} notices");
}
