//! How far a round body can go along a circular arc before it touches something.
//!
//! The body is a disc of radius `R` about the origin of the robot frame. With twist `(v, ω)` its centre moves along a circle of
//! radius `ρ = v / ω` about `C = (0, ρ)`; to a point `P` at distance `q` from `C` it comes within `R` when
//!
//! ```text
//! cos Δ = (ρ² + q² − R²) / (2·ρ·q),    free = ρ·(α − Δ)
//! ```
//!
//! where `α` is the angle about `C` from the robot to `P` in the direction of travel. For `ω = 0` this becomes
//! `free = x − √(R² − y²)`. Driving backward is driving forward in a mirror.
//!
//! What already lies within `R` stops a motion towards it and never one away from it.

use nalgebra::{Point2, Vector2};
use orienteer_runtime::geometry::Twist;

/// Curves flatter than this, 1/m, count as straight.
const STRAIGHT: f64 = 1e-6;

/// The strip that the body sweeps if it keeps its twist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweptPath {
    /// 1 forward, −1 backward.
    direction: f64,
    /// 1 if the curve bends to the left of the robot frame, −1 to the right.
    side: f64,
    /// Radius of the centre's circle, m; infinite for a straight path.
    circle: f64,
    /// Radius of the body, m.
    body: f64,
}

impl SweptPath {
    /// The path of a body of radius `body`. `None` if it does not translate: a disc that turns sweeps nothing.
    #[must_use]
    pub fn new(twist: Twist, body: f64) -> Option<Self> {
        if twist.linear == 0.0 || !twist.is_finite() {
            return None;
        }
        let curvature = twist.angular / twist.linear;
        let circle = if curvature.abs() < STRAIGHT { f64::INFINITY } else { 1.0 / curvature.abs() };
        Some(Self { direction: twist.linear.signum(), side: curvature.signum(), circle, body })
    }

    /// Path length until the body touches `point` (robot frame); infinite if it never does.
    #[must_use]
    pub fn to_point(&self, point: Point2<f64>) -> f64 {
        let (x, y) = (self.direction * point.x, self.side * point.y);
        if x * x + y * y <= self.body * self.body {
            return if x > 0.0 { 0.0 } else { f64::INFINITY };
        }
        if self.circle.is_infinite() {
            return if x > 0.0 && y.abs() < self.body { x - (self.body * self.body - y * y).sqrt() } else { f64::INFINITY };
        }
        let rho = self.circle;
        let q = (x * x + (rho - y) * (rho - y)).sqrt();
        let cos = (rho * rho + q * q - self.body * self.body) / (2.0 * rho * q);
        if cos.is_nan() || cos.abs() > 1.0 {
            return f64::INFINITY;
        }
        rho * (x.atan2(rho - y) - cos.acos()).rem_euclid(std::f64::consts::TAU)
    }

    /// Path length until the body touches the straight wall of all points `p` with `normal · p = distance` (robot frame, `normal` of
    /// length 1 pointing from the robot to the wall); infinite if it never does.
    #[must_use]
    pub fn to_wall(&self, normal: Vector2<f64>, distance: f64) -> f64 {
        let (nx, ny) = (self.direction * normal.x, self.side * normal.y);
        let room = distance - self.body;
        if room <= 0.0 {
            return if nx > 0.0 { 0.0 } else { f64::INFINITY };
        }
        if self.circle.is_infinite() {
            return if nx > 0.0 { room / nx } else { f64::INFINITY };
        }
        // The centre's circle meets the wall's parallel at distance R where sin(θ − ψ) = room/ρ − n_y.
        let sin = room / self.circle - ny;
        if sin > 1.0 {
            return f64::INFINITY;
        }
        self.circle * (ny.atan2(nx) + sin.asin()).rem_euclid(std::f64::consts::TAU)
    }
}

#[cfg(test)]
mod tests {
    use orienteer_runtime::geometry::Pose;
    use proptest::prelude::*;

