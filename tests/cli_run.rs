//! `orienteer run`, as a person calls it.
#![allow(clippy::unwrap_used, missing_docs)]

mod cli_support;

use std::{fs, process::Command};

use cli_support::{call, fits, repository};
use orienteer::runtime::{
    link::{Backend, Bus, BusOptions},
    recording::{Ending, Reader},
};
use serde_json::Value;

#[test]
fn without_any_file_two_robots_drive_and_leave_maps_picture_and_recording() {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, errors) = call(folder.path(), &["run", "--for", "5", "--out", "here/there"]);
    assert_eq!((code, errors.as_str()), (0, ""));
    for name in ["ann", "bob", "distance", "collisions", "had the base", "office-floor, seed 1: 0:05 simulated", "sha256"] {
        assert!(out.contains(name), "{name} is missing in:\n{out}");
    }
    fits(&out);
    let there = folder.path().join("here/there");
    let picture = image::open(there.join("office-floor.png")).unwrap();
    assert!(picture.width() > 500 && picture.height() > 300);
    assert_eq!(*Reader::open(there.join("office-floor.mcap")).unwrap().ending(), Ending::Complete);
    // Every file named in the summary is there, and no other.
    let mut named: Vec<_> = out.lines().filter_map(|line| line.strip_prefix("here/there/")).collect();
    named.iter_mut().for_each(|line| *line = line.split("  ").next().unwrap());
    assert!(named.len() >= 8, "{named:?}");
    assert!(named.iter().all(|name| there.join(name).is_file()), "{named:?}");
}

#[test]
fn who_runs_out_of_descriptors_learns_which_key_helps() {
    let folder = tempfile::tempdir().unwrap();
    let limited = format!("ulimit -n 100; exec {} run --for 1", env!("CARGO_BIN_EXE_orienteer"));
    let ended = Command::new("sh").args(["-c", &limited]).current_dir(folder.path()).output().unwrap();
    let errors = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(3), "{errors}");
    assert!(errors.contains("file descriptors") && errors.contains("mission.links"), "{errors}");
}

/// However few files may be open, from so few that nothing begins: it is told how many are needed, and nothing panics.
#[test]
fn a_limit_on_files_is_told_and_nothing_panics() {
    let folder = tempfile::tempdir().unwrap();
    for (limit, what) in
        [6, 8, 10, 12, 16].map(|n| (n, "needs at least")).into_iter().chain([24, 32].map(|n| (n, "mission.links")))
    {
        let limited = format!("ulimit -n {limit}; exec {} run --for 1", env!("CARGO_BIN_EXE_orienteer"));
        let ended = Command::new("sh").args(["-c", &limited]).current_dir(folder.path()).output().unwrap();
        let errors = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(3), "{limit}: {errors}");
        assert!(errors.contains("ulimit -n") && !errors.contains("panicked"), "{limit}: {errors}");
        assert!(errors.contains(&format!("may have {limit}")) && errors.contains(what), "{limit}: {errors}");
    }
}

/// A map that a run leaves behind is a world that the next run can use.
#[test]
fn a_map_is_a_world() {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, errors) = call(folder.path(), &["run", "--for", "60"]);
    assert_eq!(code, 0, "{errors}");
    assert!(out.contains("out/ann/map.yaml"), "{out}");
    let mission = "[mission]\nduration = 5\n[world]\nmap = \"out/ann/map.yaml\"\n[[robot]]\nname = \"cy\"\n\
                   base = { driver = \"sim\" }\nsonar = { driver = \"sim\" }\nstart = { x = START_X, y = START_Y }\n\
                   [robot.agent.where-am-i]\n[robot.agent.avoidance]\n";
    fs::write(folder.path().join("again.toml"), mission.replace("START_X", "5").replace("START_Y", "5")).unwrap();
    let (code, out, errors) = call(folder.path(), &["run", "again.toml"]);
    assert_eq!(code, 0, "{errors}");
    assert!(out.contains("cy"), "{out}");
}

