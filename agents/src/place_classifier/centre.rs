//! Where the middle of the corridor is, by one ring of the sonar.
//!
//! Wheels slip, and turns most of all: after a few minutes of going round corners a robot that goes back to where it thinks it started stands
//! beside it. The walls beside the start pose tell by how much.

use orienteer_runtime::geometry::Pose;

use crate::{clock_ring::ClockRing, places::Reckoning};

/// Directly to the left and to the right, in clock order.
const LEFT: usize = 12;
const RIGHT: usize = 4;
/// Two walls are those of the corridor if they are as far from each other as they should be, within this, m.
const FITS: f64 = 0.12;
/// One wall is that of the corridor if it is no farther off where it should be, m.
const NEAR: f64 = 0.20;
/// A start pose is not moved farther, m.
const MOST: f64 = 0.25;

/// How far to the left of the corridor's middle the robot is, m; `None` if neither wall is where it should be.
fn left_of_middle(ring: &ClockRing, reckoning: &Reckoning) -> Option<f64> {
    let half = 0.5 * reckoning.width;
    let [left, right] = [LEFT, RIGHT].map(|direction| ring[direction] + reckoning.face);
    if (left + right - reckoning.width).abs() < FITS {
        return Some(0.5 * (right - left));
    }
    match ((left - half).abs() < NEAR, (right - half).abs() < NEAR) {
        (true, false) => Some(half - left),
        (false, true) => Some(right - half),
        _ => None,
    }
}

/// The start pose, moved across to where the walls have the middle of the corridor. The robot stands `here` and hears this ring.
#[must_use]
pub fn centred(start: Pose, here: Pose, ring: &ClockRing, reckoning: &Reckoning) -> Pose {
    let Some(truly) = left_of_middle(ring, reckoning) else { return start };
    let across = start.between(here).y - truly;
    if across.abs() > MOST { start } else { start.then(Pose::new(0.0, across, 0.0)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock_ring::DIRECTIONS;

    const HUEY: Reckoning = Reckoning { width: 1.12, face: 0.08 };

    fn ring(left: f64, right: f64) -> ClockRing {
        let mut ring = [7.77; DIRECTIONS];
        (ring[LEFT], ring[RIGHT]) = (left, right);
        ring
    }

    #[test]
    fn walls_say_where_the_middle_is() {
        // The robot thinks that it is at the start pose, and stands 10 cm to the left of the middle.
        let start = Pose::new(3.0, 2.0, std::f64::consts::FRAC_PI_2);
        for heard in [ring(0.38, 0.58), ring(0.38, 4.0), ring(4.0, 0.58)] {
            let moved = centred(start, start, &heard, &HUEY);
            assert!((moved.x - 3.1).abs() < 1e-9 && (moved.y - 2.0).abs() < 1e-9, "{moved:?}");
        }
    }

    #[test]
    fn walls_that_are_none_of_the_corridors_say_nothing() {
        for heard in [ring(3.0, 4.0), ring(0.1, 4.0)] {
            assert_eq!(centred(Pose::default(), Pose::default(), &heard, &HUEY), Pose::default());
        }
    }
}
