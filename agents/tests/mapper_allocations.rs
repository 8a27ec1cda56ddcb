//! A warm mapper allocates nothing.
#![allow(clippy::unwrap_used, missing_docs)]

use std::f64::consts::TAU;

use allocation_counter::measure;
use orienteer_agents::{
    certainty_grid::decay::DecayConfig,
    mapper::{Config, Extent, Mapper},
};
use orienteer_runtime::{
    geometry::Pose,
    robot_model::{Ring, Transducer},
    time::Time,
    topics::{Echo, FiringProgram, SonarScan},
};

#[test]
fn a_warm_mapper_allocates_nothing() {
    let at = |i: u32| TAU * f64::from(i) / 16.0;
    let mut transducers: Vec<_> =
        (0..16).map(|i| Transducer { mount: Pose::new(0.2 * at(i).cos(), 0.2 * at(i).sin(), at(i)), half_beam: 0.2 }).collect();
    // a pair as well
    transducers.push(Transducer { mount: Pose::new(0.2, 0.2, 0.0), half_beam: 0.2 });
    let ring = Ring {
        name: "test".to_owned(),
        transducers,
        min_range: 0.1,
        max_range: 6.0,
        slot_time: 0.03,
        program: FiringProgram::default(),
    };
    let decay = DecayConfig { enabled: true, ..DecayConfig::default() };
    let config = Config { extent: Extent::Recentre { margin: 3.0 }, decay, ..Config::default() };
    let mut mapper = Mapper::new(config, &ring, Pose::default()).unwrap();
    assert_eq!(mapper.pairs().len(), 1);
    let mut bytes = Vec::new();
    let mut scan = |i: u32| {
        let t = f64::from(i);
        let pose = Pose::new(0.05 * t, 0.5 * (0.05 * t).sin(), 0.1 * t);
        let mut scan = SonarScan::unfired(17);
        (scan.stamp, scan.seq) = (Time::from_secs_f64(0.1 * t), u64::from(i) + 1);
        for k in 0..17u32 {
            let echo =
                if (i + k).is_multiple_of(5) { Echo::Nothing } else { Echo::Range(0.3 + 0.25 * ((i / 9 + k) % 16) as f32) };
            scan.set(k as usize, echo, 0.01 * k as f32);
        }
        mapper.update(pose, &scan);
        mapper.grid().occupancy_bytes(&mut bytes);
    };
    let mut drive = |steps: std::ops::Range<u32>| measure(|| steps.for_each(&mut scan)).count_total;
    assert!(drive(0..100) > 0, "the counter counts");
    assert_eq!(drive(100..2000), 0);
}
