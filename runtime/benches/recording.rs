//! What recording costs a robot in one step: encoding beside the actors, and all of it to the finished hash.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../tests/recording_support/mod.rs"]
mod made_up;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use orienteer_runtime::{
    recording::{ChunkLimits, Recorder, Sink, Track},
    time::Time,
    topics::Payload,
};

/// The topics of one step, without log lines and grids.
fn record(track: &mut Track, step: &made_up::Step) {
    track.begin(step.truth.stamp);
    track.record(black_box(&step.scan));
    track.record(black_box(&step.odometry));
    track.record(black_box(&step.pose));
    track.record(black_box(&step.decision));
    track.record(black_box(&step.truth));
}

fn steps() -> Vec<made_up::Step> {
    (1..=1000).map(|number| made_up::step(0, number)).collect()
}

fn encoding(bench: &mut Criterion) {
    let steps = steps();
    let mut group = bench.benchmark_group("encode one robot step");
    for (name, ring) in [("with views", Some(made_up::even_ring(16))), ("scan undrawn", None)] {
        let mut track = Track::new(0, "r0", ring.as_ref());
        let mut steps = steps.iter().cycle();
        group.bench_function(name, |b| {
            b.iter(|| {
                record(&mut track, steps.next().unwrap());
                track.entries().clear();
            });
        });
    }
    group.finish();
    let mut group = bench.benchmark_group("the same samples as JSON");
    fn json<P: Payload>(sample: &P, bytes: &mut Vec<u8>) {
        serde_json::to_writer(bytes, black_box(sample)).unwrap();
    }
    let (mut bytes, mut steps) = (Vec::new(), steps.iter().cycle());
    group.bench_function("without views", |b| {
        b.iter(|| {
            let step = steps.next().unwrap();
            bytes.clear();
            json(&step.scan, &mut bytes);
            json(&step.odometry, &mut bytes);
            json(&step.pose, &mut bytes);
            json(&step.decision, &mut bytes);
            json(&step.truth, &mut bytes);
        });
    });
    group.finish();
}

/// Throughput of everything, the writing thread included: ten minutes of two robots at 20 Hz.
fn whole(bench: &mut Criterion) {
    let steps = steps();
    let mut group = bench.benchmark_group("record 24000 robot steps");
    group.sample_size(10);
    let folder = tempfile::tempdir().unwrap();
    for (name, sink) in [("hash only", Sink::Hash), ("to a file", Sink::File(folder.path().join("run.mcap")))] {
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut recorder = Recorder::start(sink.clone(), &made_up::mission(2), ChunkLimits::default()).unwrap();
                let mut tracks = made_up::tracks(2);
                for number in 0..12_000u64 {
                    let mut step = steps[number as usize % steps.len()];
                    step.truth.stamp = Time::START + made_up::PERIOD * number as u32;
                    for track in &mut tracks {
                        record(track, &step);
                        recorder.append(track.entries());
                    }
                }
                recorder.finish().unwrap()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, encoding, whole);
criterion_main!(benches);
