//! How fast the robot may go with what is around it: the limit that avoidance sets without taking the base.

use std::f64::consts::{FRAC_PI_2, PI};

use orienteer_runtime::{
    geometry::{Twist, angle},
    topics::MotionKind,
};

use super::{AvoidanceConfig, Surroundings};

/// How far to either side of the direction of travel something is in the way: 67.5°.
const IN_THE_WAY: f64 = 3.0 * PI / 8.0 + 1e-6;

/// How far to either side somebody may still step into its way: a right angle and a little more than half a beam.
const BESIDE: f64 = FRAC_PI_2 + 0.25;
/// Somebody who comes from the side this close stops the robot, m, ...
const AT_HAND: f64 = 0.15;
/// ... with what they cover until it has noticed them and stands, s.
const REACTION: f64 = 0.6;

/// Slower than this the robot stands, m/s.
const STANDS: f64 = 0.01;

/// Where the robot goes, off its heading, rad: as it moves, or if it stands, as it is told to move. Who stands before something must be free to back
/// off.
#[must_use]
pub fn course(twist: Twist, told: MotionKind) -> f64 {
    let told = match told {
        MotionKind::Velocity(twist) => twist.linear,
        MotionKind::Translate { distance, .. } => distance,
        MotionKind::Rotate { .. } | MotionKind::Stop => 0.0,
    };
    let along = if twist.linear.abs() > STANDS { twist.linear } else { told };
    if along < 0.0 { PI } else { 0.0 }
}

/// The speed that avoidance allows while the robot goes along `course` (rad off its heading); `None` if it has no objection to any.
///
/// Three rules for what lies within 67.5° of the direction of travel, of which the strictest holds:
///
/// 1. at or below the stop clearance: 0;
/// 2. within the slow zone, if it comes nearer by itself or contact is less than 2 s away: from the slow speed at the outer
///    edge down to 0 at the inner one;
/// 3. a threat that would reach the body within the halt time: 0.
///
/// And one for who comes from the side, so that they do not find the robot moving toward them: 0 if they are as good as here.
#[must_use]
pub fn caution(config: &AvoidanceConfig, surroundings: &Surroundings, course: f64) -> Option<f64> {
    let mut allowed: Option<f64> = None;
    let mut cap = |speed: f64| allowed = Some(allowed.map_or(speed, |other: f64| other.min(speed)));
    for near in surroundings.all() {
        let off = angle::turn(course, near.bearing).abs();
        let nearing = near.approach > config.approach_speed && near.came >= 0.6 * config.approach_distance;
        if off > IN_THE_WAY {
            if off < BESIDE && nearing && near.clearance < AT_HAND + REACTION * near.approach {
                cap(0.0);
            }
            continue;
        }
        if near.clearance <= config.stop_clearance {
            cap(0.0);
        } else if near.clearance < config.slow_clearance && (nearing || near.clearance < 2.0 * near.closing) {
            let share = (near.clearance - config.stop_clearance) / (config.slow_clearance - config.stop_clearance);
            cap(config.slow_speed * share);
        }
        if nearing && near.clearance < config.halt_time * near.closing {
            cap(0.0);
        }
    }
    allowed
}
