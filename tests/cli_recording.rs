//! `orienteer why`, `verify` and `map`: what can be had from a recording.
#![allow(clippy::unwrap_used, missing_docs)]

mod cli_support;

use std::fs;

use cli_support::{call, fits, record};
use serde_json::Value;

#[test]
fn a_recording_says_why() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), "20");
    let file = "out/office-floor.mcap";
    let (code, out, errors) = call(folder.path(), &["why", file, "--robot", "ann", "--at", "10"]);
    assert_eq!((code, errors.as_str()), (0, ""));
    assert!(out.starts_with("ann at 0:10") && out.contains("has the base since") && out.contains("\nsonar "), "{out}");
    fits(&out);

    let (code, out, _) = call(folder.path(), &["why", file, "--robot", "ann", "--at", "10", "--json"]);
    let moment: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &moment["robot"], &moment["decided_s"]), (0, &"ann".into(), &10.0.into()));
    assert_eq!(moment["clients"]["avoidance"], 10, "priorities are those of the configuration");
    assert!(moment["base"]["holder"].is_string());
    let limit = &moment["base"]["limit_m_s"];
    assert!(limit.is_null() || limit.as_f64().is_some_and(|limit| limit < 10.0), "{limit}");

    let refused = |arguments: &[&str], hint: &str| {
        let (code, out, errors) = call(folder.path(), arguments);
        assert_eq!((code, out.as_str()), (2, ""), "{arguments:?}");
        assert!(errors.contains(hint), "{errors}");
    };
    refused(&["why", file, "--at", "10"], "--robot ann");
    refused(&["why", file, "--robot", "eve", "--at", "10"], "ann, bob");
    refused(&["why", file, "--robot", "ann", "--at", "1000"], "ends at 0:20");
    refused(&["why", "out", "--at", "1"], "name a recording in it");
    refused(&["why", "none.mcap", "--robot", "ann", "--at", "1"], "orienteer run");
    fs::write(folder.path().join("text.mcap"), "no recording at all").unwrap();
    refused(&["why", "text.mcap", "--robot", "ann", "--at", "1"], "not an MCAP file");
}

#[test]
fn a_recording_is_verified() {
    let folder = tempfile::tempdir().unwrap();
    let file = record(folder.path(), "40");
    let verify = |name: &str| {
        let (code, out, errors) = call(folder.path(), &["verify", name, "--threads", "2"]);
        fits(&out);
        (code, out.split_whitespace().collect::<Vec<_>>().join(" "), errors)
    };
    let (code, out, errors) = verify("out/office-floor.mcap");
    assert_eq!((code, errors.as_str()), (0, ""), "{out}");
    assert!(out.starts_with("identical"), "{out}");

    // Cut off at several places: it says so, and that what is left agrees.
    let bytes = fs::read(file).unwrap();
    for (share, left) in [(0.15, "nothing is left"), (0.5, "up to 0:19.950"), (0.9, "up to 0:29.950")] {
        let length = (bytes.len() as f64 * share) as usize;
        fs::write(folder.path().join("cut.mcap"), &bytes[..length]).unwrap();
        let (code, out, errors) = verify("cut.mcap");
        assert_eq!((code, errors.as_str()), (1, ""), "{out}");
        assert!(out.starts_with("incomplete") && out.contains("cut off") && out.contains(left), "{out}");
    }
    // Whoever looks into it learns that something is missing.
    for arguments in [&["why", "cut.mcap", "--robot", "ann", "--at", "20"][..], &["map", "cut.mcap", "--out", "maps"]] {
        let (code, _, errors) = call(folder.path(), arguments);
        assert!(code == 0 && errors.contains("cut off") && errors.contains("up to 0:29.950"), "{errors}");
    }

    // One flipped bit never passes, wherever it is, and nothing panics.
    for share in [0.0, 0.001, 0.1, 0.4, 0.7, 0.99] {
        let mut changed = bytes.clone();
        let place = (bytes.len() as f64 * share) as usize;
        changed[place] ^= 4;
        fs::write(folder.path().join("changed.mcap"), &changed).unwrap();
        let (code, out, errors) = verify("changed.mcap");
        assert!((1..=3).contains(&code), "bit {place}: {out}");
        assert!(!out.starts_with("identical") && !errors.contains("panicked"), "{out}{errors}");
        assert!(code == 1 || errors.contains("help"), "{errors}");
    }
    fs::write(folder.path().join("cut.mcap"), &bytes[..40]).unwrap();
    let (code, _, errors) = verify("cut.mcap");
    assert!(code == 3 && errors.contains("help"), "{errors}");
}

#[test]
fn what_differs_is_named() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), "10");
    // A recording of another seed that claims to be of this one.
    let (code, _, _) = call(folder.path(), &["run", "--for", "10", "--seed", "2", "--record", "other.mcap"]);
    assert_eq!(code, 0);
    let bytes = fs::read(folder.path().join("other.mcap")).unwrap();
    let entry = b"\x04\0\0\0seed\x01\0\0\x002";
    let at = bytes.windows(entry.len()).position(|window| window == entry).unwrap();
    let mut forged = bytes.clone();
    forged[at + entry.len() - 1] = b'1';
    fs::write(folder.path().join("forged.mcap"), forged).unwrap();
    let (code, out, errors) = call(folder.path(), &["verify", "forged.mcap"]);
    assert_eq!(code, 1, "{errors}");
    assert!(out.starts_with("different") && out.contains("first at 0:") && out.contains("/ann/"), "{out}");
}

#[test]
fn maps_drawn_again_are_those_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), "30");
    let (code, out, errors) = call(folder.path(), &["map", "out/office-floor.mcap", "--out", "again"]);
    assert_eq!((code, errors.as_str()), (0, ""));
    assert!(out.contains("free cells") && out.contains("again/ann/map.yaml"), "{out}");
    fits(&out);
    for robot in ["ann", "bob"] {
        let own = fs::read(folder.path().join(format!("out/{robot}/map.png"))).unwrap();
        let again = fs::read(folder.path().join(format!("again/{robot}/map.png"))).unwrap();
        assert!(own == again, "{robot}'s map has changed");
    }
    let (code, out, _) = call(folder.path(), &["map", "out/office-floor.mcap", "--robot", "bob", "--out", "bob"]);
    assert!(code == 0 && !out.contains("ann"), "{out}");
    let (code, _, errors) = call(folder.path(), &["map", "out/office-floor.mcap", "--robot", "eve"]);
    assert!(code == 2 && errors.contains("ann, bob"), "{errors}");
}
