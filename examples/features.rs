//! What kind of place is this? Three features that are asked for, one after the other.
//!
//! ```sh
//! cargo run --example features
//! ```
//!
//! A Huey follows a corridor to a T (Randazza 1989), and a behaviour of our own asks the feature detector for the corner on the open
//! side, the wall opposite, and a doorpost that is not there. Where each must be follows from the width that the corridor follower has
//! measured. After every detector the robot goes back to where the place is looked at from.

use std::sync::Arc;

use orienteer::{
    Registry,
    agents::places::{Reckoning, Whereabouts},
    hardware::world::floors::{Hypothesis, Perturbation, junction_world},
    mission::{self, RunOptions},
    runtime::{
        agent::{
            Aborted, Agent, Behaviour, BuildError, Finish, Inputs, Outputs, Pilot, PoseHandle, RobotContext, Script, Strategy,
            Wiring,
        },
        agents::NoConfig,
        robot_model::Ring,
        time::Time,
        topics::{CorridorOrder, CorridorReport, FeatureKind, FeatureReport, FeatureRequest, Opening, PoseEstimate, Side},
    },
};

/// Goes to the next place and looks at it.
async fn look(pilot: Pilot, ring: Arc<Ring>) -> Result<(), Aborted> {
    let place = follow(&pilot).await?;
    let open = if place.opening() == Opening::Left { Side::Left } else { Side::Right };
    pilot.say(format!("a place, open to the {open:?}; the corridor is {:.2} m wide", place.width));
    let reckoning = Reckoning::new(place.width, &ring);
    let questions = [
        (FeatureKind::Convex, Whereabouts::Near(open)),
        (FeatureKind::Wall, Whereabouts::Beside(open.other())),
        (FeatureKind::Edge, Whereabouts::Near(open)),
    ];
    for (number, (kind, whereabouts)) in (1..).zip(questions) {
        let Some(search) = reckoning.search(kind, whereabouts, place.pose) else { continue };
        let report = ask(&pilot, &FeatureRequest::new(pilot.now(), number, &search)).await?;
        let (outcome, reason) = (report.outcome(), report.reason());
        pilot.say(format!("{kind:?} {whereabouts:?}: {outcome:?} ({reason:?}), {:.0} % sure", 100.0 * report.certainty));
        pilot.move_to(PoseHandle::at(place.pose), Strategy::Straight, 0.2, 0.5).await?;
        pilot.release();
    }
    Ok(())
}

/// Has the corridor follower go to the next place. Orders are repeated until they have been carried out.
async fn follow(pilot: &Pilot) -> Result<CorridorReport, Aborted> {
    loop {
        pilot.publish(CorridorOrder { stamp: pilot.now(), order: 1 });
        pilot.next_step().await?;
        if let Some(report) = pilot.latest::<CorridorReport>() {
            return Ok(report);
        }
    }
}

/// Has the feature detector look for something.
async fn ask(pilot: &Pilot, request: &FeatureRequest) -> Result<FeatureReport, Aborted> {
    loop {
        pilot.publish(*request);
        pilot.next_step().await?;
        if let Some(report) = pilot.latest::<FeatureReport>().filter(|report| report.request == request.request) {
            return Ok(report);
        }
    }
}

/// The agent around the script.
struct Looker {
    script: Script,
}

impl Behaviour for Looker {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        if self.script.step(now, inputs, out).is_some() {
            out.end_mission();
        }
    }

    fn finish(&mut self, now: Time, last_words: &mut Finish) {
        last_words.fact("seconds", now.as_secs_f64());
    }
}

impl Agent for Looker {
    const KIND: &'static str = "looker";
    const HELP: &'static str = "asks for three features of the next place";
    const PRIORITY: u8 = 4;
    type Config = NoConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<PoseEstimate>().reads::<CorridorReport>().reads::<FeatureReport>();
        wiring.writes::<CorridorOrder>().writes::<FeatureRequest>();
    }

    fn build(_config: NoConfig, robot: &RobotContext) -> Result<Self, BuildError> {
        let mut wiring = Wiring::default();
        Self::topics(&mut wiring);
        let ring = robot.ring.clone();
        Ok(Self { script: Script::new(&wiring, move |pilot| look(pilot, ring)) })
    }
}

const MISSION: &str = r#"
[mission]
duration = 900

[record]
enabled = false

[world]
file = "place.toml"

[[robot]]
name = "huey"
start = { place = "approach" }
base = { driver = "sim", platform = "b12-huey" }
sonar = { driver = "sim", ring = "denning-16" }

[robot.agent.where-am-i]
[robot.agent.avoidance]
[robot.agent.feature-detector]
[robot.agent.corridor-follower]
[robot.agent.looker]
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Shows what the agents say.
    tracing_subscriber::fmt().with_target(false).without_time().init();
    let registry = Registry::standard().with_agent::<Looker>();
    let place = junction_world(Hypothesis::H1, &Perturbation::NONE)?;
    let files = [("features.toml".to_owned(), MISSION.into()), ("place.toml".to_owned(), place.text().into_bytes())];
    let loaded = mission::load_files(files, "features.toml", &registry)?;
    let outcome = mission::run(loaded, &registry, RunOptions::default())?;
    let huey = &outcome.robots[0];
    println!("{}: {} found, {} not", place.hypothesis, huey.fact("found").unwrap_or(0.0), huey.fact("not_found").unwrap_or(0.0));
    Ok(())
}
