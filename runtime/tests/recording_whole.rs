//! Recordings that end as they should: same bytes every time, and everything comes back.
#![allow(clippy::unwrap_used)]

mod recording_support;

use std::{fs, thread, time::Duration};

use mcap::MessageStream;
use orienteer_runtime::{geometry::Twist, recording::*, time::Time, topics::*};
use recording_support as made_up;
use sha2::{Digest, Sha256};

fn recorded(robots: usize, steps: u64, limits: ChunkLimits) -> RecordingSummary {
    let mut recorder = Recorder::start(Sink::Memory, &made_up::mission(robots), limits).unwrap();
    made_up::run(&mut recorder, robots, steps);
    recorder.finish().unwrap()
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn everything_comes_back_bit_by_bit() {
    let summary = recorded(2, 300, ChunkLimits { chunk_kib: 32, ..Default::default() });
    let reader = Reader::from_bytes(summary.memory.unwrap()).unwrap();
    assert_eq!(reader.mission(), &made_up::mission(2));
    assert_eq!(reader.sources().unwrap().len(), 2);
    assert_eq!((reader.ending(), reader.end_time()), (&Ending::Complete, Time::from_secs_f64(15.0)));
    for robot in 0..2 {
        let name = format!("r{robot}");
        let mut all = (
            reader.messages::<SonarScan>(&name).unwrap(),
            reader.messages::<Odometry>(&name).unwrap(),
            reader.messages::<PoseEstimate>(&name).unwrap(),
            reader.messages::<BaseDecision>(&name).unwrap(),
            reader.messages::<Truth>(&name).unwrap(),
        );
        for number in 1..=300 {
            let at = Time::START + made_up::PERIOD * number as u32;
            let expected = made_up::step(robot, number);
            assert_eq!(all.0.next().unwrap().unwrap(), (at, expected.scan));
            assert_eq!(all.1.next().unwrap().unwrap(), (at, expected.odometry));
            assert_eq!(all.2.next().unwrap().unwrap(), (at, expected.pose));
            assert_eq!(all.3.next().unwrap().unwrap(), (at, expected.decision));
            assert_eq!(all.4.next().unwrap().unwrap(), (at, expected.truth));
        }
        assert!(all.0.next().is_none() && all.4.next().is_none());
        let grids: Vec<_> = reader.grids(&name, "map").unwrap().map(Result::unwrap).collect();
        let expected: Vec<_> = [50, 150, 250].map(|n| (Time::START + made_up::PERIOD * n, made_up::grid(robot, n.into()))).into();
        assert_eq!(grids, expected);
        let lines: Vec<_> = reader.log_lines(&name).unwrap().map(|line| line.unwrap().1).collect();
        assert_eq!(lines.len(), 8);
        assert_eq!(lines[1], LogLine { level: tracing::Level::INFO, node: "corridor".into(), text: "step 47".into() });
    }
}

#[test]
fn a_decision_is_found_by_its_time_and_its_holder_by_name() {
    let summary = recorded(2, 300, ChunkLimits { chunk_kib: 16, ..Default::default() });
    let reader = Reader::from_bytes(summary.memory.unwrap()).unwrap();
    for millis in [0u64, 49, 50, 51, 99, 100, 4999, 5000, 7777, 14_999, 15_000, 99_000] {
        let found = reader.decision_at("r1", Time::from_nanos(millis * 1_000_000)).unwrap();
        let number = (millis / 50).min(300);
        let expected = made_up::step(1, number).decision;
        assert_eq!(found, (number > 0).then_some((expected.stamp, expected)), "at {millis} ms");
    }
    assert_eq!(reader.client_name("r1", ClientId(1)), Some("corridor"));
    assert_eq!(reader.client_name("r1", ClientId(3)), None);
    assert_eq!(reader.client_name("r1", ClientId::NONE), None);
}

#[test]
fn what_is_not_there_is_named() {
    let summary = recorded(2, 3, ChunkLimits::default());
    let reader = Reader::from_bytes(summary.memory.unwrap()).unwrap();
    let error = reader.messages::<Truth>("bob").unwrap_err().to_string();
    assert_eq!(error, "there is no robot `bob` in `in memory`; its robots are: r0, r1");
    assert!(reader.decision_at("bob", Time::FAR).is_err());
    assert_eq!(reader.messages::<CorridorReport>("r0").unwrap().count(), 0);
    assert!(reader.latest::<CorridorReport>("r0", Time::FAR).unwrap().is_none());
}

#[test]
fn the_bytes_do_not_depend_on_threads_or_timing() {
    let limits = ChunkLimits { chunk_kib: 64, ..Default::default() };
    let first = recorded(3, 400, limits.clone());
    assert_eq!(sha256(first.memory.as_ref().unwrap()), first.sha256);
    assert_eq!(first.memory.as_ref().unwrap().len() as u64, first.bytes);

    // Now each robot's track lives on a thread of its own, and every thread dawdles in its own way.
    let mut recorder = Recorder::start(Sink::Hash, &made_up::mission(3), limits).unwrap();
    let (mut senders, mut receivers) = (Vec::new(), Vec::new());
    for (robot, mut track) in made_up::tracks(3).into_iter().enumerate() {
        let (to_track, from_fleet) = std::sync::mpsc::channel::<Entries>();
        let (to_fleet, from_track) = std::sync::mpsc::channel();
        thread::spawn(move || {
            for number in 1..=400 {
                let mut empty = from_fleet.recv().unwrap();
                made_up::record(&mut track, robot, number);
                track.swap_entries(&mut empty);
                if number % (17 + robot as u64) == 0 {
                    thread::sleep(Duration::from_millis(1));
                }
                to_fleet.send(empty).unwrap();
            }
        });
        to_track.send(Entries::default()).unwrap();
        senders.push(to_track);
        receivers.push(from_track);
    }
    for number in 1..=400 {
        for (sender, receiver) in senders.iter().zip(&receivers) {
            let mut entries = receiver.recv().unwrap();
            recorder.append(&mut entries);
            if number < 400 {
                sender.send(entries).unwrap();
            }
        }
        if number % 50 == 0 {
            thread::sleep(Duration::from_millis(2));
        }
    }
    let second = recorder.finish().unwrap();
    assert_eq!((second.sha256, second.messages, second.memory), (first.sha256, first.messages, None));
}

#[test]
fn a_file_holds_what_the_summary_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut recorder = Recorder::start(Sink::File(path.clone()), &made_up::mission(1), ChunkLimits::default()).unwrap();
    made_up::run(&mut recorder, 1, 500);
    let summary = recorder.finish().unwrap();
    let bytes = fs::read(&path).unwrap();
    assert_eq!((summary.path.as_ref(), summary.bytes, &summary.sha256), (Some(&path), bytes.len() as u64, &sha256(&bytes)));
    assert_eq!(Reader::open(&path).unwrap().ending(), &Ending::Complete);

    // The format's own reader agrees on the number of messages, their order, and the index.
    let mut times = Vec::new();
    for message in MessageStream::new(&bytes).unwrap() {
        times.push(message.unwrap().log_time);
    }
    assert_eq!(times.len() as u64, summary.messages);
    assert!(times.is_sorted());
    let index = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(index.stats.as_ref().unwrap().message_count, summary.messages);
    assert_eq!((index.chunk_indexes.len(), index.attachment_indexes.len(), index.metadata_indexes.len()), (3, 2, 1));
}

