//! Avoidance: slows the robot before things that come near, and steps aside for those that keep coming.
//!
//! Randazza (1989, §2.7) states the idea: follow what gets nearer; if the robot moves and something is too close, have its
//! speed lowered; if it stands and something still comes, move out of the way. The numbers are ours, and chosen so that legal
//! manoeuvres (48 cm from a wall, 31 cm from a door post) never set it off.
//!
//! * [`Surroundings`] keeps a short history of each transducer, free of the robot's own motion, and says what comes nearer by
//!   itself and how fast.
//! * [`caution`] turns that into a cap on the speed, which takes the base from nobody.
//! * [`Evasion`] is the last resort. It takes the base, turns toward the most open way across the comer's path, drives there,
//!   waits until nothing comes any more, and turns back to where it was heading.
//!
//! A thing at rest must never look like a comer, at whatever angle the beams meet it: see [`Surroundings`].

mod caution;
mod evasion;
mod surroundings;
mod track;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
    geometry::Limits,
    time::Time,
    topics::{BaseDecision, MotionKind, Odometry, SonarScan},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use caution::{caution, course};
pub use evasion::{Evasion, Move};
pub use surroundings::{Surroundings, Threat};

/// Parameters of avoidance. Clearances are measured from the body, not from the sonar's face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AvoidanceConfig {
    /// Clearance in the direction of travel at which the robot stops, m (a reading of 25 cm on Huey's ring).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub stop_clearance: f64,
    /// Clearance below which the robot slows down for what comes nearer, m (a reading of 60 cm on Huey's ring).
    #[schemars(range(min = 0.05, max = 3.0))]
    pub slow_clearance: f64,
    /// Speed allowed at the outer edge of the slow zone, m/s; it falls to zero at the inner edge.
    #[schemars(range(min = 0.05, max = 2.0))]
    pub slow_speed: f64,
    /// Something that comes nearer by itself faster than this, m/s, is a threat.
    #[schemars(range(min = 0.02, max = 1.0))]
    pub approach_speed: f64,
    /// How much nearer it must have come before the robot steps aside, m (Randazza's three rings and 10 cm); it slows down for
    /// 0.6 of that.
    #[schemars(range(min = 0.02, max = 1.0))]
    pub approach_distance: f64,
    /// Stop for a threat that would reach the body within this time, s.
    #[schemars(range(min = 0.2, max = 10.0))]
    pub halt_time: f64,
    /// Step aside for a threat that would reach the body within this time, s.
    #[schemars(range(min = 0.5, max = 20.0))]
    pub evade_time: f64,
    /// Never step aside for anything farther than this, m.
    #[schemars(range(min = 0.2, max = 5.0))]
    pub evade_clearance: f64,
    /// How far one step aside leads, m.
    #[schemars(range(min = 0.1, max = 3.0))]
    pub step: f64,
    /// Speed of a step aside, m/s.
    #[schemars(range(min = 0.05, max = 2.0))]
    pub step_speed: f64,
    /// Turn rate when stepping aside, rad/s.
    #[schemars(range(min = 0.1, max = 6.0))]
    pub turn_rate: f64,
    /// How many steps aside in a row before it only stands still. 0: it never steps aside; where nobody can get past, whoever comes turns back sooner
    /// than a robot that they drive before them.
    #[schemars(range(min = 0, max = 100))]
    pub most_steps: u32,
    /// The base is given back when nothing has come nearer for this long, s.
    #[schemars(range(min = 0.1, max = 60.0))]
    pub calm: f64,
}

impl Default for AvoidanceConfig {
    fn default() -> Self {
        Self {
            stop_clearance: 0.03,
            slow_clearance: 0.38,
            slow_speed: 0.5,
            approach_speed: 0.1,
            approach_distance: 0.10,
            halt_time: 2.5,
            evade_time: 5.0,
            evade_clearance: 2.2,
            step: 0.65,
            step_speed: 0.5,
            turn_rate: 1.8,
            most_steps: 5,
            calm: 1.0,
        }
    }
}

/// The agent.
#[derive(Debug)]
pub struct Avoidance {
    config: AvoidanceConfig,
    surroundings: Surroundings,
    evasion: Evasion,
    slowed: u64,
}

impl Behaviour for Avoidance {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        let Some(odometry) = inputs.latest::<Odometry>() else { return };
        self.surroundings.moved(odometry);
        self.surroundings.heard(inputs.each::<SonarScan>());
        let idle = !self.evasion.is_active();
        // Who steps aside looks out for itself; a cap for the sake of the comer would keep it in the comer's way.
        let told = inputs.latest::<BaseDecision>().map_or(MotionKind::Stop, |decision| decision.motion.kind());
        let limit = caution(&self.config, &self.surroundings, course(odometry.twist, told)).filter(|_| idle);
        if let Some(speed) = limit {
            out.base.limit(Limits { linear: speed, angular: f64::MAX });
            self.slowed += 1;
        }
        match self.evasion.step(now, &self.config, &self.surroundings, odometry) {
            Move::Nothing if idle => {}
            Move::Nothing => {
                out.base.release();
                out.say("the way is clear again");
            }
            Move::Drive(twist) => out.base.drive(twist),
        }
        if let Some(threat) = self.evasion.threat().filter(|_| idle && self.evasion.is_active()) {
            let Threat { bearing, clearance, approach, .. } = threat;
            let side = bearing.to_degrees();
            let does = if self.config.most_steps > 0 { "steps aside" } else { "stands still" };
            out.say(format!("{does}: {clearance:.2} m away at {side:.0} deg, something comes nearer at {approach:.2} m/s"));
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("contacts_avoided", f64::from(self.evasion.count()));
        last_words.fact("slowed_steps", self.slowed as f64);
    }
}

impl Agent for Avoidance {
    const KIND: &'static str = "avoidance";
    const HELP: &'static str = "slows down before things that come near, and steps aside for those that keep coming";
    const PRIORITY: u8 = 10;
    type Config = AvoidanceConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<SonarScan>().reads::<Odometry>().reads::<BaseDecision>();
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        if config.stop_clearance >= config.slow_clearance {
            return Err(BuildError::new("`stop_clearance` must be smaller than `slow_clearance`"));
        }
        Ok(Self {
            config,
            surroundings: Surroundings::new(Arc::clone(&robot.ring), robot.platform.radius),
            evasion: Evasion::new(robot.platform.turning_radius == 0.0),
            slowed: 0,
        })
    }
}
