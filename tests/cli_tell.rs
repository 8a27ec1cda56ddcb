//! `orienteer check`, `schema`, `list` and `--help`: what there is and what is right.
#![allow(clippy::unwrap_used, missing_docs)]

mod cli_support;

use std::{
    fs,
    io::Read,
    path::Path,
    process::{Command, Stdio},
};

use cli_support::{call, orienteer, repository};
use serde_json::Value;

#[test]
fn every_shipped_configuration_is_sound() {
    let mut seen = 0;
    for entry in fs::read_dir(repository().join("configs")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|end| end != "toml") {
            continue;
        }
        seen += 1;
        let data = repository().join("../shared/data/robond-8sonar").is_dir();
        if path.ends_with("robond-log.toml") && !data {
            continue;
        }
        let name = path.to_str().unwrap();
        let (code, out, errors) = call(repository(), &["check", name]);
        assert_eq!((code, errors.as_str()), (0, ""), "{name}");
        assert!(out.contains("is sound"), "{out}");
        let (code, out, _) = call(repository(), &["check", name, "--json"]);
        assert_eq!((code, serde_json::from_str::<Value>(&out).unwrap()["ok"].as_bool()), (0, Some(true)));
    }
    assert!(seen >= 3);
}

#[test]
fn a_check_finds_what_only_world_and_drivers_know() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("worlds")).unwrap();
    fs::copy(repository().join("configs/worlds/hallway.toml"), folder.path().join("worlds/hallway.toml")).unwrap();
    let text = fs::read_to_string(repository().join("configs/hallway.toml")).unwrap();
    fs::write(folder.path().join("a.toml"), text.replace("west end", "north pole")).unwrap();
    let (code, out, errors) = call(folder.path(), &["check", "a.toml"]);
    assert_eq!((code, out.as_str()), (2, ""));
    assert!(errors.contains("a.toml:15:") && errors.contains("north pole") && errors.contains("west end"), "{errors}");

    let (code, out, _) = call(folder.path(), &["check", "a.toml", "--json"]);
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &answer["ok"], &answer["problems"][0]["line"]), (2, &false.into(), &15.into()));
    assert!(answer["problems"][0]["hint"].as_str().unwrap().contains("west end"));
}

/// Write them anew with `orienteer schema mission > configs/orienteer.schema.json`, and the same for `world`.
#[test]
fn the_schemas_are_up_to_date() {
    for (of, file) in [("mission", "configs/orienteer.schema.json"), ("world", "configs/world.schema.json")] {
        let (code, out, _) = call(repository(), &["schema", of]);
        let kept = fs::read_to_string(repository().join(file)).unwrap();
        assert_eq!(code, 0);
        assert!(out == kept, "run `orienteer schema {of} > {file}`");
        let schema: Value = serde_json::from_str(&out).unwrap();
        let known = if of == "mission" { &schema["$defs"]["agent.avoidance"] } else { &schema["properties"]["person"] };
        assert!(known.is_object());
    }
}

#[test]
fn lists_name_what_there_is() {
    let (code, out, errors) = call(Path::new("/"), &["list"]);
    assert_eq!((code, errors.as_str()), (0, ""));
    for name in ["agents", "corridor-follower", "base log", "b12-huey", "denning-16", "worlds/office-floor.toml", "determinism"] {
        assert!(out.contains(name), "{name} is missing in:\n{out}");
    }
    assert!(out.lines().all(|line| line.chars().count() <= 80), "{out}");
    let (_, out, _) = call(repository(), &["list", "rings", "--json"]);
    let rings: Value = serde_json::from_str(&out).unwrap();
    assert!(rings.as_array().unwrap().iter().any(|ring| ring["name"] == "luey-8-square"));
    let (_, out, _) = call(repository(), &["list", "--json"]);
    assert_eq!(serde_json::from_str::<Value>(&out).unwrap().as_object().unwrap().len(), 6);
}

/// `orienteer list | head -1`
#[test]
fn a_reader_may_stop_reading() {
    for arguments in [&["list"][..], &["schema"], &["--help"]] {
        let mut child = Command::new(orienteer(repository()).get_program())
            .args(arguments)
            .current_dir(repository())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let mut errors = String::new();
        child.stderr.take().unwrap().read_to_string(&mut errors).unwrap();
        assert_eq!((child.wait().unwrap().code(), errors.as_str()), (Some(0), ""), "{arguments:?}");
    }
}

