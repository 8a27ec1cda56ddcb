//! The agent, stepped by hand.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use orienteer_runtime::{
    arbitration::Clients,
    geometry::{Limits, Pose},
    random::Streams,
    robot_model::{Platform, Ring},
    topics::{ClientId, FiringProgram},
};

use super::*;

const PERIOD: Duration = Duration::from_millis(50);

/// The first robot of a team of this size.
fn robot(team: usize) -> RobotContext {
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
        team: (0..team).map(|number| Arc::from(format!("robot-{number}"))).collect(),
        start: Pose::default(),
        period: PERIOD,
        streams: Streams::new(1),
    }
}

/// What a geographer says and does in its first step, at this time.
fn first_step(team: usize, at: f64) -> (Geographer, Outputs) {
    let mut wiring = Wiring::default();
    Geographer::topics(&mut wiring);
    let mut geographer = Geographer::build(GeographerConfig::default(), &robot(team)).unwrap();
    let (inputs, mut out) = (Inputs::offline(&wiring), Outputs::offline(&wiring));
    geographer.step(Time::from_secs_f64(at), &inputs, &mut out);
    (geographer, out)
}

#[test]
fn who_was_built_anew_in_a_team_stands_by() {
    let (geographer, out) = first_step(3, 7.0);
    assert!(out.said().iter().any(|line| line.level == Level::WARN && line.text.contains("stands by")), "{:?}", out.said());
    let said = out.published::<Whereabouts>();
    assert_eq!(said.iter().map(|word| (word.state, word.has_spot)).collect::<Vec<_>>(), [(1, 0)]);
    assert!(geographer.is_through(), "nobody else has anything to explore");
}

#[test]
fn who_begins_with_the_others_or_is_alone_explores() {
    for (team, at) in [(3, 0.0), (1, 0.0), (1, 7.0)] {
        let (geographer, out) = first_step(team, at);
        assert!(out.said().is_empty() && !geographer.is_through(), "{team} robots at {at} s");
        assert_eq!(out.published::<Whereabouts>().len(), usize::from(team > 1), "who is alone tells nobody where it is");
    }
}