#[test]
fn a_dropped_recorder_completes_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut recorder = Recorder::start(Sink::File(path.clone()), &made_up::mission(1), ChunkLimits::default()).unwrap();
    made_up::run(&mut recorder, 1, 10);
    drop(recorder);
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.ending(), &Ending::Complete);
    assert_eq!(reader.messages::<Truth>("r0").unwrap().count(), 10);
}

#[test]
fn chunks_reach_the_disk_while_the_run_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let limits = ChunkLimits { chunk_seconds: 1.0, ..Default::default() };
    let mut recorder = Recorder::start(Sink::File(path.clone()), &made_up::mission(1), limits).unwrap();
    made_up::run(&mut recorder, 1, 200);
    // 10 s were recorded. The last chunk is open and the last second may still be gathering; nothing else may be lost.
    let reader = (0..1000).find_map(|_| {
        thread::sleep(Duration::from_millis(10));
        let reader = Reader::open(&path).unwrap();
        (reader.end_time() >= Time::from_secs_f64(8.0)).then_some(reader)
    });
    let reader = reader.unwrap();
    assert!(matches!(reader.ending(), Ending::CutOff { .. }));
    let count = reader.messages::<Truth>("r0").unwrap().map(Result::unwrap).count();
    assert!(count >= 160, "only {count} samples are on disk");
    drop(recorder);
}

#[test]
fn no_number_is_lost_to_nan_or_infinity() {
    let mut recorder = Recorder::start(Sink::Memory, &made_up::mission(1), ChunkLimits::default()).unwrap();
    let mut track = Track::new(0, "r0", None);
    let motion = Motion::velocity(Twist::new(f64::NAN, f64::NEG_INFINITY));
    let claim = BaseClaim { motion, ..BaseClaim::default() };
    track.begin(Time::from_nanos(5));
    track.record(&claim);
    recorder.append(track.entries());
    let reader = Reader::from_bytes(recorder.finish().unwrap().memory.unwrap()).unwrap();
    let (_, back) = reader.latest::<BaseClaim>("r0", Time::FAR).unwrap().unwrap();
    assert_eq!(format!("{back:?}"), format!("{claim:?}"));
    assert_eq!(track.unrecorded(), 0);
}