#[test]
fn a_summary_is_also_told_to_programs() {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, errors) = call(folder.path(), &["run", "--for", "5", "--seed", "7", "--threads", "2", "--json"]);
    assert_eq!((code, errors.as_str()), (0, ""));
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&summary["seed"], &summary["ended"]), (&7.into(), &"complete".into()));
    assert_eq!(summary["robots"].as_array().unwrap().len(), 2);
    let ann = &summary["robots"][0];
    assert_eq!((&ann["name"], &ann["collisions"], &ann["overruns"]), (&"ann".into(), &0.into(), &0.into()));
    assert!(ann["distance_m"].as_f64().unwrap() > 0.2 && ann["time_s"] == 5.0);
    assert!(ann["held_s"].as_object().unwrap().values().map(|held| held.as_f64().unwrap()).sum::<f64>() <= 5.1);
    assert!(summary["real_time_factor"].as_f64().unwrap() > 0.0);
    assert_eq!(summary["recording_hash"].as_str().unwrap().len(), 64);
    assert!(summary["files"].as_array().unwrap().iter().all(|file| folder.path().join(file.as_str().unwrap()).is_file()));

    // The same seed on one thread gives the same recording, another seed another.
    let hash = |seed: &str, name: &str| {
        let (code, out, _) = call(folder.path(), &["run", "--for", "5", "--seed", seed, "--json", "--record", name]);
        assert_eq!(code, 0);
        serde_json::from_str::<Value>(&out).unwrap()["recording_hash"].clone()
    };
    assert_eq!(hash("7", "again.mcap"), summary["recording_hash"]);
    assert_ne!(hash("8", "other.mcap"), summary["recording_hash"]);
    assert!(folder.path().join("again.mcap").is_file());
}

#[test]
fn nothing_is_recorded_if_nobody_wants_it() {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, _) = call(folder.path(), &["run", "--for", "1", "--no-record", "--json"]);
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &summary["recording_hash"]), (0, &Value::Null));
    assert!(!out.contains(".mcap"));
}

#[test]
fn what_is_wrong_with_a_configuration_is_shown_where_it_stands() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(repository().join("configs/hallway.toml")).unwrap();
    fs::create_dir(folder.path().join("worlds")).unwrap();
    fs::copy(repository().join("configs/worlds/hallway.toml"), folder.path().join("worlds/hallway.toml")).unwrap();
    fs::write(folder.path().join("bad.toml"), text.replace("priority = 10", "priorty = 10").replace("seed = 1", "seed = \"x\""))
        .unwrap();
    let (code, out, errors) = call(folder.path(), &["run", "bad.toml"]);
    assert_eq!((code, out.as_str()), (2, ""));
    assert!(errors.contains("bad.toml:6:8") && errors.contains("bad.toml:20:1"), "{errors}");
    assert!(errors.contains("did you mean `priority`?") && errors.contains("2 problems"), "{errors}");
    assert!(!errors.contains('\u{1b}'), "no colour without a terminal: {errors}");

    let (code, _, errors) = call(folder.path(), &["run", "nowhere.toml"]);
    assert!(code == 2 && errors.contains("there is no file `nowhere.toml`") && errors.contains("help"), "{errors}");
    let (code, _, errors) = call(folder.path(), &["run", "."]);
    assert!(code == 2 && errors.contains("help"), "{errors}");
}

