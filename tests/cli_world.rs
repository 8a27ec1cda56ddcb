//! `orienteer world`: floors and junctions as files, and missions in them.
#![allow(clippy::unwrap_used, missing_docs)]

mod cli_support;

use std::{fs, path::Path};

use cli_support::{call, fits};
use orienteer::hardware::world::{
    World,
    floors::{Flank, Floor, FloorSpec, Hypothesis, Truth, View, Width},
    plan::WorldPlan,
};
use serde_json::Value;

fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let (code, out, errors) = call(folder, &[&["world"], arguments].concat());
    assert_eq!((code, out.as_str()), (2, ""), "{arguments:?}: {errors}");
    for word in words {
        assert!(errors.contains(word), "{arguments:?}: `{word}` is missing in: {errors}");
    }
}

/// What a mission needs to know about a robot in the world `floor.toml`.
fn mission(place: &str) -> String {
    format!(
        "[mission]\nname = \"tour\"\nlinks = \"direct\"\nduration = 2\n[world]\nfile = \"floor.toml\"\n[[robot]]\nname = \"huey\"\n\
         base = {{ driver = \"sim\", platform = \"b12-huey\" }}\nsonar = {{ driver = \"sim\", ring = \"denning-16\" }}\nstart = {{ place = \"{place}\" }}\n\
         [robot.agent.where-am-i]\n[robot.agent.avoidance]\n[robot.agent.corridor-follower]\n"
    )
}

#[test]
fn without_options_a_floor_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, errors) = call(folder.path(), &["world"]);
    assert_eq!((code, errors.as_str()), (0, ""));
    assert_eq!(out, Floor::generate(1, &FloorSpec::default()).unwrap().text());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "something was written");
}

#[test]
fn a_floor_its_truth_and_its_picture_become_files_and_a_mission_runs_there() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let options = "--seed 7 --places 12 --corridor-width 1.12,1.4-1.8 --pitch 12 --boxes 0.5 --people 2";
    let files = ["--out", "floor.toml", "--truth", "truth.json", "--picture", "floor.png"];
    let arguments: Vec<&str> = ["world"].into_iter().chain(options.split(' ')).chain(files).collect();
    let (code, out, errors) = call(folder.path(), &arguments);
    assert_eq!((code, errors.as_str()), (0, ""));
    fits(&out);
    assert!(out.starts_with("floor 7: ") && out.ends_with("written\nfloor.toml\ntruth.json\nfloor.png\n"), "{out}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "drafts stay behind");

    let truth: Truth = serde_json::from_slice(&fs::read(at("truth.json")).unwrap()).unwrap();
    assert_eq!((truth.seed, truth.spec.people, truth.spec.corridor_width[1]), (7, 2, Width::Between([1.4, 1.8])));
    assert!(truth.places.len() >= 12);
    let world = World::load(&at("floor.toml"), &|path| fs::read(path)).unwrap();
    let names = |places: &mut dyn Iterator<Item = String>| places.collect::<Vec<_>>();
    assert_eq!(
        names(&mut world.places.iter().map(|place| place.name.clone())),
        names(&mut truth.places.iter().map(|place| place.name.clone()))
    );
    let picture = image::open(at("floor.png")).unwrap();
    let size = world.outline.bounds.size();
    assert!((f64::from(picture.width()) * 0.05 - size.x - 1.0).abs() < 0.1, "{size}");

    fs::write(at("tour.toml"), mission("p3")).unwrap();
    let (code, out, errors) = call(folder.path(), &["check", "tour.toml"]);
    assert!(code == 0 && out.contains("is sound"), "{out}{errors}");
    let (code, out, errors) = call(folder.path(), &["run", "tour.toml", "--json"]);
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &summary["robots"][0]["collisions"]), (0, &0.into()), "{errors}");
}

#[test]
fn each_junction_is_printed_and_a_mission_starts_there() {
    let folder = tempfile::tempdir().unwrap();
    for hypothesis in Hypothesis::ALL {
        let (code, out, errors) = call(folder.path(), &["world", "--junction", hypothesis.id()]);
        assert_eq!((code, errors.as_str()), (0, ""), "{hypothesis}");
        assert!(out.starts_with(&format!("# {hypothesis}: {}", hypothesis.title())), "{out}");
        World::from_plan(&WorldPlan::parse(&out).unwrap(), &|_| unreachable!()).unwrap();
    }
    let arguments =
        ["world", "--junction", "h4", "--perturb", "0.1", "--seed", "5", "--out", "floor.toml", "--truth", "truth.json"];
    let (code, _, errors) = call(folder.path(), &arguments);
    assert_eq!((code, errors.as_str()), (0, ""));
    let truth: Value = serde_json::from_slice(&fs::read(folder.path().join("truth.json")).unwrap()).unwrap();
    assert_eq!((&truth["hypothesis"], &truth["start"]["x"]), (&"H4".into(), &0.0.into()));
    assert_eq!(truth["place"]["doorways"][0]["edge"], "south");
    let opening = truth["perturbation"]["opening"].as_f64().unwrap();
    assert!(opening != 1.0 && (0.9..=1.1).contains(&opening), "{opening}");
    fs::write(folder.path().join("tour.toml"), mission("start")).unwrap();
    let (code, out, errors) = call(folder.path(), &["check", "tour.toml"]);
    assert!(code == 0 && out.contains("is sound"), "{out}{errors}");
}