    use super::*;

    /// Walks the path in millimetres. `gap` is how far the body is from touching at a pose.
    fn walk(twist: Twist, length: f64, gap: impl Fn(Pose) -> f64) -> f64 {
        let step = 0.001;
        let turn = twist.angular / twist.linear * step * twist.linear.signum();
        for i in 0..(length / step) as usize {
            let s = i as f64;
            let pose = Pose::default().along_arc(step.copysign(twist.linear) * s, turn * s);
            if gap(pose) < 0.0 {
                return step * s;
            }
        }
        f64::INFINITY
    }

    fn twists() -> impl Strategy<Value = Twist> {
        (prop_oneof![Just(0.5), Just(-0.5)], prop_oneof![Just(0.0), -2.5..2.5f64]).prop_map(|(v, w)| Twist::new(v, w))
    }

    fn assert_same(found: f64, walked: f64, length: f64) -> Result<(), TestCaseError> {
        if found.is_finite() && found < length - 0.01 {
            prop_assert!((found - walked).abs() < 0.005, "{found} walked {walked}");
        } else if walked.is_finite() {
            prop_assert!((found - walked).abs() < 0.005 || walked > length - 0.02, "{found} walked {walked}");
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn the_way_to_a_point_is_the_way_walked(twist in twists(), x in -2.0..2.0f64, y in -2.0..2.0f64) {
            let point = Point2::new(x, y);
            let body = 0.3;
            prop_assume!(x.hypot(y) > body + 0.01);
            // Grazing contacts are ill-conditioned: the answer may jump by a whole way for a hair's breadth.
            let path = SweptPath::new(twist, body).unwrap_or(SweptPath { direction: 1.0, side: 1.0, circle: 1.0, body });
            let sure = [body - 1e-3, body + 1e-3].map(|r| SweptPath { body: r, ..path }.to_point(point));
            prop_assume!((sure[0] - sure[1]).abs() < 0.1 || sure[0] == sure[1]);
            let length = if twist.angular == 0.0 { 3.0 } else { (std::f64::consts::TAU * 0.5 / twist.angular.abs()).min(3.0) };
            let walked = walk(twist, length, |pose| pose.point().coords.metric_distance(&point.coords) - body);
            assert_same(path.to_point(point), walked, length)?;
        }

        #[test]
        fn the_way_to_a_wall_is_the_way_walked(twist in twists(), bearing in -3.0..3.0f64, distance in 0.32..2.0f64) {
            let normal = Vector2::new(bearing.cos(), bearing.sin());
            let body = 0.3;
            let path = SweptPath::new(twist, body).unwrap_or(SweptPath { direction: 1.0, side: 1.0, circle: 1.0, body });
            let sure = [body - 1e-3, body + 1e-3].map(|r| SweptPath { body: r, ..path }.to_wall(normal, distance));
            prop_assume!((sure[0] - sure[1]).abs() < 0.1 || sure[0] == sure[1]);
            let length = if twist.angular == 0.0 { 3.0 } else { (std::f64::consts::TAU * 0.5 / twist.angular.abs()).min(3.0) };
            let walked = walk(twist, length, |pose| distance - normal.dot(&pose.point().coords) - body);
            assert_same(path.to_wall(normal, distance), walked, length)?;
        }
    }

    #[test]
    fn what_touches_already_stops_only_a_motion_towards_it() {
        let ahead = Point2::new(0.2, 0.1);
        for (speed, expected) in [(0.5, 0.0), (-0.5, f64::INFINITY)] {
            for rate in [0.0, 1.0, -1.0] {
                let path = SweptPath::new(Twist::new(speed, rate), 0.3);
                assert_eq!(path.map(|path| path.to_point(ahead)), Some(expected));
            }
        }
        assert_eq!(SweptPath::new(Twist::new(0.0, 1.0), 0.3), None);
    }
}
