//! What a scan costs the mapper, and what decay costs the map.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{f64::consts::TAU, hint::black_box};

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Point2;
use orienteer_agents::{
    certainty_grid::{Grid, Layout, Rules, decay::Decay},
    mapper::{Config, Extent, Mapper},
};
use orienteer_runtime::{
    geometry::Pose,
    robot_model::{Ring, Transducer},
    time::Time,
    topics::{Echo, FiringProgram, SonarScan},
};

fn ring() -> Ring {
    let transducer = |i: u32| {
        let bearing = TAU * f64::from(i) / 16.0;
        Transducer { mount: Pose::new(0.2 * bearing.cos(), 0.2 * bearing.sin(), bearing), half_beam: 0.2 }
    };
    Ring {
        name: "bench".to_owned(),
        transducers: (0..16).map(transducer).collect(),
        min_range: 0.1,
        max_range: 6.0,
        slot_time: 0.03,
        program: FiringProgram::default(),
    }
}

/// A robot that turns and drives a little between scans.
fn scans(criterion: &mut Criterion, name: &str, config: Config, range: impl Fn(u64, usize) -> Echo) {
    let mut mapper = Mapper::new(config, &ring(), Pose::default()).unwrap();
    let mut seq = 0u64;
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| {
            seq += 1;
            let angle = 0.01 * seq as f64;
            let pose = Pose::new(angle.sin(), angle.cos(), -angle);
            let mut scan = SonarScan::unfired(16);
            (scan.stamp, scan.seq) = (Time::from_secs_f64(0.05 * seq as f64), seq);
            for i in 0..16 {
                scan.set(i, range(seq, i), 0.002 * i as f32);
            }
            black_box(mapper.update(pose, &scan))
        });
    });
}

fn mapper(criterion: &mut Criterion) {
    let window = Config { extent: Extent::Recentre { margin: 3.0 }, ..Config::default() };
    let far = |mut config: Config| {
        config.marking.clear_to = 6.0;
        config.marking.object_within = 6.0;
        config.marking.silence.clear_to = 6.0;
        config
    };
    let room = |seq: u64, i: usize| match (seq / 7 + i as u64 * 5) % 16 {
        0 | 5 | 11 => Echo::Nothing,
        k => Echo::Range(0.6 + 0.3 * k as f32),
    };
    scans(criterion, "mapper/16 sonars, mixed ranges, defaults", window.clone(), room);
    scans(criterion, "mapper/16 sonars, mixed ranges, full reach", far(window.clone()), room);
    scans(criterion, "mapper/16 sonars, all silent, full reach of 6 m", far(window), |_, _| Echo::Nothing);
    scans(criterion, "mapper/16 sonars, mixed ranges, 20 cm cells of 1992", Config::luey(), room);

    let layout = Layout::around(Point2::origin(), 0.2, 20.0, 20.0);
    let mut grid = Grid::new(layout, Rules::default()).unwrap();
    let mut decay = Decay::default();
    criterion.bench_function("grid/decay of 100 x 100 cells", |bencher| bencher.iter(|| decay.apply(&mut grid, 0.05)));
    criterion.bench_function("grid/recentre 100 x 100 cells", |bencher| {
        let mut there = true;
        bencher.iter(|| {
            there = !there;
            grid.shift(if there { 35 } else { -35 }, 3);
        });
    });
}

criterion_group!(benches, mapper);
criterion_main!(benches);