#[test]
fn absurd_options_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["run", "--for", "1e300"][..],
        &["run", "--for", "-1"],
        &["run", "--speed", "0"],
        &["run", "--speed", "nan"],
        &["run", "--threads", "0"],
        &["run", "--seed", "x"],
        &["run", "--record", "a", "--no-record"],
        &["run", "--frobnicate"],
        &["frobnicate"],
        &["why", "x.mcap"],
        &["list", "robots"],
        &["reproduce", "everything"],
        &[],
    ] {
        let (code, out, errors) = call(folder.path(), arguments);
        assert_eq!((code, out.as_str()), (2, ""), "{arguments:?}");
        assert!(!errors.is_empty() && !errors.contains("panicked"), "{arguments:?}: {errors}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "something was written");
}

/// Nobody who gives a negative number wants it for something else.
#[test]
fn a_negative_number_is_told_what_it_may_be() {
    for arguments in [
        &["run", "--for", "-3"][..],
        &["run", "--speed", "-3"],
        &["run", "--seed", "-3"],
        &["run", "--threads", "-3"],
        &["hardware", "a.toml", "--for", "-3"],
        &["why", "a.mcap", "--at", "-3"],
        &["verify", "a.mcap", "--threads", "-3"],
        &["emulate", "create", "--json", "-3"],
        &["emulate", "create", "--seed", "-3"],
        &["reproduce", "--seeds", "-3"],
    ] {
        let (code, _, errors) = call(repository(), arguments);
        assert!(code == 2 && errors.contains("invalid value '-3'") && !errors.contains("tip"), "{arguments:?}: {errors}");
        assert!(errors.contains("from") || errors.contains("1..=256"), "{arguments:?}: {errors}");
    }
}

#[test]
fn what_cannot_be_written_is_told() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let (code, _, errors) = call(folder.path(), &["run", "--for", "1", "--out", "file/x"]);
    assert!(code == 2 && errors.contains("--out"), "{code} {errors}");
    let (code, _, errors) = call(folder.path(), &["run", "--for", "1", "--record", "no/such/place.mcap"]);
    assert!(code == 2 && errors.contains("no/such/place.mcap") && errors.contains("help"), "{code} {errors}");
    // A directory stands where the picture should go: the mission went well, but its picture is lost.
    fs::create_dir_all(folder.path().join("out/office-floor.png")).unwrap();
    let (code, out, errors) = call(folder.path(), &["run", "--for", "1"]);
    assert!(code == 3 && errors.contains("office-floor.png") && out.contains("ann"), "{code} {errors}");
}

/// Nothing was run, and another name is all that it takes.
#[test]
fn a_name_that_another_run_has_is_a_misuse() {
    let folder = tempfile::tempdir().unwrap();
    let name = format!("taken-{}", std::process::id());
    let mission = |hardware: &str| {
        format!(
            "[mission]\nclock = 'wall'\nrun = '{name}'\n[world]\nfile = '{}'\n[[robot]]\nname = 'ann'\n{hardware}\
             start.place = 'west end'\nbase.driver = 'sim'\nsonar.driver = 'sim'\n",
            repository().join("configs/worlds/hallway.toml").display()
        )
    };
    fs::write(folder.path().join("a.toml"), mission("")).unwrap();
    fs::write(folder.path().join("b.toml"), mission("hardware = 'elsewhere'\n")).unwrap();
    let take = |run: String| Bus::open(Backend::Shared, &BusOptions { run: Some(run), ..BusOptions::default() }).unwrap();
    let _taken = (take(name.clone()), take(format!("{name}.ann")));
    for arguments in [["run", "a.toml", "--for", "1"], ["hardware", "b.toml", "--for", "1"]] {
        let (code, out, errors) = call(folder.path(), &arguments);
        assert_eq!((code, out.as_str()), (2, ""), "{errors}");
        assert!(errors.contains("is taken") && errors.contains("mission.run"), "{errors}");
    }
}

