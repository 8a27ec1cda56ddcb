//! A behaviour of your own: a wanderer that turns away from whatever is in front of it.
//!
//! ```sh
//! cargo run --example custom_behaviour
//! cargo run --example custom_behaviour -- list agents
//! ```
//!
//! With arguments it is the whole of `orienteer`, with one more kind of agent.
//!
//! A behaviour is a plain state machine: once per control period it looks at its inputs and fills its outputs. It knows
//! nothing of actors, clocks or shared memory. To make it a kind of agent that a configuration can name, say what it is called,
//! which topics it reads, what its parameters are, and how it is built.
//!
//! It need not be perfect: it asks for the base with a priority like any other behaviour, and whatever it asks for, the base
//! never drives faster than it can stop in the free distance that its sonar sees.

use std::process::ExitCode;

use orienteer::{
    Registry, cli,
    mission::{self, RunOptions},
    runtime::{
        agent::{Agent, Behaviour, BuildError, Inputs, Outputs, RobotContext, Wiring},
        geometry::Twist,
        time::Time,
        topics::SonarScan,
    },
};
use schemars::JsonSchema;
use serde::Deserialize;

/// Parameters: the keys of `[robot.agent.wanderer]`. Their comments and ranges become part of the configuration's schema, so
/// a wrong key or an absurd value is refused with file, line and column before anything moves.
#[derive(Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct WandererConfig {
    /// Speed, m/s.
    #[schemars(range(min = 0.05, max = 1.0))]
    speed: f64,
    /// Turn away from anything nearer than this, m.
    #[schemars(range(min = 0.2, max = 3.0))]
    clearance: f32,
}

impl Default for WandererConfig {
    fn default() -> Self {
        Self { speed: 0.4, clearance: 0.8 }
    }
}

// README: the behaviour begins
struct Wanderer {
    config: WandererConfig,
    ahead: Vec<usize>, // the transducers that look forward
    max_range: f32,
}

impl Behaviour for Wanderer {
    fn step(&mut self, _now: Time, inputs: &Inputs, out: &mut Outputs) {
        let Some(scan) = inputs.latest::<SonarScan>() else { return };
        let free = self.ahead.iter().filter_map(|i| scan.echo(*i).free_distance(self.max_range)).fold(f32::MAX, f32::min);
        out.base.drive(if free < self.config.clearance { Twist::new(0.0, 0.6) } else { Twist::new(self.config.speed, 0.0) });
    }
}

impl Agent for Wanderer {
    const KIND: &'static str = "wanderer";
    const HELP: &'static str = "drives on, and turns left where it can't";
    type Config = WandererConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<SonarScan>();
    }

    fn build(config: WandererConfig, robot: &RobotContext) -> Result<Self, BuildError> {
        let ahead = robot.ring.within(0.0, 30_f64.to_radians()).collect();
        Ok(Self { config, ahead, max_range: robot.ring.max_range as f32 })
    }
}
// README: the behaviour ends

const MISSION: &str = r#"
[mission]
duration = 30

[world]
file = "worlds/office-floor.toml"     # built into the program

[[robot]]
name = "rover"
base = { driver = "sim", platform = "p3dx" }
sonar = { driver = "sim", ring = "p3dx-16" }
start = { place = "south-west" }

[robot.agent.where-am-i]

[robot.agent.avoidance]
priority = 10                         # larger wins

[robot.agent.wanderer]
priority = 5
clearance = 1.0
"#;

fn main() -> ExitCode {
    let registry = Registry::standard().with_agent::<Wanderer>();
    if std::env::args().len() > 1 {
        return cli::main(&registry);
    }
    match wander(&registry) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn wander(registry: &Registry) -> Result<(), String> {
    let mine = ("wander.toml".to_owned(), MISSION.as_bytes().to_vec());
    let files = mission::embedded_files().chain([mine]);
    let loaded = mission::load_files(files, "wander.toml", registry).map_err(|problems| problems.to_string())?;
    let outcome = mission::run(loaded, registry, RunOptions::default()).map_err(|error| error.to_string())?;

    println!("{:.0} simulated seconds, {:.0} times faster than life", outcome.time.as_secs_f64(), outcome.real_time_factor());
    for robot in &outcome.robots {
        for (name, value) in robot.facts() {
            println!("{:>8} {name:<16} {value:.2}", robot.name);
        }
    }
    Ok(())
}
