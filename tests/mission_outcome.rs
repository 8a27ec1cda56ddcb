//! What a mission leaves behind, and what it says if it can't.
#![allow(clippy::unwrap_used, missing_docs)]

use orienteer::{
    Registry,
    mission::{self, RunOptions},
    runtime::{
        agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
        agents::NoConfig,
        time::Time,
    },
};

const HALL: &str = "[[room]]\ncorners = [[0, 0], [8, 6]]\n";

fn mission_with(agents: &str) -> [(String, Vec<u8>); 2] {
    let mission = format!(
        "[mission]\nlinks = \"direct\"\nduration = 1\n\n[world]\nfile = \"hall.toml\"\n\n[[robot]]\nname = \"huey\"\n\
         start = {{ x = 2, y = 2 }}\nbase = {{ driver = \"sim\" }}\nsonar = {{ driver = \"sim\" }}\n\n{agents}"
    );
    [("mission.toml".to_owned(), mission.into_bytes()), ("hall.toml".to_owned(), HALL.as_bytes().to_vec())]
}

#[test]
fn one_robot_draws_one_map() {
    let files = mission_with("[robot.agent.where-am-i]\n[robot.agent.mapper]\n[robot.agent.second]\nkind = \"mapper\"\n");
    let problems = mission::load_files(files, "mission.toml", &Registry::standard()).unwrap_err();
    let problem = &problems.list()[0];
    assert_eq!(problem.location().unwrap().text, "second", "{problem}");
    assert!(problem.to_string().contains("`map` has two writers"), "{problem}");
}

/// Leaves a file, and tells of another that it could not make.
struct Leaves;

impl Behaviour for Leaves {
    fn step(&mut self, _now: Time, _inputs: &Inputs, _out: &mut Outputs) {}

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.file("note.txt", b"was here".to_vec());
        last_words.failure("the diary is lost");
    }
}

impl Agent for Leaves {
    const KIND: &'static str = "leaves";
    const HELP: &'static str = "leaves a note";
    type Config = NoConfig;

    fn topics(_wiring: &mut Wiring) {}

    fn build(_config: NoConfig, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self)
    }
}

#[test]
fn what_could_not_be_left_behind_is_told() {
    let registry = Registry::standard().with_agent::<Leaves>();
    let files = mission_with("[robot.agent.leaves]\n[robot.agent.other]\nkind = \"leaves\"\n");
    let loaded = mission::load_files(files, "mission.toml", &registry).unwrap();
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { out: Some(out.path().to_owned()), ..RunOptions::default() };
    let outcome = mission::run(loaded, &registry, options).unwrap();
    let note = out.path().join("huey/note.txt");
    assert_eq!(
        outcome.failures,
        [
            "`leaves` on robot `huey`: the diary is lost".to_owned(),
            "`other` on robot `huey`: the diary is lost".to_owned(),
            format!("`{}` was left twice; the first is kept", note.display()),
        ]
    );
    assert_eq!(std::fs::read(note).unwrap(), b"was here");
}
