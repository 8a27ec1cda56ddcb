//! The frame in which Randazza (1989) describes a place, and the frame of the world.
//!
//! Hers begins at the *start pose*, where the robot stops before it explores a place: x to the right, y forward, centimetres,
//! angles in degrees, clockwise from straight ahead. The near line of the place is at y = 8, because the foremost sonar is
//! then level with the corner and sits 8 cm before the robot's centre.

use nalgebra::Point2;
use orienteer_runtime::geometry::Pose;

/// How far before the near line of a place a robot starts to explore it, m.
pub const NEAR_LINE: f64 = 0.08;

/// The frame that begins at a start pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HypothesisFrame {
    start: Pose,
}

impl HypothesisFrame {
    /// The frame of a robot that starts here to explore a place.
    #[must_use]
    pub const fn new(start: Pose) -> Self {
        Self { start }
    }

    /// A point of this frame (cm) in the world (m).
    ///
    /// ```
    /// use orienteer_hardware::world::floors::HypothesisFrame;
    /// use orienteer_runtime::geometry::Pose;
    /// let frame = HypothesisFrame::new(Pose::new(10.0, 5.0, 0.0));
    /// let corner = frame.point(56.0, 8.0);
    /// assert!((corner.x - 10.08).abs() < 1e-12 && (corner.y - 4.44).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn point(&self, right: f64, forward: f64) -> Point2<f64> {
        self.start.transform(Point2::new(0.01 * forward, -0.01 * right))
    }

    /// A pose of this frame (cm, degrees clockwise) in the world (m, radians counter-clockwise).
    #[must_use]
    pub fn pose(&self, right: f64, forward: f64, clockwise_deg: f64) -> Pose {
        self.start.then(Pose::new(0.01 * forward, -0.01 * right, -clockwise_deg.to_radians()))
    }

    /// Where a point of the world (m) lies in this frame: right and forward, cm.
    #[must_use]
    pub fn from_world(&self, point: Point2<f64>) -> [f64; 2] {
        let local = self.start.between(Pose::new(point.x, point.y, 0.0));
        [-100.0 * local.y, 100.0 * local.x]
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_quarter_turn_to_the_right_is_positive() {
        let port = HypothesisFrame::new(Pose::default()).pose(64.0, 64.0, 90.0);
        assert!((port.x - 0.64).abs() < 1e-12 && (port.y + 0.64).abs() < 1e-12);
        assert!((port.heading + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn there_and_back(x in -50.0..50.0, y in -50.0..50.0, heading in -3.0..3.0, right in -300.0..300.0, ahead in -300.0..300.0) {
            let frame = HypothesisFrame::new(Pose::new(x, y, heading));
            let [r, a] = frame.from_world(frame.point(right, ahead));
            prop_assert!((r - right).abs() < 1e-9 && (a - ahead).abs() < 1e-9);
        }
    }
}