#[test]
fn help_fits_and_tells_the_exit_codes() {
    for command in ["", "run", "check", "list", "why", "verify", "map", "world", "reproduce"] {
        let arguments: Vec<&str> = [command, "--help"].into_iter().filter(|word| !word.is_empty()).collect();
        let (code, out, _) = call(repository(), &arguments);
        assert_eq!(code, 0);
        assert!(out.lines().all(|line| line.chars().count() <= 80), "{out}");
    }
    let (_, out, _) = call(repository(), &["--help"]);
    assert!(out.contains("130  stopped by Ctrl-C"), "{out}");
}

#[test]
fn experiments_are_told_to_programs() {
    // Whatever a suite comes to, its answer has this form.
    let (code, out, errors) = call(repository(), &["reproduce", "echo", "--quick", "--seeds", "10", "--json"]);
    assert!(code == 0 || code == 1, "{errors}");
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["suite"], "echo");
    assert!(report["rows"].as_array().unwrap().iter().all(|row| row["holds"].is_boolean() && row["measured"].is_number()));
}

/// What a program asked for must reach it, or the exit code has to say that it did not.
#[test]
fn an_answer_that_gets_lost_is_a_failure() {
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_orienteer")).args(["list", "--json"]).stdout(full).output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(3) && errors.contains("the answer can't be written"), "{errors}");
}

#[test]
fn programs_are_told_of_refusals_too() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&["run", "no.toml"][..], &["check", "no.toml"], &["why", "no.mcap", "--at", "1"]] {
        let (code, out, errors) = call(folder.path(), &[arguments, &["--json"]].concat());
        let answer: Value = serde_json::from_str(&out).unwrap();
        assert_eq!((code, &answer["ok"], errors.as_str()), (2, &false.into(), ""), "{arguments:?}");
        assert!(answer["problems"][0]["message"].as_str().is_some_and(|message| message.contains("no.")), "{answer}");
    }
}

/// A ring that leaves part of the way unheard is allowed, but nobody should learn of it from an accident.
#[test]
fn blind_spots_are_remarked_on() {
    let folder = tempfile::tempdir().unwrap();
    let robot = |name: &str, x: u8, ring: &str| {
        format!(
            "[[robot]]\nname = \"{name}\"\nstart = {{ x = {x}, y = 3 }}\nbase = {{ driver = \"sim\" }}\nsonar = {{ driver = \"sim\", ring = \"{ring}\" }}\n"
        )
    };
    let robots = [robot("ann", 2, "luey-8-square"), robot("bob", 4, "denning-16"), robot("cy", 6, "luey-8-square")].concat();
    fs::write(folder.path().join("hall.toml"), "[[room]]\ncorners = [[0, 0], [8, 6]]\n").unwrap();
    fs::write(folder.path().join("a.toml"), format!("[world]\nfile = \"hall.toml\"\n{robots}")).unwrap();
    let (code, out, _) = call(folder.path(), &["check", "a.toml"]);
    assert!(code == 0 && out.contains("remark: ann, cy: no beam of `luey-8-square`"), "{out}");
    let (_, out, _) = call(folder.path(), &["check", "a.toml", "--json"]);
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(answer["remarks"].as_array().map(Vec::len), Some(1));
    let (code, _, errors) = call(folder.path(), &["run", "a.toml", "--for", "1", "--no-record"]);
    assert!(code == 0 && errors.contains("no beam of `luey-8-square`"), "{errors}");

    // On its own platform all is covered at top speed, which stops far ahead, and not when it goes slowly.
    let own = robot("dee", 2, "luey-8-square").replace("driver = \"sim\" }", "driver = \"sim\", platform = \"b12-luey\" }");
    fs::write(folder.path().join("b.toml"), format!("[world]\nfile = \"hall.toml\"\n{own}")).unwrap();
    let (code, out, _) = call(folder.path(), &["check", "b.toml"]);
    assert!(code == 0 && out.contains("remark: dee: no beam of `luey-8-square`"), "{out}");
}
