//! What a sample costs: one writer of a scan publishes it, four readers drain it, all on one thread.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use orienteer_runtime::{
    link::{Backend, Bus, BusOptions, RobotBus},
    time::Time,
    topics::{BaseClaim, Echo, SonarScan},
};

const BACKENDS: [(&str, Backend); 3] = [("shared", Backend::Shared), ("local", Backend::Local), ("direct", Backend::Direct)];

fn robot(backend: Backend) -> RobotBus {
    Bus::open(backend, &BusOptions::default()).unwrap().robot("huey").unwrap().open()
}

fn scan(c: &mut Criterion) {
    let mut group = c.benchmark_group("one scan, four readers");
    for (name, backend) in BACKENDS {
        let robot = robot(backend);
        let mut publisher = robot.publisher().unwrap();
        let mut readers: Vec<_> = (0..4).map(|_| robot.subscriber::<SonarScan>().unwrap()).collect();
        let scan = SonarScan::from_echoes(Time::default(), 1, &[Echo::Range(1.0); 16]);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                publisher.publish(black_box(scan)).unwrap();
                for reader in &mut readers {
                    reader.drain(|scan| {
                        black_box(scan);
                    });
                }
            });
        });
    }
}

fn claims(c: &mut Criterion) {
    let mut group = c.benchmark_group("six claims, one reader");
    for (name, backend) in BACKENDS {
        let robot = robot(backend);
        let mut publishers: Vec<_> = (0..6).map(|_| robot.publisher::<BaseClaim>().unwrap()).collect();
        let mut reader = robot.subscriber::<BaseClaim>().unwrap();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                for publisher in &mut publishers {
                    publisher.publish(black_box(BaseClaim::default())).unwrap();
                }
                reader.drain(|claim| {
                    black_box(claim);
                });
            });
        });
    }
}

fn creation(c: &mut Criterion) {
    let mut group = c.benchmark_group("a topic with one writer and two readers, made and dropped");
    for (name, backend) in BACKENDS {
        let bus = Bus::open(backend, &BusOptions::default()).unwrap();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let robot = bus.robot("huey").unwrap().open();
                let publisher = robot.publisher::<SonarScan>().unwrap();
                let readers = [robot.subscriber::<SonarScan>().unwrap(), robot.subscriber::<SonarScan>().unwrap()];
                black_box((publisher, readers));
            });
        });
    }
}

criterion_group!(benches, scan, claims, creation);
criterion_main!(benches);
