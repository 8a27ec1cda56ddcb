//! Recordings through the eyes of somebody else's programs: the Python packages `mcap`, `mcap-ros1-support` and
//! `mcap-protobuf-support`. Skipped, with a word, where they are not installed; `ORIENTEER_PYTHON` names another
//! interpreter.
#![allow(clippy::unwrap_used)]

mod recording_support;

use std::{env, fs, process::Command};

use orienteer_runtime::recording::*;
use recording_support as made_up;

const READ: &str = r#"
import json, math, sys
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory as Ros1
from mcap_protobuf.decoder import DecoderFactory as Protobuf

with open(sys.argv[1], "rb") as file:
    reader = make_reader(file, validate_crcs=True, decoder_factories=[Ros1(), Protobuf()])
    summary = reader.get_summary()
    topics = {}
    scan = decision = laser = transform = grid = log = None
    for schema, channel, message, decoded in reader.iter_decoded_messages():
        topics.setdefault(channel.topic, [schema.name, 0])[1] += 1
        if message.log_time == 2_500_000_000:
            if channel.topic == "/r0/sonar/scan": scan = decoded
            if channel.topic == "/r0/base/decision": decision = decoded
            if channel.topic == "/r0/sonar/laser": laser = decoded
            if channel.topic == "/r0/pose/transform": transform = decoded
            if channel.topic == "/r0/map": grid = decoded
        if channel.topic == "/r0/log" and log is None: log = decoded
    print(json.dumps({
        "topics": topics,
        "messages": summary.statistics.message_count,
        "seed": [record.metadata["seed"] for record in reader.iter_metadata()],
        "sources": [[attachment.name, list(attachment.data)] for attachment in reader.iter_attachments()],
        "ranges": list(scan.ranges), "states": list(scan.states),
        "holder": decision.holder, "speed": decision.motion.first, "held_back": [h.client for h in decision.held_back],
        "laser": [laser.frame_id, len(laser.ranges), laser.timestamp.seconds, laser.timestamp.nanos],
        "frames": [transform.parent_frame_id, transform.child_frame_id],
        "heading": 2 * math.atan2(transform.rotation.z, transform.rotation.w),
        "grid": [grid.column_count, grid.row_stride, grid.fields[0].name, list(grid.data)],
        "log": [log.name, log.message, log.level],
    }))
"#;

#[test]
fn another_reader_sees_the_same() {
    let python = env::var("ORIENTEER_PYTHON").unwrap_or_else(|_| "python3".into());
    let packages = Command::new(&python).args(["-c", "import mcap, mcap_ros1, mcap_protobuf"]).output();
    if !packages.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: {python} lacks the packages mcap, mcap-ros1-support and mcap-protobuf-support");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let limits = ChunkLimits { chunk_kib: 16, ..Default::default() };
    let mut recorder = Recorder::start(Sink::File(path.clone()), &made_up::mission(2), limits).unwrap();
    made_up::run(&mut recorder, 2, 100);
    let summary = recorder.finish().unwrap();

    let output = Command::new(&python).args(["-c", READ]).arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let seen: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let expected = made_up::step(0, 50);
    let ranges: Vec<f32> = seen["ranges"].as_array().unwrap().iter().map(|range| range.as_f64().unwrap() as f32).collect();
    let scan: Vec<f32> = expected.scan.echoes().map(|echo| echo.free_distance(0.0).unwrap()).collect();
    assert_eq!(ranges, scan);
    assert_eq!(seen["states"].as_array().unwrap().len(), 16);
    assert_eq!(seen["holder"], 2);
    // Python's JSON on the way here is exact, its reading here is not, by one unit in the last place.
    assert!((seen["speed"].as_f64().unwrap() - expected.odometry.twist.linear).abs() < 1e-15);
    assert_eq!(seen["held_back"][0], 2);
    assert_eq!(seen["laser"], serde_json::json!(["r0/base", 16, 2, 500_000_000]));
    assert_eq!(seen["frames"], serde_json::json!(["map", "r0/base"]));
    assert!((seen["heading"].as_f64().unwrap() - expected.pose.pose.heading).abs() < 1e-9);
    assert_eq!(seen["grid"], serde_json::json!([40, 40, "value", made_up::grid(0, 50).cells]));
    assert_eq!(seen["log"], serde_json::json!(["corridor", "step 7", 2]));
    assert_eq!(seen["messages"], summary.messages);
    assert_eq!(seen["seed"], serde_json::json!(["42"]));
    let sources: Vec<_> = made_up::mission(2).sources.into_iter().map(|s| serde_json::json!([s.name, s.bytes])).collect();
    assert_eq!(seen["sources"], serde_json::Value::Array(sources));
    let topics = seen["topics"].as_object().unwrap();
    assert_eq!(topics["/r1/truth"], serde_json::json!(["orienteer/Truth", 100]));
    assert_eq!(topics["/r1/truth/view"], serde_json::json!(["foxglove.PoseInFrame", 100]));
    assert_eq!(topics.len(), 22);
    assert_eq!(fs::metadata(&path).unwrap().len(), summary.bytes);
}
