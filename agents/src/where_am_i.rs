//! Where am I: dead reckoning with a covariance.
//!
//! Odometry is turned into a pose in the map frame. Between two readings the robot is taken to have followed a circular arc
//! (MacPherson 1993, §3); a chord would shorten every curve. Uncertainty grows with distance and turning:
//!
//! ```text
//! translation d at heading h:  P ← J P Jᵀ + (σ_t d)² u uᵀ,   J = ∂(x, y, h)/∂(x, y, h),  u = (cos h, sin h, 0)
//!                              P_hh += (σ_d d)²
//! rotation a:                  P_hh += (σ_r a)²
//! ```
//!
//! The first-order model follows the description of the position keeper in Randazza (1989), §2, which names the covariance
//! but gives no law for it.

mod dead_reckoning;

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, Phase, RobotContext, Wiring},
    time::Time,
    topics::{Odometry, PoseEstimate},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use dead_reckoning::DeadReckoning;

/// Parameters of where-am-i: how quickly dead reckoning loses its way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WhereAmIConfig {
    /// Standard deviation of a distance, as a share of it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub distance_error: f64,
    /// Standard deviation of a turn, as a share of it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub turn_error: f64,
    /// Standard deviation of the heading after driving one metre straight on, rad/m.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub drift: f64,
}

impl Default for WhereAmIConfig {
    fn default() -> Self {
        Self { distance_error: 0.01, turn_error: 0.01, drift: 0.05 }
    }
}

/// The agent: odometry in, pose out.
#[derive(Debug)]
pub struct WhereAmI {
    reckoning: DeadReckoning,
}

impl Behaviour for WhereAmI {
    fn step(&mut self, _now: Time, inputs: &Inputs, out: &mut Outputs) {
        for odometry in inputs.each::<Odometry>() {
            self.reckoning.update(odometry);
        }
        if inputs.fresh::<Odometry>().is_some() {
            out.publish(self.reckoning.estimate());
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("distance_m", self.reckoning.estimate().travelled);
    }
}

impl Agent for WhereAmI {
    const KIND: &'static str = "where-am-i";
    const HELP: &'static str = "dead reckoning with covariance: turns odometry into a pose on the map";
    const PHASE: Phase = Phase::Estimate;
    const CLAIMS: bool = false;
    type Config = WhereAmIConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<Odometry>().writes::<PoseEstimate>();
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self { reckoning: DeadReckoning::new(config, robot.start) })
    }
}