/// A slip of the hand must not cost somebody the mission: its file, or one that it names, is no place for a recording.
#[test]
fn a_recording_over_a_file_of_the_mission_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("worlds")).unwrap();
    for file in ["hallway.toml", "worlds/hallway.toml"] {
        fs::copy(repository().join("configs").join(file), folder.path().join(file)).unwrap();
    }
    for file in ["hallway.toml", "worlds/../hallway.toml", "worlds/hallway.toml"] {
        let before = fs::read(folder.path().join(file)).unwrap();
        let (code, out, errors) = call(folder.path(), &["run", "hallway.toml", "--for", "1", "--record", file]);
        assert_eq!((code, out.as_str()), (2, ""), "{file}: {errors}");
        assert!(errors.contains(&format!("`{file}` would overwrite")) && errors.contains("help"), "{errors}");
        assert!(fs::read(folder.path().join(file)).unwrap() == before, "{file} has changed");
    }
    // Whatever else somebody keeps there is safe as well, under any name, and so are files that the run itself writes.
    fs::write(folder.path().join("thesis.md"), "three years of work").unwrap();
    fs::hard_link(folder.path().join("hallway.toml"), folder.path().join("hard.toml")).unwrap();
    for file in ["thesis.md", "hard.toml"] {
        let (code, _, errors) = call(folder.path(), &["run", "hallway.toml", "--for", "1", "--record", file]);
        assert!(code == 2 && errors.contains("something that is no recording"), "{code} {errors}");
    }
    let (code, _, errors) = call(folder.path(), &["run", "hallway.toml", "--for", "1", "--record", "out/hallway.png"]);
    assert!(code == 3 && errors.contains("left twice"), "{code} {errors}");
    assert_eq!(*Reader::open(folder.path().join("out/hallway.png")).unwrap().ending(), Ending::Complete);

    // However it is called.
    let mission = folder.path().join("hallway.mcap");
    let text = fs::read_to_string(folder.path().join("hallway.toml")).unwrap() + "\n[record]\nfile = \"../hallway.mcap\"\n";
    fs::write(&mission, &text).unwrap();
    let (code, _, errors) = call(folder.path(), &["run", "hallway.mcap", "--for", "1"]);
    assert!(code == 2 && errors.contains("would overwrite"), "{code} {errors}");
    assert!(fs::read_to_string(&mission).unwrap() == text, "the mission has changed");
}

/// The next run of such a mission would begin with another world.
#[test]
fn a_map_that_the_mission_began_with_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(call(folder.path(), &["run", "--for", "20", "--no-record"]).0, 0);
    let map = folder.path().join("out/ann/map.yaml");
    let before = fs::read(&map).unwrap();
    let mission = "[world]\nmap = \"out/ann/map.yaml\"\n\n[[robot]]\nname = \"ann\"\nstart = { x = 5.2, y = 4.6 }\nbase = { driver = \"sim\" }\nsonar = { driver = \"sim\" }\nagent.where-am-i = {}\nagent.mapper = {}\n";
    fs::write(folder.path().join("again.toml"), mission).unwrap();
    let (code, _, errors) = call(folder.path(), &["run", "again.toml", "--for", "2", "--no-record"]);
    assert!(code == 3 && errors.contains("map.yaml` was not written: the mission was read from it"), "{code} {errors}");
    assert!(fs::read(&map).unwrap() == before);
}

#[test]
fn log_lines_are_shown_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    let errors = |flag: &[&str]| {
        let mut arguments = vec!["run", "--for", "60", "--no-record"];
        arguments.extend(flag);
        let (code, _, errors) = call(folder.path(), &arguments);
        assert_eq!(code, 0);
        errors
    };
    assert_eq!(errors(&["-q"]), "");
    assert!(errors(&["-v"]).contains("INFO"));
    assert!(errors(&["-vv"]).contains("DEBUG"));
}

/// The log is not part of this repository. Where it is absent, the program must say what to do.
#[test]
fn a_real_log_is_mapped() {
    let folder = tempfile::tempdir().unwrap();
    let config = repository().join("configs/robond-log.toml");
    let out = folder.path().to_str().unwrap();
    let (code, text, errors) = call(repository(), &["run", config.to_str().unwrap(), "--out", out]);
    if repository().join("../shared/data/robond-8sonar").is_dir() {
        assert_eq!(code, 0, "{errors}");
        assert!(text.contains("free cells") && text.contains("25.0 m"), "{text}");
    } else {
        assert_eq!(code, 2);
    }

    // Alone in a directory it can't find its data, wherever that is.
    fs::copy(config, folder.path().join("robond-log.toml")).unwrap();
    let (code, _, errors) = call(folder.path(), &["run", "robond-log.toml"]);
    assert_eq!(code, 2);
    assert!(errors.contains("poses.txt") && errors.contains("comments of the mission"), "{errors}");
}
