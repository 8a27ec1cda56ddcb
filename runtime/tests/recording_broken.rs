//! Recordings that are cut off, damaged, foreign, or cannot be written.
#![allow(clippy::unwrap_used)]

mod recording_support;

use std::{collections::BTreeMap, path::PathBuf};

use mcap::records::{Record, op};
use orienteer_runtime::{recording::*, time::Time, topics::*};
use proptest::prelude::*;
use recording_support as made_up;

fn recorded(robots: usize, steps: u64, chunk_kib: u32) -> Vec<u8> {
    let limits = ChunkLimits { chunk_kib, ..Default::default() };
    let mut recorder = Recorder::start(Sink::Memory, &made_up::mission(robots), limits).unwrap();
    made_up::run(&mut recorder, robots, steps);
    recorder.finish().unwrap().memory.unwrap()
}

/// Where each of the file's records ends, and how many decisions of `r0` stand before that place: read with the format's own
/// reader, without a look at ours.
fn record_ends(bytes: &[u8]) -> Vec<(usize, u8, usize)> {
    let (mut ends, mut at, mut decisions, mut topic) = (Vec::new(), 8, 0, None);
    while at + 9 <= bytes.len() - 8 {
        let code = bytes[at];
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        let body = &bytes[at + 9..at + 9 + length];
        at += 9 + length;
        if code == op::CHUNK {
            let Record::Chunk { header, data } = mcap::parse_record(code, body).unwrap() else { unreachable!() };
            for record in mcap::read::ChunkReader::new(header, &data).unwrap() {
                match record.unwrap() {
                    Record::Channel(channel) if channel.topic == "/r0/base/decision" => topic = Some(channel.id),
                    Record::Message { header, .. } if Some(header.channel_id) == topic => decisions += 1,
                    _ => {}
                }
            }
        }
        ends.push((at, code, decisions));
    }
    ends
}

fn assert_decisions(reader: &Reader, expected: usize) {
    let found: Vec<_> = reader.messages::<BaseDecision>("r0").unwrap().map(|found| found.unwrap().1).collect();
    assert_eq!(found.len(), expected);
    for (decision, number) in found.iter().zip(1..) {
        assert_eq!(*decision, made_up::step(0, number).decision);
    }
}

/// A file cut to `length` bytes opens if its mission is whole, and shows all messages of whole chunks.
fn assert_readable(bytes: &[u8], ends: &[(usize, u8, usize)], length: usize) {
    let cut = bytes[..length].to_vec();
    let described = ends.iter().any(|(end, code, _)| *code == op::METADATA && *end <= length);
    match Reader::from_bytes(cut) {
        Ok(reader) => {
            assert!(described, "opened with {length} bytes");
            let (_, _, decisions) = ends.iter().rfind(|(end, _, _)| *end <= length).unwrap();
            assert_decisions(&reader, *decisions);
            assert_eq!(*reader.ending() == Ending::Complete, length == bytes.len());
            let attached = ends.iter().filter(|(end, code, _)| *code == op::ATTACHMENT && *end <= length).count();
            assert_eq!(reader.sources().is_some(), attached == 2);
        }
        Err(ReadError::Empty { .. }) => assert!(!described, "refused {length} bytes"),
        Err(error) => panic!("{length} bytes: {error}"),
    }
}

#[test]
fn a_small_recording_is_readable_when_cut_at_any_byte() {
    let bytes = recorded(1, 4, 2);
    let ends = record_ends(&bytes);
    assert!(ends.iter().filter(|(_, code, _)| *code == op::CHUNK).count() >= 3);
    for length in 0..=bytes.len() {
        assert_readable(&bytes, &ends, length);
    }
}

#[test]
fn a_larger_recording_is_readable_when_cut_around_every_record_and_between() {
    let bytes = recorded(2, 100, 32);
    let ends = record_ends(&bytes);
    let around = ends.iter().flat_map(|(end, _, _)| end.saturating_sub(2)..=(end + 10).min(bytes.len()));
    let between = (0..bytes.len()).step_by(bytes.len() / 500);
    for length in around.chain(between) {
        assert_readable(&bytes, &ends, length);
    }
}

