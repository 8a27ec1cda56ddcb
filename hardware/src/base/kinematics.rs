//! What a drive can do with a demanded twist.
//!
//! A [`Kinematics`] holds the state of the drive. Each step ramps it towards the demand under the base's limits and moves the
//! true pose along circular arcs; while the twist changes, the step is divided into short arcs whose lengths and turns are
//! the exact integrals of the ramps.
//!
//! # Drives and their robot frames
//!
//! * **Synchro** (Real World Interface B12; Randazza 1989, Good 1992): three wheels steered together, one motor drives, one
//!   steers, and the body turns with the wheels. Speed and turn rate are independent; it turns in place. Origin: the centre.
//! * **Differential** (Yamabico-11, MacPherson 1993; Pioneer; AmigoBot): `v_R,L = v ± ω·W/2`. A demand whose outer wheel
//!   would exceed its ceiling is slowed down with the curve kept, `v ≤ v_wheel / (1 + |κ|·W/2)`. Origin: the middle of the axle.
//! * **Bicycle** (wheelchair, Shanley 1994): front wheel steered by `δ`, wheelbase `L`. Shanley's reference point is the *front*
//!   axle, which moves along `ψ + δ` at `v_f` and turns at `ω = v_f·sin δ / L`. A twist along the heading describes only the
//!   *rear* axle, so that is the origin of the robot frame here: `v = v_f·cos δ`, `ω = v·tan δ / L`, the same motion. Shanley's
//!   point is `pose.then(Pose::new(L, 0, 0))`. It can't turn in place; the smallest curve of the rear axle has radius
//!   `L / tan δ_max` (the front axle's: `L / sin δ_max`).

use orienteer_runtime::{
    geometry::{Limits, Pose, Twist},
    robot_model::Platform,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{presets, profile::ramp};

/// Longest arc, in seconds, while the twist changes.
const LONGEST_ARC: f64 = 0.005;

/// A mobile base as a user describes it. The default is `b12-huey`; see [`presets`] for others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BaseConfig {
    /// Name of the kind of base.
    pub name: String,
    /// Radius of the smallest circle about the origin of the robot frame that contains the body, m.
    #[schemars(range(min = 0.01, max = 5.0))]
    pub radius: f64,
    /// Largest speed, forward and backward, m/s.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub speed: f64,
    /// Largest turn rate, rad/s.
    #[schemars(range(min = 0.01, max = 20.0))]
    pub turn_rate: f64,
    /// Largest change of speed, m/s²; also what a stop may use.
    #[schemars(range(min = 0.01, max = 50.0))]
    pub acceleration: f64,
    /// Largest change of turn rate, rad/s².
    #[schemars(range(min = 0.01, max = 200.0))]
    pub angular_acceleration: f64,
    /// How it moves.
    pub drive: Drive,
}

impl Default for BaseConfig {
    fn default() -> Self {
        BaseConfig { name: "custom".into(), ..presets::b12_huey() }
    }
}

/// The drive of a base.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Drive {
    /// All wheels steered together; turns in place.
    Synchro {},
    /// Two driven wheels side by side; turns in place.
    Differential {
        /// Distance between the driven wheels, m.
        #[schemars(range(min = 0.01, max = 5.0))]
        tread: f64,
        /// Largest speed of one wheel, m/s.
        #[schemars(range(min = 0.01, max = 10.0))]
        wheel_speed: f64,
    },
    /// Fixed rear axle and a steered front wheel; can't turn in place.
    Bicycle {
        /// Distance between the axles, m.
        #[schemars(range(min = 0.05, max = 10.0))]
        wheelbase: f64,
        /// Largest steering angle to either side, rad.
        #[schemars(range(min = 0.01, max = 1.5))]
        steering_limit: f64,
        /// Largest change of the steering angle, rad/s.
        #[schemars(range(min = 0.01, max = 1000.0))]
        steering_rate: f64,
    },
}

impl BaseConfig {
    /// The smallest radius of a curve, m; 0 if it turns in place.
    #[must_use]
    pub fn turning_radius(&self) -> f64 {
        match self.drive {
            Drive::Synchro {} | Drive::Differential { .. } => 0.0,
            Drive::Bicycle { wheelbase, steering_limit, .. } => wheelbase / steering_limit.tan(),
        }
    }

    /// What behaviours and protection need to know of it.
    #[must_use]
    pub fn platform(&self) -> Platform {
        Platform {
            name: self.name.clone(),
            radius: self.radius,
            limits: self.limits(),
            acceleration: self.acceleration,
            angular_acceleration: self.angular_acceleration,
            turning_radius: self.turning_radius(),
        }
    }

    fn limits(&self) -> Limits {
        match self.drive {
            Drive::Differential { tread, wheel_speed } => {
                Limits { linear: self.speed.min(wheel_speed), angular: self.turn_rate.min(2.0 * wheel_speed / tread) }
            }
            Drive::Synchro {} | Drive::Bicycle { .. } => Limits { linear: self.speed, angular: self.turn_rate },
        }
    }
}

