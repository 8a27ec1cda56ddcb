//! Always a way to stop.
//!
//! A base that is told to stop does not stop, it brakes; and one that is told to turn off may turn sooner or later than it slows
//! down. So it is not enough that the demanded arc is free. The rule kept here is:
//!
//! > After every control period the base can brake, **on the curve that it is then on**, before it touches anything that it sees.
//!
//! For a command `(u, κ·u)` the state after the period follows from the platform's accelerations: `v' = ramp(v → u, a)`, `ω' = ramp(ω → κu, α)`, and the
//! pose after the arc of the means. The command is safe if that arc is free, and if from its end
//!
//! ```text
//! v'·latency + v'² / 2b  ≤  free(κ') − margin,      κ' = ω' / v',     b = share · min(a, α / |κ'|)
//! ```
//!
//! `b` is no more than keeps the base on its curve while it brakes: there the turn rate has to fall in step with the speed. If
//! the demand is not safe, the fastest safe command on its curve is taken; if not even a stop is (turning off the present
//! curve while braking would touch something), the base brakes on its present curve, which the rule kept one period before.
//! Braking is the one command that comes from a measurement. A measured speed that no command explains (an encoder that
//! slipped, a step divided by too short a time) is braked from as if it were what was commanded, or stopped outright.

use nalgebra::Rotation2;
use orienteer_runtime::{
    geometry::{Pose, Twist},
    robot_model::Platform,
    time::Time,
};

use super::{ProtectionConfig, sight::Obstacle, swept_path::SweptPath, told::Told};
use crate::base::profile::ramp;

/// Slower than this, m/s, counts as standing.
const STANDING: f64 = 1e-4;

/// No command is permitted below this, m/s.
const CREEP: f64 = 2e-3;

/// What the base is doing now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Velocity, the speed rather over- than underestimated.
    pub twist: Twist,
    /// The speed rather under- than overestimated, m/s, without sign.
    pub surely: f64,
}

impl Motion {
    /// What a base that measured `measured` may be doing, or will before it heeds the next command, if it may follow any of its
    /// commands `since` then. It measured the mean over a period (s), as drivers may, and that ended an age (s) before.
    pub(super) fn estimate(measured: Twist, told: &Told, since: Time, platform: &Platform, (period, age): (f64, f64)) -> Self {
        let last = told.last();
        let sense = if measured.linear == 0.0 { last.linear.signum() } else { measured.linear.signum() };
        let (least, greatest) = told.speeds(since);
        let (one, other) = ((sense * least).max(0.0), (sense * greatest).max(0.0));
        let (speed, change) = (sense * measured.linear, platform.acceleration * (period + age));
        let (angular, _) = ramp(measured.angular, last.angular, platform.angular_acceleration, 0.5 * period + age);
        Self {
            twist: Twist::new(sense * speed.max(one.max(other).min(speed + change)), angular),
            surely: speed.min(one.min(other).max(speed - change)).max(0.0),
        }
    }
}

/// Judges commands against what the sonar sees.
#[derive(Debug)]
pub struct SafeStop<'a> {
    /// The base.
    pub platform: &'a Platform,
    /// Its protection's settings.
    pub config: &'a ProtectionConfig,
    /// What it is doing.
    pub motion: Motion,
    /// The speed that its commands have given it, m/s, signed: braking is never commanded from more, whatever is measured.
    pub pace: f64,
    /// What may be there, in the robot frame of now.
    pub obstacles: &'a [Obstacle],
}

impl SafeStop<'_> {
    /// The demand if it is safe, else the fastest safe command on its curve, else braking on the present curve.
    pub fn fastest(&self, demand: Twist) -> Twist {
        if self.is_safe(demand) {
            return demand;
        }
        if !self.is_safe(Twist::STOP) {
            return self.brake();
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..10 {
            let middle = 0.5 * (low + high);
            if self.is_safe(scaled(demand, middle)) {
                low = middle;
            } else {
                high = middle;
            }
        }
        let fastest = scaled(demand, low);
        // Bisection creeps; a base that may do no more than that stands.
        if fastest.linear.abs() > CREEP { fastest } else { Twist::STOP }
    }

    /// No command on the way to `demand` needs more path than this to come to rest, m.
    pub fn reach(&self, demand: Twist) -> f64 {
        let (now, config) = (self.motion.twist, self.config);
        let speed = now.linear.abs().max(demand.linear.abs().min(now.linear.abs() + self.platform.acceleration * config.period));
        let rate = now.angular.abs().max(demand.angular.abs());
        let braking = (speed * speed / self.platform.acceleration).max(speed * rate / self.platform.angular_acceleration);
        speed * (config.period + config.latency) + braking / (2.0 * config.braking_share) + config.margin
    }

    /// As hard as the present curve can be kept.
    fn brake(&self) -> Twist {
        let Motion { twist, surely } = self.motion;
        let present = Twist::new(surely.copysign(twist.linear), twist.angular);
        let left = (surely - self.deceleration(present) * self.config.period).min(self.pace * twist.linear.signum());
        // Nothing is left of a speed that is gone within the period; the quotient keeps the curve.
        if left > 0.0 { scaled(present, left / surely).within(self.platform.limits) } else { Twist::STOP }
    }

    /// Largest deceleration at which the turn rate can fall in step with the speed.
    fn deceleration(&self, twist: Twist) -> f64 {
        let on_curve = self.platform.angular_acceleration * twist.linear.abs() / twist.angular.abs();
        if on_curve.is_nan() { self.platform.acceleration } else { self.platform.acceleration.min(on_curve) }
    }

    fn is_safe(&self, command: Twist) -> bool {
        let (now, period) = (self.motion.twist, self.config.period);
        let (linear, way) = ramp(now.linear, command.linear, self.platform.acceleration, period);
        let (angular, turn) = ramp(now.angular, command.angular, self.platform.angular_acceleration, period);
        let after = Twist::new(linear, angular);
        if way.abs() > STANDING * period && !self.is_free(Pose::default(), Twist::new(way, turn), way.abs()) {
            return false;
        }
        if linear.abs() < STANDING {
            return true;
        }
        let speed = linear.abs();
        let braking = speed.max(now.linear.abs()) * self.config.latency
            + speed * speed / (2.0 * self.config.braking_share * self.deceleration(after));
        let needed = braking + self.config.margin;
        self.is_free(Pose::default().along_arc(way, turn), after, needed)
    }

    /// True if the first `length` metres of the arc of `twist` from `pose` (robot frame of now) on are free.
    fn is_free(&self, pose: Pose, twist: Twist, length: f64) -> bool {
        let body = self.platform.radius + self.config.clearance;
        let Some(path) = SweptPath::new(twist, body) else { return true };
        let back = Rotation2::new(-pose.heading);
        let reach = body + length;
        !self.obstacles.iter().any(|obstacle| {
            let offset = obstacle.point - pose.point();
            // Most obstacles are out of reach; that much is cheap to see.
            let is_near = offset.norm_squared() < reach * reach;
            let is_near_wall = obstacle.is_wall && obstacle.ray.dot(&offset) < reach;
            (is_near && path.to_point((back * offset).into()) < length)
                || (is_near_wall && path.to_wall(back * obstacle.ray, obstacle.ray.dot(&offset)) < length)
        })
    }
}

fn scaled(twist: Twist, share: f64) -> Twist {
    Twist::new(share * twist.linear, share * twist.angular)
}
