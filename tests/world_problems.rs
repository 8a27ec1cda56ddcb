//! What is wrong with a world is shown where it stands in the world's file.
#![allow(clippy::unwrap_used, missing_docs)]

use orienteer::{
    Registry,
    mission::{self, RunError},
    runtime::config::Problems,
};

const MISSION: &str = "[mission]\nlinks = \"direct\"\n\n[world]\nfile = \"worlds/hall.toml\"\n\n[[robot]]\nname = \"huey\"\nbase = { driver = \"sim\" }\nstart = { x = 2, y = 2 }\n";

fn problems(world: &str) -> Problems {
    let files = [("mission.toml", MISSION), ("worlds/hall.toml", world)];
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
