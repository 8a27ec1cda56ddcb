//! The agent, stepped by hand.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use orienteer_runtime::{
    agent::Teammate,
    arbitration::Clients,
    geometry::{Limits, Pose},
    random::Streams,
    robot_model::{Platform, Ring},
    topics::{ClientId, FiringProgram},
};

use super::*;

const PERIOD: Duration = Duration::from_millis(50);

/// The first robot of a team of this size; all of them have an agent of this kind.
fn robot(team: usize, agents: &str) -> RobotContext {
    let program = FiringProgram::default();
    let platform = Platform {
        name: "test".into(),
        radius: 0.3,
        limits: Limits { linear: 1.0, angular: 1.0 },
        acceleration: 2.0,
        angular_acceleration: 3.0,
        turning_radius: 0.0,
    };
    RobotContext {
        robot: "robot-0".into(),
        node: "geographer".into(),
        client: ClientId(0),
        clients: Arc::new([("geographer", 4)].into_iter().collect::<Clients>()),
        platform: Arc::new(platform),
        ring: Arc::new(Ring {
            name: "none".into(),
            transducers: Vec::new(),
            min_range: 0.0,
            max_range: 7.0,
            slot_time: 1.0,
            program,
        }),
        team: (0..team)
            .map(|number| Teammate { name: format!("robot-{number}").into(), agents: vec![agents.to_owned()] })
            .collect(),
        start: Pose::default(),
        period: PERIOD,
        streams: Streams::new(1),
    }
}

/// What a geographer says and does in its first step, at this time.
fn first_step(robot: &RobotContext, at: f64) -> (Geographer, Outputs) {
    let mut geographer = Geographer::build(GeographerConfig::default(), robot).unwrap();
    let out = step(&mut geographer, at);
    (geographer, out)
}

/// A step in which it hears nothing but where it is.
fn step(geographer: &mut Geographer, at: f64) -> Outputs {
    let mut wiring = Wiring::default();
    Geographer::topics(&mut wiring);
    let (mut inputs, mut out) = (Inputs::offline(&wiring), Outputs::offline(&wiring));
    inputs.put(PoseEstimate::default());
    geographer.step(Time::from_secs_f64(at), &inputs, &mut out);
    out
}

#[test]
fn who_was_built_anew_in_a_team_stands_by_and_writes_nothing() {
    let (mut geographer, out) = first_step(&robot(3, "geographer"), 7.0);
    assert!(out.said().iter().any(|line| line.level == Level::WARN && line.text.contains("stands by")), "{:?}", out.said());
    let said = out.published::<Whereabouts>();
    assert_eq!(said.iter().map(|word| (word.state, word.has_spot)).collect::<Vec<_>>(), [(4, 0)]);
    for (at, is_through) in [(7.05, false), (7.1, false), (11.9, false), (12.1, true)] {
        step(&mut geographer, at);
        let time = Time::from_secs_f64(at);
        assert_eq!(
            geographer.is_through(time),
            is_through,
            "at {at} s: the others have had {:.1} s to say where they are",
            at - 7.0
        );
    }
    let mut last_words = Finish::default();
    geographer.finish(Time::from_secs_f64(13.0), &mut last_words);
    assert!(last_words.files.is_empty() && last_words.facts.is_empty(), "it would write an empty map");
}

#[test]
fn who_begins_with_the_others_or_explores_alone_explores() {
    for (team, agents, at, words) in
        [(3, "geographer", 0.0, 1), (1, "geographer", 0.0, 0), (1, "geographer", 7.0, 0), (3, "patrol", 7.0, 0)]
    {
        let (geographer, out) = first_step(&robot(team, agents), at);
        let time = Time::from_secs_f64(at);
        assert!(out.said().is_empty() && !geographer.is_through(time), "{team} robots with {agents} at {at} s");
        assert_eq!(out.published::<Whereabouts>().len(), words, "who is alone tells nobody where it is");
    }
}
