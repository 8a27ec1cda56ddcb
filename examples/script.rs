//! A manoeuvre that reads like prose, and what happens to it when somebody else takes the robot.
//!
//! ```sh
//! cargo run --example script
//! ```
//!
//! A [`Script`] is an `async fn` over a [`Pilot`]. It is polled once per control period: no threads, no timers, the same course
//! every time. Whatever takes time ends in `.await`, and an override by a higher priority comes out of it as
//! [`Aborted`]. Here one agent drives a square, another with a higher priority takes the base for two seconds and turns
//! the robot, and the square is finished all the same.

use std::f64::consts::{FRAC_PI_2, PI};

use orienteer::{
    Registry,
    mission::{self, RunOptions},
    runtime::{
        agent::{
            Aborted, Agent, Behaviour, BuildError, Finish, Inputs, Outputs, Pilot, PoseHandle, RobotContext, Script, Strategy,
            Wiring,
        },
        agents::NoConfig,
        geometry::{Pose, Twist},
        time::Time,
        topics::{BaseDecision, ClientId, PoseEstimate},
    },
};

/// Side of the square, m.
const SIDE: f64 = 1.0;

/// The manoeuvre. Each corner is a pose relative to the start: x forward, y to the left, then the heading.
async fn square(pilot: Pilot) -> Result<(), Aborted> {
    pilot.next::<PoseEstimate>().await?;
    let corners = [(SIDE, 0.0, FRAC_PI_2), (SIDE, SIDE, PI), (0.0, SIDE, -FRAC_PI_2), (0.0, 0.0, 0.0)];
    let corners = corners.map(|(x, y, heading)| pilot.save_pose(Pose::new(x, y, heading)));
    for corner in corners.into_iter().flatten() {
        reach(&pilot, corner).await?;
        pilot.say("a corner");
    }
    pilot.say("home");
    Ok(())
}

/// Drives to a corner, however often somebody takes the base on the way.
async fn reach(pilot: &Pilot, corner: PoseHandle) -> Result<(), Aborted> {
    while let Err(why) = pilot.move_to(corner, Strategy::Straight, 0.5, 1.0).await {
        // The robot is somewhere else by now. Let go, wait until nobody has the base, and plan anew from there.
        pilot.say(format!("broken off: {why}"));
        pilot.release();
        pilot.until(|inputs| inputs.latest::<BaseDecision>().is_none_or(|decision| decision.holder == ClientId::NONE)).await?;
    }
    Ok(())
}

/// The agent around the script.
struct Square {
    script: Script,
    /// How far from its start the robot was when the script ended, m.
    error: Option<f64>,
    start: Pose,
}

impl Behaviour for Square {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        if self.script.step(now, inputs, out).is_some() {
            self.error = inputs.latest::<PoseEstimate>().map(|here| here.pose.distance(&self.start));
            out.end_mission();
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("off_start_m", self.error.unwrap_or(f64::NAN));
    }
}

impl Agent for Square {
    const KIND: &'static str = "square";
    const HELP: &'static str = "drives a square of 1 m";
    type Config = NoConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<PoseEstimate>().reads::<BaseDecision>();
    }

    fn build(_config: NoConfig, robot: &RobotContext) -> Result<Self, BuildError> {
        let mut wiring = Wiring::default();
        Self::topics(&mut wiring);
        Ok(Self { script: Script::new(&wiring, square), error: None, start: robot.start })
    }
}

/// Takes the base from 4 s to 6 s.
struct Nuisance;

impl Behaviour for Nuisance {
    fn step(&mut self, now: Time, _inputs: &Inputs, out: &mut Outputs) {
        if (4.0..6.0).contains(&now.as_secs_f64()) {
            out.base.drive(Twist::new(0.0, -0.7));
        } else {
            out.base.release();
        }
    }
}

impl Agent for Nuisance {
    const KIND: &'static str = "nuisance";
    const HELP: &'static str = "takes the base for two seconds";
    const PRIORITY: u8 = 9;
    type Config = NoConfig;

    fn topics(_wiring: &mut Wiring) {}

    fn build(_config: NoConfig, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self)
    }
}

const MISSION: &str = r#"
[mission]
duration = 60

[world]
file = "worlds/hallway.toml"

[[robot]]
name = "huey"
base = { driver = "sim", platform = "b12-huey" }
sonar = { driver = "sim", ring = "denning-16" }
start = { x = 5.0, y = -0.5 }

[robot.agent.where-am-i]
[robot.agent.nuisance]      # priority 9, its default
[robot.agent.square]        # priority 5
"#;

fn main() -> Result<(), String> {
    // Shows what the agents say.
    tracing_subscriber::fmt().with_target(false).without_time().init();
    let registry = Registry::standard().with_agent::<Square>().with_agent::<Nuisance>();
    let files = mission::embedded_files().chain([("square.toml".to_owned(), MISSION.as_bytes().to_vec())]);
    let loaded = mission::load_files(files, "square.toml", &registry).map_err(|problems| problems.to_string())?;
    let outcome = mission::run(loaded, &registry, RunOptions::default()).map_err(|error| error.to_string())?;
    for robot in &outcome.robots {
        let error = robot.fact("off_start_m").unwrap_or(f64::NAN);
        println!("{} believes to be {:.3} m from its start after {:.1} s", robot.name, error, outcome.time.as_secs_f64());
    }
    Ok(())
}
