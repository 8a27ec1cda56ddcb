//! A base of your own: what it takes to put another robot under the same behaviours.
//!
//! ```sh
//! cargo run --example custom_base_driver
//! ```
//!
//! A driver is polled, never blocks, and is told the time. This one drives a point in memory; one for real wheels
//! writes a frame to a serial line in `command` and takes apart what has arrived in `poll`. From then on a configuration names it
//! (`base = { driver = "toy" }`), its keys are checked like all others, and everything above it is the same as for
//! the simulated bases: arbitration, limits, protection, recording. At wall time (`clock = "wall"`) the framework moves it to a
//! thread of its own with a dead-man's handle. A driver for real wheels insists on that with `const REAL_TIME: bool = true;`: without it
//! a mission in simulated time would rush through as fast as the machine can.
//!
//! The robot has no sonar: it has no `sonar` key, and its base says that it may drive without one.

use orienteer::{
    Registry,
    hardware::{
        base::{executor::ExecutorConfig, protection::ProtectionConfig},
        driver::{BaseDriver, DriverError},
        drivers::{BaseKind, OpenBase, Site},
    },
    mission::{self, RunOptions},
    runtime::{
        agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
        config::Problems,
        geometry::{Limits, Pose, Twist},
        robot_model::Platform,
        time::Time,
        topics::{Odometry, PoseEstimate},
    },
};
use schemars::JsonSchema;
use serde::Deserialize;

/// A point with wheels.
struct ToyBase {
    platform: Platform,
    /// As if the encoders had been read at this time.
    odometry: Odometry,
    demand: Twist,
}

impl BaseDriver for ToyBase {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, _now: Time, twist: Twist) -> Result<(), DriverError> {
        self.demand = twist;
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        let seconds = now.secs_since(self.odometry.stamp);
        let last = self.odometry;
        self.odometry = Odometry {
            stamp: now,
            pose: last.pose.after(self.demand, seconds),
            twist: self.demand,
            travelled: last.travelled + self.demand.linear.abs() * seconds,
            turned: last.turned + self.demand.angular * seconds,
            ..last
        };
        Ok(self.odometry)
    }

    fn stop(&mut self) {
        self.demand = Twist::STOP;
    }
}

/// Keys beside `driver`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct ToyConfig {
    /// Largest speed, m/s.
    #[schemars(range(min = 0.01, max = 2.0))]
    speed: f64,
}

impl Default for ToyConfig {
    fn default() -> Self {
        Self { speed: 0.5 }
    }
}

struct Toy;

impl BaseKind for Toy {
    const NAME: &'static str = "toy";
    const HELP: &'static str = "a point with wheels, in memory";
    // It is told the time and has no clock of its own, so any will do.
    const REAL_TIME: bool = false;
    type Config = ToyConfig;

    /// Says with [`Site::problem`] what can't be in the configuration. A real driver only takes its port's name here, and opens it when it
    /// is first polled: `orienteer check` opens nothing.
    fn open(config: ToyConfig, site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        let platform = Platform {
            name: "toy".to_owned(),
            radius: 0.1,
            limits: Limits { linear: config.speed, angular: 1.5 },
            acceleration: 1.0,
            angular_acceleration: 3.0,
            turning_radius: 0.0,
        };
        let driver = ToyBase { platform, odometry: Odometry::default(), demand: Twist::STOP };
        Ok(OpenBase {
            driver: Box::new(driver),
            motion: ExecutorConfig::default(),
            protection: ProtectionConfig { sonar_required: false, ..ProtectionConfig::default() },
            start: site.start.unwrap_or_default(),
        })
    }
}

/// Something for it to do: circles. It asks for more than the base can do, and gets what the base can do.
#[derive(Default)]
struct Circles {
    last: Pose,
}

impl Behaviour for Circles {
    fn step(&mut self, _now: Time, inputs: &Inputs, out: &mut Outputs) {
        if let Some(estimate) = inputs.latest::<PoseEstimate>() {
            self.last = estimate.pose;
        }
        out.base.drive(Twist::new(0.8, 0.8));
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("from_start_m", self.last.distance(&Pose::default()));
    }
}

impl Agent for Circles {
    const KIND: &'static str = "circles";
    const HELP: &'static str = "drives in circles of 1 m";
    type Config = orienteer::runtime::agents::NoConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<PoseEstimate>();
    }

    fn build(_config: Self::Config, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self::default())
    }
}

const MISSION: &str = r#"
[mission]
duration = 20
links = "direct"        # nobody outside has to listen

[[robot]]
name = "point"
base = { driver = "toy", speed = 0.4 }

[robot.agent.where-am-i]
[robot.agent.circles]
"#;

fn main() -> Result<(), String> {
    let registry = Registry::standard().with_base::<Toy>().with_agent::<Circles>();
    let files = [("toy.toml".to_owned(), MISSION.as_bytes().to_vec())];
    let loaded = mission::load_files(files, "toy.toml", &registry).map_err(|problems| problems.to_string())?;
    let outcome = mission::run(loaded, &registry, RunOptions::default()).map_err(|error| error.to_string())?;
    for robot in &outcome.robots {
        println!("{} after {} s", robot.name, outcome.time.as_secs_f64());
        for (name, value) in robot.facts() {
            println!("  {name:<16} {value:.2}");
        }
    }
    Ok(())
}