#[test]
fn a_cut_is_told_with_its_place() {
    let bytes = recorded(1, 4, 2);
    let ends = record_ends(&bytes);
    let (end, ..) = ends.iter().rfind(|(_, code, _)| *code == op::CHUNK).unwrap();
    let begin = ends.iter().rfind(|(other, ..)| other < end).unwrap().0;
    let reader = Reader::from_bytes(bytes[..end - 1].to_vec()).unwrap();
    assert_eq!(reader.ending().to_string(), format!("cut off in the record at byte {begin}"));
}

#[test]
fn damage_in_a_chunk_ends_the_recording_before_it() {
    let bytes = recorded(1, 40, 8);
    let ends = record_ends(&bytes);
    let chunk = ends.iter().enumerate().filter(|(_, (_, code, _))| *code == op::CHUNK).nth(2).unwrap().0;
    let (before, _, decisions) = ends[chunk - 1];
    let mut damaged = bytes.clone();
    damaged[before + 500] ^= 4;
    let reader = Reader::from_bytes(damaged).unwrap();
    assert_eq!(reader.ending(), &Ending::Damaged { at: before as u64, what: "the chunk's checksum is wrong".into() });
    assert!(decisions > 0);
    assert_decisions(&reader, decisions);
}

#[test]
fn damage_in_a_chunk_s_header_leaves_what_stands_before_and_never_misleads() {
    let bytes = recorded(1, 40, 8);
    let ends = record_ends(&bytes);
    let chunk = ends.iter().enumerate().filter(|(_, (_, code, _))| *code == op::CHUNK).nth(1).unwrap().0;
    let ((before, _, decisions), total) = (ends[chunk - 1], ends.last().unwrap().2);
    assert!(0 < decisions && decisions < total);
    for (place, bit) in (before..before + 49).flat_map(|place| (0..8).map(move |bit| (place, bit))) {
        let mut damaged = bytes.clone();
        damaged[place] ^= 1 << bit;
        let reader = Reader::from_bytes(damaged).unwrap();
        assert_ne!(reader.ending(), &Ending::Complete, "bit {bit} of byte {}", place - before);
        let found = reader.messages::<BaseDecision>("r0").unwrap().count();
        assert!(found >= decisions);
        assert_decisions(&reader, found);
        for number in 1..=found as u64 {
            let expected = made_up::step(0, number).decision;
            assert_eq!(reader.decision_at("r0", expected.stamp).unwrap(), Some((expected.stamp, expected)));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5000))]

    /// Whatever bytes change: no panic, and no message that was never recorded.
    #[test]
    fn damage_anywhere_is_survived(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        cut in any::<prop::sample::Index>(),
        near_start in any::<bool>(),
    ) {
        let mut bytes = small().clone();
        let span = if near_start { 1000 } else { bytes.len() };
        for (place, value) in changes {
            bytes[place.index(span)] = value;
        }
        bytes.truncate(bytes.len() - cut.index(bytes.len()) / 4);
        if let Ok(reader) = Reader::from_bytes(bytes) {
            for (number, found) in (1..).zip(reader.messages::<BaseDecision>("r0").into_iter().flatten()) {
                prop_assert_eq!(found.unwrap().1, made_up::step(0, number).decision);
            }
            for line in reader.log_lines("r0").into_iter().flatten() {
                let _ = line;
            }
            for grid in reader.grids("r0", "map").into_iter().flatten() {
                let _ = grid;
            }
        }
    }

    #[test]
    fn noise_is_not_a_recording(noise in prop::collection::vec(any::<u8>(), 0..200), magic in any::<bool>()) {
        let bytes = if magic { [mcap::MAGIC, &noise[..]].concat() } else { noise };
        prop_assert!(Reader::from_bytes(bytes).is_err());
    }
}