#[test]
fn a_muted_track_encodes_nothing() {
    let mut track = Track::new(0, "r0", None);
    track.begin(Time::from_nanos(5));
    track.record(&Odometry::default());
    assert!(!track.is_muted() && !track.entries().is_empty());
    track.mute();
    assert!(track.is_muted() && track.entries().is_empty());
    track.begin(Time::from_nanos(10));
    track.record(&Odometry::default());
    track.log(tracing::Level::INFO, "base", "here I am");
    assert!(track.entries().is_empty() && track.unrecorded() == 0);
}

/// Payloads that people bring themselves.
mod own {
    pub mod old {
        use iceoryx2::prelude::ZeroCopySend;
        use orienteer_runtime::topics::Payload;
        use schemars::JsonSchema;
        use serde::{Deserialize, Serialize};

        #[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
        #[repr(C)]
        #[type_name("mine::Smell.v1")]
        pub struct Smell {
            pub strength: f32,
            pub pleasant: bool,
            pub parts: [u8; 3],
        }

        impl Payload for Smell {
            const TOPIC: &'static str = "nose/smell";
        }
    }

    pub mod new {
        use iceoryx2::prelude::ZeroCopySend;
        use orienteer_runtime::topics::Payload;
        use schemars::JsonSchema;
        use serde::{Deserialize, Serialize};

        #[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
        #[repr(C)]
        #[type_name("mine::Smell.v1")]
        pub struct Smell {
            pub pleasant: bool,
            pub strength: f32,
            pub parts: [u8; 3],
        }

        impl Payload for Smell {
            const TOPIC: &'static str = "nose/smell";
        }

        #[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
        #[repr(C)]
        #[type_name("mine::Taste.v1")]
        pub struct Taste {
            pub kind: Kind,
        }

        #[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
        #[repr(C)]
        #[type_name("mine::Kind.v1")]
        pub enum Kind {
            #[default]
            Sweet,
            Sour,
        }

        impl Payload for Taste {
            const TOPIC: &'static str = "tongue/taste";
        }
    }
}

#[test]
fn payloads_of_ones_own_are_recorded_too() {
    let mut recorder = Recorder::start(Sink::Memory, &made_up::mission(1), ChunkLimits::default()).unwrap();
    let mut track = Track::new(0, "r0", None);
    let smell = own::old::Smell { strength: 0.5, pleasant: true, parts: [1, 2, 3] };
    let taste = own::new::Taste { kind: own::new::Kind::Sour };
    track.record(&smell);
    track.record(&own::new::Taste::default());
    track.record(&taste);
    recorder.append(track.entries());
    let bytes = recorder.finish().unwrap().memory.unwrap();

    let mut forms: Vec<_> = mcap::Summary::read(&bytes)
        .unwrap()
        .unwrap()
        .channels
        .values()
        .map(|channel| (channel.schema.as_ref().unwrap().name.clone(), channel.message_encoding.clone()))
        .collect();
    forms.sort();
    assert_eq!(forms, [("Taste".into(), "json".into()), ("mine/Smell".into(), "ros1".into())]);

    let reader = Reader::from_bytes(bytes).unwrap();
    assert_eq!(reader.latest::<own::old::Smell>("r0", Time::FAR).unwrap().unwrap().1, smell);
    let tastes: Vec<_> = reader.messages::<own::new::Taste>("r0").unwrap().map(|taste| taste.unwrap().1).collect();
    assert_eq!(tastes, [own::new::Taste::default(), taste]);
    // The same name, yet other fields: somebody forgot to count the version up.
    let error = reader.messages::<own::new::Smell>("r0").unwrap_err().to_string();
    assert!(error.ends_with("holds mine::Smell.v1 with other fields, this program reads mine::Smell.v1 with its own"), "{error}");
}

#[test]
fn two_recordings_part_at_the_first_message_that_differs() {
    let run = |steps: u64, odd: Option<u64>, chunk_kib| {
        let limits = ChunkLimits { chunk_kib, ..Default::default() };
        let mut recorder = Recorder::start(Sink::Memory, &made_up::mission(2), limits).unwrap();
        let mut tracks = made_up::tracks(2);
        for number in 1..=steps {
            for (robot, track) in tracks.iter_mut().enumerate() {
                track.begin(Time::START + made_up::PERIOD * number as u32);
                let mut step = made_up::step(robot, number);
                step.truth.collisions += u32::from(robot == 1 && odd == Some(number));
                track.record(&step.pose);
                track.record(&step.truth);
                recorder.append(track.entries());
            }
        }
        Reader::from_bytes(recorder.finish().unwrap().memory.unwrap()).unwrap()
    };
    let whole = run(200, None, 8);
    assert_eq!(whole.first_difference(&run(200, None, 64)).unwrap(), None);
    let other = whole.first_difference(&run(200, Some(123), 8)).unwrap().unwrap();
    assert_eq!(other.to_string(), "the messages of `/r1/truth` at 0:06.150 differ");
    let shorter = whole.first_difference(&run(100, None, 8)).unwrap().unwrap();
    assert_eq!(shorter.to_string(), "only the first goes on with `/r0/pose` at 0:05.050");
}
