//! Angles in radians.

use std::f64::consts::{PI, TAU};

/// The same direction in `(-π, π]`.
///
/// ```
/// use orienteer_runtime::geometry::angle::wrap;
/// assert!((wrap(3.5 * std::f64::consts::PI) + 0.5 * std::f64::consts::PI).abs() < 1e-12);
/// assert_eq!(wrap(-std::f64::consts::PI), std::f64::consts::PI);
/// ```
#[must_use]
pub fn wrap(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    let turned = angle.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

/// The turn in `(-π, π]` that leads from heading `from` to heading `to`; positive is counter-clockwise.
#[must_use]
pub fn turn(from: f64, to: f64) -> f64 {
    wrap(to - from)
}
