//! What is wrong with a world is shown where it stands in the world's file.
#![allow(clippy::unwrap_used, missing_docs)]

use orienteer::{
    Registry,
    mission::{self, RunError},
    runtime::config::Problems,
};

const MISSION: &str = "[mission]\nlinks = \"direct\"\n\n[world]\nfile = \"worlds/hall.toml\"\n\n[[robot]]\nname = \"huey\"\nbase = { driver = \"sim\" }\nstart = { x = 2, y = 2 }\n";

fn problems(world: &str) -> Problems {
    problems_of(MISSION, world)
}

fn problems_of(mission: &str, world: &str) -> Problems {
    let map = "image: hall.png\nresolution: 0\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.2\n";
    let files = [("mission.toml", mission), ("worlds/hall.toml", world), ("worlds/hall.yaml", map)];
    let files = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
    let registry = Registry::standard();
    let loaded = mission::load_files(files, "mission.toml", &registry).unwrap();
    match mission::compose(loaded, &registry, 1) {
        Err(RunError::Config(problems)) => problems,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("nothing is wrong with it"),
    }
}

fn place(world: &str) -> (String, usize, usize, String) {
    let problems = problems(world);
    let problem = &problems.list()[0];
    assert!(!problem.hint().is_empty());
    assert_eq!(problem.notes()[0].location.as_ref().unwrap().file, "mission.toml", "who names the world is told too");
    let at = problem.location().unwrap();
    (at.file.clone(), at.line, at.column, at.text.clone())
}

const ROOM: &str = "[[room]]\ncorners = [[0, 0], [8, 6]]\n";

#[test]
fn a_table_is_pointed_at() {
    let world = format!("{ROOM}\n[[place]]\nname = \"a\"\nat = [1, 1]\n\n[[place]]\nname = \"b\"\nat = [9, 9]\n");
    let (file, line, ..) = place(&world);
    assert_eq!((file.as_str(), line), ("worlds/hall.toml", 8));
}

#[test]
fn a_key_is_pointed_at_if_it_alone_is_wrong() {
    let world = format!("{ROOM}\n[[corridor]]\nalong = [[0, 0], [0, 0]]\nwidth = 2\n");
    let (file, line, ..) = place(&world);
    assert_eq!((file.as_str(), line), ("worlds/hall.toml", 4), "two points are the same, which is no single value");
    let world = format!("{ROOM}\n[[corridor]]\nalong = [[1, 1]]\nwidth = nan\n");
    let file = problems(&world).list()[0].location().unwrap().file.clone();
    assert_eq!(file, "worlds/hall.toml");
}

#[test]
fn a_file_that_a_world_names_is_pointed_at() {
    let (file, line, column, text) = place("name = \"x\"\n\n[map]\nfile = \"nowhere.yaml\"\n");
    assert_eq!((file.as_str(), line, column), ("worlds/hall.toml", 4, 8), "{text}");
}

#[test]
fn a_key_of_a_map_is_pointed_at_in_the_map() {
    let problems = problems("name = \"x\"\n\n[map]\nfile = \"hall.yaml\"\n");
    let (at, note) = (problems.list()[0].location().unwrap(), &problems.list()[0].notes()[0]);
    assert_eq!((at.file.as_str(), at.line, at.text.as_str()), ("worlds/hall.yaml", 2, "resolution"));
    assert_eq!(note.location.as_ref().map(|at| (at.file.as_str(), at.line)), Some(("worlds/hall.toml", 4)));
}

#[test]
fn a_start_in_a_wall_is_pointed_at_where_it_is_said_or_missing() {
    let start_at = |mission: &str| {
        let problem = problems_of(mission, ROOM).list()[0].clone();
        (problem.location().unwrap().text.clone(), problem.hint().to_owned())
    };
    let (text, hint) = start_at(&MISSION.replace("x = 2", "x = 0.1"));
    assert!(text.contains("x = 0.1") && hint.contains("another `start`"), "{text}: {hint}");
    let (text, hint) = start_at(&MISSION.replace("start = { x = 2, y = 2 }", ""));
    assert!(text == "\"sim\"" && hint.contains("without one it is the origin"), "{text}: {hint}");
}