/// How a base has moved in one step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Travel {
    /// True pose at the end of the step.
    pub pose: Pose,
    /// Path length, signed: negative backward, m.
    pub distance: f64,
    /// Change of heading, rad, not wrapped.
    pub turn: f64,
}

/// The moving state of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Kinematics {
    config: BaseConfig,
    speed: f64,
    turn_rate: f64,
    steering: f64,
}

impl Kinematics {
    /// A base at rest.
    #[must_use]
    pub fn new(config: BaseConfig) -> Self {
        Self { config, speed: 0.0, turn_rate: 0.0, steering: 0.0 }
    }

    /// What it was made from.
    #[must_use]
    pub fn config(&self) -> &BaseConfig {
        &self.config
    }

    /// True velocity now.
    #[must_use]
    pub fn twist(&self) -> Twist {
        Twist::new(self.speed, self.turn_rate)
    }

    /// Steering angle of a bicycle, rad, left positive; 0 for other drives.
    #[must_use]
    pub fn steering(&self) -> f64 {
        self.steering
    }

    /// Stops dead, as a base does that runs into something.
    pub fn halt(&mut self) {
        self.speed = 0.0;
        self.turn_rate = 0.0;
    }

    /// Follows `demand` for `seconds` from the true pose `from`. A demand that is not finite counts as a stop.
    pub fn step(&mut self, from: Pose, demand: Twist, seconds: f64) -> Travel {
        let target = self.reachable(demand.within(Limits::NONE)).within(self.config.limits());
        let arcs = if self.is_steady(target) { 1.0 } else { (seconds / LONGEST_ARC).ceil().max(1.0) };
        let span = seconds / arcs;
        let mut travel = Travel { pose: from, distance: 0.0, turn: 0.0 };
        for _ in 0..arcs as usize {
            let (distance, turn) = self.arc(target, span);
            travel.pose = travel.pose.along_arc(distance, turn);
            travel.distance += distance;
            travel.turn += turn;
        }
        travel
    }

    /// The demand, slowed down on the same curve or flattened to the tightest curve, so that the drive can hold it.
    fn reachable(&self, demand: Twist) -> Twist {
        match self.config.drive {
            Drive::Synchro {} => demand,
            Drive::Differential { tread, wheel_speed } => {
                let outer = demand.linear.abs() + 0.5 * tread * demand.angular.abs();
                let share = if outer > wheel_speed { wheel_speed / outer } else { 1.0 };
                Twist::new(share * demand.linear, share * demand.angular)
            }
            Drive::Bicycle { .. } => {
                let sharpest = demand.linear.abs() / self.config.turning_radius();
                Twist::new(demand.linear, demand.angular.clamp(-sharpest, sharpest))
            }
        }
    }

    fn is_steady(&self, target: Twist) -> bool {
        self.speed == target.linear && self.turn_rate == target.angular
    }

    /// One short arc: distance and turn.
    fn arc(&mut self, target: Twist, seconds: f64) -> (f64, f64) {
        let wanted = match self.config.drive {
            // It speeds up no faster than its turning ends: the outer wheel must not run away.
            Drive::Differential { tread, wheel_speed } => {
                let free = (wheel_speed - 0.5 * tread * self.turn_rate.abs()).max(0.0);
                target.linear.clamp(-free, free)
            }
            Drive::Synchro {} | Drive::Bicycle { .. } => target.linear,
        };
        let (speed, distance) = ramp(self.speed, wanted, self.config.acceleration, seconds);
        let turn = match self.config.drive {
            Drive::Synchro {} => self.ramp_turn(target.angular, f64::MAX, seconds),
            Drive::Differential { tread, wheel_speed } => {
                // Nor does it begin to turn faster than it slows down.
                let room = 2.0 * (wheel_speed - speed.abs()).max(0.0) / tread;
                self.ramp_turn(target.angular, room, seconds)
            }
            Drive::Bicycle { wheelbase, steering_limit, steering_rate } => {
                // At rest the curve is undefined, and the wheels stay as they are.
                let wanted =
                    if target.linear == 0.0 { self.steering } else { (wheelbase * target.angular / target.linear).atan() };
                let wanted = wanted.clamp(-steering_limit, steering_limit);
                let (steering, swept) = ramp(self.steering, wanted, steering_rate, seconds);
                self.steering = steering;
                self.turn_rate = speed * steering.tan() / wheelbase;
                distance * (swept / seconds).tan() / wheelbase
            }
        };
        self.speed = speed;
        (distance, turn)
    }

    fn ramp_turn(&mut self, target: f64, room: f64, seconds: f64) -> f64 {
        let (rate, turn) = ramp(self.turn_rate, target.clamp(-room, room), self.config.angular_acceleration, seconds);
        self.turn_rate = rate;
        turn
    }
}

#[cfg(test)]
mod tests;