/// Records of every kind that are too short for what they must hold, with lengths inside that promise nothing or too much.
#[test]
fn short_records_are_survived() {
    let bytes = recorded(1, 4, 2);
    let (head, ..) = *record_ends(&bytes).iter().find(|(_, code, _)| *code == op::METADATA).unwrap();
    for (code, fill) in (0..=20).flat_map(|code| [(code, 0), (code, 1), (code, 0xff)]) {
        for length in 0..80usize {
            let mut file = bytes[..head].to_vec();
            file.push(code);
            file.extend_from_slice(&(length as u64).to_le_bytes());
            file.resize(file.len() + length, fill);
            let reader = Reader::from_bytes(file).unwrap();
            assert_ne!(reader.ending(), &Ending::Complete);
            assert_eq!(reader.messages::<BaseDecision>("r0").unwrap().count(), 0);
        }
    }
}

fn small() -> &'static Vec<u8> {
    static SMALL: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();
    SMALL.get_or_init(|| recorded(1, 60, 8))
}

#[test]
fn another_layout_is_refused_with_both_versions() {
    let bytes = with_metadata([("layout", "2"), ("seed", "1")]);
    let error = Reader::from_bytes(bytes).unwrap_err();
    assert_eq!(error.to_string(), "`in memory` has layout 2, this program reads layout 1");
    let error = Reader::from_bytes(with_metadata([("layout", "1"), ("version", "0.1.0")])).unwrap_err();
    assert_eq!(error.to_string(), "`in memory` has a damaged description of its mission: its entry `robots` is missing");
    assert!(matches!(Reader::from_bytes(with_metadata([("seed", "1")])), Err(ReadError::Foreign { .. })));
}

fn with_metadata<const N: usize>(entries: [(&str, &str); N]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = mcap::Writer::new(std::io::Cursor::new(&mut bytes)).unwrap();
    let metadata = entries.map(|(key, value)| (key.to_owned(), value.to_owned())).into();
    writer.write_metadata(&mcap::records::Metadata { name: "orienteer".into(), metadata }).unwrap();
    writer.finish().unwrap();
    drop(writer);
    bytes
}

#[test]
fn foreign_files_are_named_as_such() {
    let mut bytes = Vec::new();
    let mut writer = mcap::Writer::new(std::io::Cursor::new(&mut bytes)).unwrap();
    let channel = writer.add_channel(0, "/chatter", "json", &BTreeMap::new()).unwrap();
    let header = mcap::records::MessageHeader { channel_id: channel, sequence: 1, log_time: 1, publish_time: 1 };
    writer.write_to_known_channel(&header, b"{}").unwrap();
    writer.finish().unwrap();
    drop(writer);
    assert!(matches!(Reader::from_bytes(bytes), Err(ReadError::Foreign { .. })));
    assert!(matches!(Reader::from_bytes(b"[robot]\nname = \"ann\"\n".to_vec()), Err(ReadError::NotMcap { .. })));
    let error = Reader::open("/nowhere/run.mcap").unwrap_err().to_string();
    assert!(error.starts_with("cannot read the recording `/nowhere/run.mcap`: "), "{error}");
    assert!(Reader::open(std::env::temp_dir()).is_err());
}

#[test]
fn samples_of_another_version_are_refused_with_both_names() {
    let mut bytes = recorded(1, 2, 8);
    // As if this program's Truth were of version 1 and the recording's of version 7. The chunk's checksum must follow.
    let needle = b"orienteer::Truth.v1";
    let places: Vec<_> = (0..bytes.len() - needle.len()).filter(|i| bytes[*i..].starts_with(needle)).collect();
    assert_eq!(places.len(), 2, "in the chunk and in the summary");
    bytes[places[0] + needle.len() - 1] = b'7';
    let ends = record_ends_unchecked(&bytes);
    let chunk = ends.iter().find(|(begin, end)| (*begin..*end).contains(&places[0])).unwrap();
    let checksum = crc32fast::hash(&bytes[chunk.0 + 9 + 40..chunk.1]);
    bytes[chunk.0 + 9 + 24..chunk.0 + 9 + 28].copy_from_slice(&checksum.to_le_bytes());
    let reader = Reader::from_bytes(bytes).unwrap();
    let error = reader.messages::<Truth>("r0").unwrap_err().to_string();
    assert_eq!(error, "`/r0/truth` in `in memory` holds orienteer::Truth.v7, this program reads orienteer::Truth.v1");
    assert_decisions(&reader, 2);
}

