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
use orienteer::emulate::Language;
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
    for command in ["", "run", "hardware", "check", "schema", "list", "why", "verify", "map", "world", "emulate", "reproduce"] {
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

/// A mission with one robot that has this base, in a file of its own; and how `check` ends, and what it says.
fn check_base(base: &str) -> (i32, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("[mission]\nclock = \"wall\"\n[[robot]]\nname = \"r\"\nbase = {base}\n");
    fs::write(folder.path().join("a.toml"), text).unwrap();
    call(folder.path(), &["check", "a.toml"])
}

/// The mark stands under the value that has to be changed.
#[test]
fn what_a_driver_refuses_is_shown_where_it_stands() {
    for wrong in [r#""tcp://127.0.0.1""#, r#""tcp://localhost:99999""#, r#""""#, r#""udp://host:1""#, r#""ttyUSB0""#] {
        for driver in ["arcos", "create"] {
            let (code, _, errors) = check_base(&format!("{{ driver = \"{driver}\", port = {wrong} }}"));
            let column = "base = ".len() + format!("{{ driver = \"{driver}\", port = ").len() + 1;
            assert!(code == 2 && errors.contains(&format!("a.toml:5:{column}\n")), "{wrong}: {errors}");
            assert!(errors.contains("is no port"), "{errors}");
        }
    }
    let base = r#"{ driver = "arcos", port = "tcp://localhost:8101", baud = 9600 }"#;
    let (code, _, errors) = check_base(base);
    assert!(code == 2 && errors.contains(&format!("a.toml:5:{}\n", 7 + base.find("9600").unwrap() + 1)), "{errors}");
    let base = r#"{ driver = "create", port = "/dev/ttyUSB0", platform = "wheelchair" }"#;
    let (code, _, errors) = check_base(base);
    assert!(code == 2 && errors.contains(&format!("a.toml:5:{}\n", 7 + base.find("\"wheelchair").unwrap() + 1)), "{errors}");
}

/// `check` says of a mission that can't be run for want of open files that it can't, before anybody waits for it.
#[test]
fn more_links_in_shared_memory_than_there_can_be_are_remarked_on() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("hall.toml"), "[[room]]\ncorners = [[0, 0], [400, 10]]\n").unwrap();
    let checked = |links: &str, robots: u32| {
        let text = format!(
            "[mission]\nlinks = \"{links}\"\n[world]\nfile = \"hall.toml\"\n[[robot]]\nname = \"r\"\ncount = {robots}\nstart = {{ x = 2, y = 5 }}\n\
             spacing = {{ columns = {robots}, x = 2 }}\nbase = {{ driver = \"sim\" }}\nsonar = {{ driver = \"sim\", ring = \"denning-16\" }}\n"
        );
        fs::write(folder.path().join("a.toml"), text).unwrap();
        let program = assert_cmd::cargo::cargo_bin("orienteer");
        let out = std::process::Command::new("sh")
            .args(["-c", "ulimit -n 2000; exec \"$0\" check a.toml", program.to_str().unwrap()])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let text = String::from_utf8(out.stdout).unwrap();
        assert!(out.status.success(), "{text}{}", String::from_utf8_lossy(&out.stderr));
        text.replace("\n  ", " ")
    };
    assert!(checked("shared", 60).contains("open files, and this process may have 2000"), "{}", checked("shared", 60));
    assert!(!checked("shared", 3).contains("open files"));
    assert!(!checked("direct", 60).contains("open files"));
}

/// Whoever drives one body with the size and the brakes of another should know, and may want to.
#[test]
fn a_platform_that_is_another_robots_is_remarked_on() {
    let told = |base: &str, key: &str| {
        let (code, out, errors) = check_base(base);
        let place = format!("a.toml:5:{}: r: ", 8 + base.find(key).unwrap() + key.len());
        assert_eq!((code, errors.as_str()), (0, ""));
        let remark = out.split("\n\nremark: ").find(|part| part.starts_with(&place)).map(|text| text.replace("\n  ", " "));
        remark.unwrap_or_default()
    };
    let base = r#"{ driver = "create", port = "/dev/ttyUSB0", platform = "p3dx" }"#;
    assert!(told(base, "platform = ").contains("`p3dx` is not the body of a Create"), "{}", told(base, "platform = "));
    let base = r#"{ driver = "arcos", platform = "create2", port = "/dev/ttyUSB0", model = "amigo" }"#;
    assert!(told(base, "platform = ").contains("set `platform` to `amigobot`"), "{}", told(base, "platform = "));
    // Without a platform it is a P3-DX.
    let base = r#"{ driver = "arcos", port = "/dev/ttyUSB0", model = "p3at" }"#;
    assert!(told(base, "model = ").contains("describe it in `custom`"), "{}", told(base, "model = "));
    for fitting in [
        r#"{ driver = "create", port = "/dev/ttyUSB0", model = "roomba" }"#,
        r#"{ driver = "arcos", port = "/dev/ttyUSB0", platform = "amigobot" }"#,
        r#"{ driver = "arcos", port = "/dev/ttyUSB0", model = "p2dx" }"#,
        r#"{ driver = "arcos", port = "/dev/ttyUSB0", model = "p3at", custom = { radius = 0.34 } }"#,
    ] {
        let (code, out, _) = check_base(fitting);
        assert!(code == 0 && !out.contains("is not the body"), "{fitting}: {out}");
    }
}

/// A key that belongs deeper is shown the way there.
#[test]
fn the_way_to_a_key_below_a_driver_can_be_gone() {
    let port = r#"driver = "arcos", port = "/dev/ttyUSB0""#;
    let (code, _, errors) = check_base(&format!("{{ {port}, speed = 0.7 }}"));
    assert!(code == 2 && errors.contains("write `custom.speed`") && errors.contains("instead of a platform"), "{errors}");
    let (code, out, errors) = check_base(&format!("{{ {port}, custom.speed = 0.7 }}"));
    assert!(code == 0 && out.contains("custom (arcos)"), "{out}{errors}");
    let (code, _, errors) = check_base(&format!("{{ {port}, sonar_required = false }}"));
    assert!(code == 2 && errors.contains("write `protection.sonar_required`"), "{errors}");
}

/// Who follows the README finds the emulator where the configuration looks for it, of either family, and both at once.
#[test]
fn an_emulator_is_where_its_configuration_looks_for_it() {
    let configured = |file: &str| {
        let text = fs::read_to_string(repository().join(file)).unwrap();
        text.split('"').find(|word| word.starts_with("tcp://")).unwrap().to_owned()
    };
    assert_eq!(configured("configs/pioneer.toml"), Language::Arcos.usual_port());
    assert_eq!(configured("configs/create.toml"), Language::Create.usual_port());
    assert_ne!(Language::Arcos.usual_port(), Language::Create.usual_port());
    let (_, out, _) = call(repository(), &["emulate", "--help"]);
    assert!([Language::Arcos, Language::Create].iter().all(|language| out.contains(language.usual_port())), "{out}");
}
