//! Positions and headings in the plane.

use std::f64::consts::PI;

use iceoryx2::prelude::ZeroCopySend;
use nalgebra::{Point2, Rotation2, Vector2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Twist, angle};

/// A position and heading in the plane: an element of SE(2).
///
/// ```
/// use orienteer_runtime::geometry::Pose;
/// let robot = Pose::new(1.0, 2.0, std::f64::consts::FRAC_PI_2);
/// let ahead = robot.then(Pose::new(0.5, 0.0, 0.0));
/// assert!((ahead.y - 2.5).abs() < 1e-12);
/// assert!((robot.between(ahead).x - 0.5).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::Pose.v1")]
pub struct Pose {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians, counter-clockwise from the x axis, in `(-π, π]`.
    pub heading: f64,
}

impl Pose {
    /// A pose from metres and radians; the heading is wrapped.
    #[must_use]
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        Self { x, y, heading: angle::wrap(heading) }
    }

    /// The position alone.
    #[must_use]
    pub fn point(&self) -> Point2<f64> {
        Point2::new(self.x, self.y)
    }

    /// Unit vector along the heading.
    #[must_use]
    pub fn direction(&self) -> Vector2<f64> {
        let (sin, cos) = self.heading.sin_cos();
        Vector2::new(cos, sin)
    }

    /// `self ∘ local`: where `local`, given in the frame of `self`, lies in the frame in which `self` is given.
    #[must_use]
    pub fn then(&self, local: Pose) -> Pose {
        let at = self.transform(local.point());
        Pose::new(at.x, at.y, self.heading + local.heading)
    }

    /// The pose that undoes this one: `p.then(p.inverse())` is the origin.
    #[must_use]
    pub fn inverse(&self) -> Pose {
        let (sin, cos) = self.heading.sin_cos();
        Pose::new(-self.x * cos - self.y * sin, self.x * sin - self.y * cos, -self.heading)
    }

    /// `other` as seen from `self`: the solution `d` of `self.then(d) == other`.
    #[must_use]
    pub fn between(&self, other: Pose) -> Pose {
        self.inverse().then(other)
    }

    /// A point of this pose's frame, in the frame in which the pose is given.
    #[must_use]
    pub fn transform(&self, local: Point2<f64>) -> Point2<f64> {
        self.point() + Rotation2::new(self.heading) * local.coords
    }

    /// Moves along a circular arc of length `distance` (m) while the heading turns by `turn` (rad).
    ///
    /// The arc is exact (MacPherson 1993, §3); a chord would shorten every curve.
    #[must_use]
    pub fn along_arc(&self, distance: f64, turn: f64) -> Pose {
        let half = 0.5 * turn;
        // sin(h)/h, with its series where the quotient loses digits
        let shrink = if half.abs() < 1e-4 { 1.0 - half * half / 6.0 } else { half.sin() / half };
        let (sin, cos) = (self.heading + half).sin_cos();
        let chord = distance * shrink;
        Pose::new(self.x + chord * cos, self.y + chord * sin, self.heading + turn)
    }

    /// Where a body with this constant twist is after `seconds`.
    #[must_use]
    pub fn after(&self, twist: Twist, seconds: f64) -> Pose {
        self.along_arc(twist.linear * seconds, twist.angular * seconds)
    }

    /// The pose a share `t` in `[0, 1]` of the way to `end`, along the arc of constant twist that joins them.
    #[must_use]
    pub fn interpolate(&self, end: Pose, t: f64) -> Pose {
        let delta = self.between(end);
        let half = 0.5 * delta.heading;
        let stretch = if half.abs() < 1e-4 { 1.0 + half * half / 6.0 } else { half / half.sin() };
        let chord = delta.x.hypot(delta.y);
        // A synchro base may slide along a direction other than its heading, so follow the chord's bearing.
        let bearing = if chord > 0.0 { delta.y.atan2(delta.x) - half } else { 0.0 };
        let length = chord * stretch * t;
        let turned = delta.heading * t;
        let part = Pose::new(0.0, 0.0, bearing).along_arc(length, turned);
        self.then(Pose::new(part.x, part.y, turned))
    }

    /// Straight-line distance between the two positions, in metres.
    #[must_use]
    pub fn distance(&self, other: &Pose) -> f64 {
        nalgebra::distance(&self.point(), &other.point())
    }

    /// Bearing of a point as seen from this pose, in `(-π, π]`; positive is to the left.
    #[must_use]
    pub fn bearing_of(&self, point: Point2<f64>) -> f64 {
        angle::turn(self.heading, (point.y - self.y).atan2(point.x - self.x))
    }

    /// True if every number is finite and the heading is within `[-π, π]`.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.heading.abs() <= PI
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn poses() -> impl Strategy<Value = Pose> {
        (-50.0..50.0, -50.0..50.0, -PI..PI).prop_map(|(x, y, heading)| Pose::new(x, y, heading))
    }

    fn assert_close(a: Pose, b: Pose) {
        assert!(a.distance(&b) < 1e-9 && angle::turn(a.heading, b.heading).abs() < 1e-9, "{a:?} is not {b:?}");
    }

    proptest! {
        #[test]
        fn composition_is_a_group(a in poses(), b in poses(), c in poses()) {
            assert_close(a.then(a.inverse()), Pose::default());
            assert_close(a.then(b).then(c), a.then(b.then(c)));
            assert_close(a.then(a.between(b)), b);
        }

        #[test]
        fn an_arc_agrees_with_ten_thousand_small_chords(v in -1.0..1.0f64, w in -2.0..2.0f64) {
            let twist = Twist::new(v, w);
            let mut walked = Pose::default();
            let step = 1e-4;
            for _ in 0..10_000 {
                let heading = walked.heading + 0.5 * w * step;
                walked = Pose::new(walked.x + v * step * heading.cos(), walked.y + v * step * heading.sin(), walked.heading + w * step);
            }
            let arc = Pose::default().after(twist, 1.0);
            prop_assert!(arc.distance(&walked) < 1e-7);
        }

        #[test]
        fn interpolation_follows_the_arc(a in poses(), v in -1.0..1.0f64, w in -2.0..2.0f64, t in 0.0..1.0f64) {
            let twist = Twist::new(v, w);
            assert_close(a.interpolate(a.after(twist, 1.0), t), a.after(twist, t));
        }
    }
}