/// The corridor follower knows nothing of how junctions are made. From 6 m before the start pose of any of them it stops there, and
/// says on which side it is open.
#[test]
fn a_robot_stops_at_the_start_pose_of_each_junction() {
    let folder = tempfile::tempdir().unwrap();
    let follower =
        mission("approach").replace("follower]", "follower]\nautostart = true").replace("duration = 2", "duration = 60");
    fs::write(folder.path().join("tour.toml"), follower).unwrap();
    for hypothesis in Hypothesis::ALL {
        let (code, ..) = call(folder.path(), &["world", "--junction", hypothesis.id(), "--out", "floor.toml", "--force"]);
        assert_eq!(code, 0);
        let (code, _, errors) = call(folder.path(), &["run", "tour.toml", "--no-record", "-v"]);
        assert_eq!(code, 0, "{errors}");
        let open = |flank: Flank| flank != Flank::Wall;
        let View { left, right, .. } = hypothesis.view();
        let sides = match (open(left), open(right)) {
            (true, true) => "Both",
            (true, false) => "Left",
            (false, true) => "Right",
            (false, false) => "DeadEnd",
        };
        let said = errors.split_once("corridor-follower: ").unwrap().1;
        let words: Vec<&str> = said.split_whitespace().collect();
        assert_eq!((words[0], words[1], words[3]), (sides, "after", "m"), "{hypothesis}: {said}");
        let driven: f64 = words[2].parse().unwrap();
        assert!((driven - 6.0).abs() < 0.1, "{hypothesis}: {said}");
    }
}

#[test]
fn what_cannot_be_made_is_refused_with_a_hint() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], words: &[&str]| refused(folder.path(), arguments, words);
    refused(&["--pitch", "6"], &["less than 6 m between places", "a pitch of 8.12 m would do"]);
    refused(&["--doors", "1.5"], &["share of doors is 1.5", "from 0 to 1"]);
    refused(&["--doors", "nan"], &["share of doors is NaN"]);
    refused(&["--columns", "1", "--rows", "1"], &["single crossing", "two columns"]);
    refused(&["--columns", "4000000000"], &["40"]);
    refused(&["--places", "0"], &["number of places"]);
    refused(&["--places", "9", "--columns", "3"], &["--columns"]);
    refused(&["--people", "400"], &["400 people", "fewer people"]);
    refused(&["--boxes", "1", "--berth", "0.5"], &["wide enough", "smaller berth"]);
    refused(&["--corridor-width", "wide"], &["1-1.5"]);
    refused(&["--corridor-width", "0.1"], &["0.8 to 5"]);
    refused(&["--corridor-width", "2-1"], &["empty", "smaller width first"]);
    refused(&["--junction", "H13"], &["H1 to H12"]);
    refused(&["--junction", "H1", "--doors", "0.5"], &["--doors"]);
    refused(&["--junction", "H1", "--perturb", "0.2"], &["0 to 0.1"]);
    refused(&["--perturb", "0.1"], &["--junction"]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "something was written");
}

#[test]
fn nothing_is_written_over_unless_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("floor.toml");
    fs::write(&file, "mine").unwrap();
    fs::create_dir(folder.path().join("here")).unwrap();
    refused(folder.path(), &["--out", "floor.toml", "--truth", "truth.json"], &["floor.toml", "already", "--force"]);
    refused(folder.path(), &["--out", "here", "--force"], &["no file", "--out"]);
    refused(folder.path(), &["--out", "new.toml", "--truth", "./new.toml"], &["two files at once", "--truth"]);
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "something was written");

    let (code, _, errors) = call(folder.path(), &["world", "--out", "floor.toml", "--truth", "no/such/place.json", "--force"]);
    assert!(code == 3 && errors.contains("no/such/place.json") && errors.contains("--truth"), "{code} {errors}");
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine", "neither is written if one can't be");
    let (code, _, errors) = call(folder.path(), &["world", "--out", "floor.toml", "--force"]);
    assert_eq!((code, errors.as_str()), (0, ""));
    assert!(fs::read_to_string(&file).unwrap().starts_with("# A floor"));
}
