//! Velocities, and limits on them.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A body velocity: along the heading and about the vertical axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::Twist.v1")]
pub struct Twist {
    /// Metres per second along the heading; negative is backward.
    pub linear: f64,
    /// Radians per second, counter-clockwise.
    pub angular: f64,
}

impl Twist {
    /// Standing still.
    pub const STOP: Self = Self { linear: 0.0, angular: 0.0 };

    /// A twist from m/s and rad/s.
    #[must_use]
    pub const fn new(linear: f64, angular: f64) -> Self {
        Self { linear, angular }
    }

    /// True if neither number is NaN or infinite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.angular.is_finite()
    }

    /// True if the body stands still.
    #[must_use]
    pub fn is_stop(&self) -> bool {
        self.linear == 0.0 && self.angular == 0.0
    }

    /// The same curve driven slowly enough for both limits: linear and angular shrink by one factor, so that the path
    /// keeps its shape. A twist that is not finite becomes [`Twist::STOP`].
    ///
    /// ```
    /// use orienteer_runtime::geometry::{Limits, Twist};
    /// let capped = Twist::new(1.0, 0.5).within(Limits { linear: 0.5, angular: 2.0 });
    /// assert_eq!(capped, Twist::new(0.5, 0.25));
    /// ```
    #[must_use]
    pub fn within(&self, limits: Limits) -> Twist {
        if !self.is_finite() {
            return Twist::STOP;
        }
        // A limit that is NaN counts as zero.
        let limits = limits.and(Limits::NONE);
        let share = |value: f64, limit: f64| if value.abs() > limit { limit / value.abs() } else { 1.0 };
        let factor = share(self.linear, limits.linear).min(share(self.angular, limits.angular));
        Twist::new(self.linear * factor, self.angular * factor)
    }
}

/// Upper bounds on the magnitude of a [`Twist`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::Limits.v1")]
pub struct Limits {
    /// Largest speed, m/s.
    pub linear: f64,
    /// Largest turn rate, rad/s.
    pub angular: f64,
}

impl Limits {
    /// No bound at all.
    pub const NONE: Self = Self { linear: f64::MAX, angular: f64::MAX };

    /// The tighter of each bound. A bound that is NaN or negative counts as zero: fail toward standing still.
    #[must_use]
    pub fn and(&self, other: Limits) -> Limits {
        Limits { linear: tighter(self.linear, other.linear), angular: tighter(self.angular, other.angular) }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::NONE
    }
}

fn tighter(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { 0.0 } else { a.min(b).max(0.0) }
}
