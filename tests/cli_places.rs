//! A floor is explored, and kinds of places of one's own: as a user has it.
#![allow(clippy::unwrap_used, missing_docs)]

mod cli_support;

use std::{fs, path::Path};

use cli_support::{call, repository};
use orienteer::agents::geographer::export::PlacesFile;
use serde_json::Value;

/// The shipped mission: its places and corridors are those of its world, named right, and all is told, written and drawn.
#[test]
fn huey_explores_its_floor() {
    let folder = tempfile::tempdir().unwrap();
    let config = repository().join("configs/huey.toml");
    let (code, out, errors) = call(folder.path(), &["run", config.to_str().unwrap(), "--no-record"]);
    assert_eq!(code, 0, "{errors}");
    assert!(errors.contains("looks for") && errors.contains("all is explored: 8 places, 8 corridors"), "{errors}");
    assert!(out.contains("huey found") && out.contains("dead end"), "{out}");
    let left = folder.path().join("out/huey");
    let map: PlacesFile = serde_json::from_slice(&fs::read(left.join("places.json")).unwrap()).unwrap();
    // As the head of the world's file says; each as seen by who came there first.
    let true_places = [
        (9.21, 17.18, "H1 H5 H11"),
        (18.78, 17.18, "H2 H6"),
        (18.78, 0.0, "dead-end"),
        (0.0, 17.18, "H2 H6"),
        (0.0, 7.67, "H3 H7"),
        (0.0, 0.0, "H2 H6"),
        (9.21, 0.0, "H2 H6"),
        (9.21, 7.41, "H4 H8"),
    ];
    for (x, y, kinds) in true_places {
        let near = map.places.iter().filter(|place| (place.at[0] - x).hypot(place.at[1] - y) < 1.0);
        let found: Vec<&str> = near.map(|place| place.kind.as_str()).collect();
        assert!(found.len() == 1 && kinds.split(' ').any(|kind| kind == found[0]), "({x}, {y}): {found:?} of {kinds}");
    }
    assert_eq!((map.places.len(), map.corridors.len()), (8, 8));
    assert!(map.places.iter().all(|place| place.left_deg.is_empty()));
    let picture = image::open(left.join("places.png")).unwrap();
    assert!(picture.width() > 500 && picture.height() > 500);
    assert!(fs::read_to_string(left.join("places.dot")).unwrap().starts_with("graph places {"));
}

fn checked(folder: &Path, places: &str) -> String {
    let worlds = folder.join("worlds");
    fs::create_dir_all(&worlds).unwrap();
    fs::copy(repository().join("configs/worlds/huey-floor.toml"), worlds.join("huey-floor.toml")).unwrap();
    let mission = fs::read_to_string(repository().join("configs/huey.toml")).unwrap();
    fs::write(folder.join("huey.toml"), mission.replace("places/more.toml", "own.toml")).unwrap();
    fs::write(folder.join("own.toml"), places).unwrap();
    let (code, _, errors) = call(folder, &["check", "huey.toml"]);
    assert_eq!(code, if errors.is_empty() { 0 } else { 2 });
    errors
}

#[test]
fn a_kind_of_place_of_ones_own_takes_five_lines_and_its_slips_are_shown_where_they_stand() {
    let folder = tempfile::tempdir().unwrap();
    let own = "[[hypothesis]]\nid = \"niche\"\ntitle = \"niche on the left\"\nfeatures = [\"NLC\", \"KR\", \"WA\"]\nways = [\"left\"]\n";
    assert_eq!(checked(folder.path(), own), "");
    for (slip, mend, says) in [
        ("\"KR\"", "\"KX\"", "own.toml:2:6"),
        ("\"KX\"", "\"KX\"", "names the feature `KX`"),
        ("features", "feautres", "did you mean `features`"),
        ("\"left\"]", "\"back\"]", "own.toml:5"),
        ("\"KR\", \"WA\"", "\"NRC\", \"WA\"", "same features"),
    ] {
        let text = if slip == mend { own.replace("\"KR\"", mend) } else { own.replace(slip, mend) };
        let errors = checked(folder.path(), &text);
        assert!(errors.contains(says), "{says}: {errors}");
    }
}

#[test]
fn a_file_of_places_is_recorded_with_the_mission() {
    let folder = tempfile::tempdir().unwrap();
    let config = repository().join("configs/huey.toml");
    let (code, _, errors) = call(folder.path(), &["run", config.to_str().unwrap(), "--for", "3", "--record", "a.mcap"]);
    assert_eq!(code, 0, "{errors}");
    let (code, out, errors) = call(folder.path(), &["verify", "a.mcap"]);
    assert_eq!(code, 0, "{out}{errors}");
}

#[test]
fn the_summary_lists_places_for_programs_too() {
    let folder = tempfile::tempdir().unwrap();
    let config = repository().join("configs/huey.toml");
    let (_, out, _) = call(folder.path(), &["run", config.to_str().unwrap(), "--no-record", "--for", "900", "--json"]);
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert!(summary["robots"][0]["notes"][0].as_str().unwrap().starts_with("A: T, branch"), "{summary}");
}

/// The shipped team: three robots divide a floor between them, and all have the same map of it.
#[test]
fn three_hueys_explore_a_floor_together() {
    let folder = tempfile::tempdir().unwrap();
    let config = repository().join("configs/huey-team.toml");
    let (code, out, errors) = call(folder.path(), &["run", config.to_str().unwrap(), "--no-record"]);
    assert_eq!(code, 0, "{errors}");
    for robot in ["ann", "bob", "cleo"] {
        assert!(errors.contains(&format!("{robot}/geographer: all is explored: 25 places, 28 corridors")), "{errors}");
    }
    // What all have found is told once.
    assert!(out.contains("ann found") && !out.contains("bob found"), "{out}");
    let map = |robot: &str| -> PlacesFile {
        serde_json::from_slice(&fs::read(folder.path().join("out").join(robot).join("places.json")).unwrap()).unwrap()
    };
    let ann = map("ann");
    assert_eq!((ann.places.len(), ann.corridors.len()), (25, 28));
    assert!(ann.places.iter().all(|place| place.left_deg.is_empty()));
    assert_eq!((map("bob"), map("cleo")), (ann.clone(), ann));
}

/// What robots tell each other is the same on any number of threads.
#[test]
fn a_team_is_the_same_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let config = repository().join("configs/huey-team.toml");
    let hash = |threads: &str, links: &str| {
        let mission = fs::read_to_string(&config).unwrap().replace("seed = 1\n", &format!("seed = 1\nlinks = \"{links}\"\n"));
        let worlds = repository().join("configs/worlds/team-floor.toml");
        let file = folder.path().join("team.toml");
        fs::write(&file, mission.replace("worlds/team-floor.toml", worlds.to_str().unwrap())).unwrap();
        let (_, out, errors) = call(folder.path(), &["run", "team.toml", "--for", "240", "--threads", threads, "--json"]);
        let summary: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{errors}"));
        summary["recording_hash"].as_str().unwrap().to_owned()
    };
    let one = hash("1", "direct");
    assert_eq!([hash("2", "direct"), hash("3", "direct")], [one.clone(), one]);
    assert_eq!(hash("1", "shared"), hash("3", "shared"));
}