/// Begin and end of each record.
fn record_ends_unchecked(bytes: &[u8]) -> Vec<(usize, usize)> {
    let (mut ends, mut at) = (Vec::new(), 8);
    while at + 9 <= bytes.len() - 8 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        ends.push((at, at + 9 + length));
        at += 9 + length;
    }
    ends
}

#[test]
fn a_file_that_cannot_be_created_is_told_with_its_path() {
    let path = PathBuf::from("/nowhere/run.mcap");
    let error = Recorder::start(Sink::File(path), &made_up::mission(1), ChunkLimits::default()).unwrap_err().to_string();
    assert!(error.starts_with("cannot create the recording `/nowhere/run.mcap`: "), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_from_the_start_is_told() {
    let path = PathBuf::from("/dev/full");
    let limits = ChunkLimits { chunk_kib: 8, ..Default::default() };
    // What stands before the messages is flushed at once.
    let error = Recorder::start(Sink::File(path), &made_up::mission(1), limits).unwrap_err().to_string();
    assert!(error.starts_with("cannot write the recording `/dev/full`: "), "{error}");
}

/// Two runs into one file would leave what nobody can read, and the second must not cut off what the first has written.
#[test]
fn a_second_recorder_is_refused_and_leaves_the_file_to_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let start = || Recorder::start(Sink::File(path.clone()), &made_up::mission(1), ChunkLimits::default());
    let mut first = start().unwrap();
    let error = start().unwrap_err().to_string();
    let expected = format!("cannot create the recording `{}`: another run records into it", path.display());
    assert_eq!(error, expected);
    made_up::run(&mut first, 1, 40);
    first.finish().unwrap();
    let reader = Reader::open(&path).unwrap();
    assert_eq!(*reader.ending(), Ending::Complete);
    assert_decisions(&reader, 40);
    // The file is free again, and is replaced as before.
    start().unwrap().finish().unwrap();
    assert_decisions(&Reader::open(&path).unwrap(), 0);
}

/// The file is a pipe whose reader goes away in the middle of the run.
#[cfg(unix)]
#[test]
fn a_write_that_fails_later_is_told_and_does_not_stop_the_run() {
    use std::io::Read;

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
    let reader = std::thread::spawn({
        let path = path.clone();
        move || std::fs::File::open(path).unwrap().read_exact(&mut [0; 20_000]).unwrap()
    });
    let limits = ChunkLimits { chunk_kib: 8, ..Default::default() };
    let mut recorder = Recorder::start(Sink::File(path.clone()), &made_up::mission(1), limits).unwrap();
    made_up::run(&mut recorder, 1, 5000);
    reader.join().unwrap();
    for _ in 0..1000 {
        if recorder.failure().is_some() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let told = recorder.failure().unwrap().to_owned();
    assert!(told.starts_with(&format!("cannot write the recording `{}`: Broken pipe", path.display())), "{told}");
    let error = recorder.finish().unwrap_err();
    assert_eq!(error.to_string(), told);
    assert!(matches!(error, RecordError::Write { messages: 1.., .. }));
}

#[test]
fn entries_that_were_lost_stop_the_recording_and_the_run_goes_on() {
    let mut recorder = Recorder::start(Sink::Memory, &made_up::mission(1), ChunkLimits::default()).unwrap();
    let mut track = Track::new(0, "r0", None);
    made_up::record(&mut track, 0, 1);
    track.entries().clear();
    for number in 2..2000 {
        made_up::record(&mut track, 0, number);
        recorder.append(track.entries());
        assert!(track.entries().is_empty());
    }
    let told = recorder.failure().map(str::to_owned);
    let error = recorder.finish().unwrap_err();
    assert!(matches!(error, RecordError::Entries { robot: 0 }));
    assert!(told.is_none_or(|told| told == error.to_string()));
}

#[test]
fn two_tracks_of_one_number_are_noticed() {
    let mut recorder = Recorder::start(Sink::Hash, &made_up::mission(2), ChunkLimits::default()).unwrap();
    for name in ["r0", "r1"] {
        let mut track = Track::new(0, name, None);
        track.begin(Time::from_nanos(1));
        track.record(&Truth::default());
        recorder.append(track.entries());
    }
    assert!(matches!(recorder.finish(), Err(RecordError::Entries { robot: 0 })));
}
