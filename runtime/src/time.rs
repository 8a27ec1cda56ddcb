//! Points in time.
//!
//! A [`Time`] counts nanoseconds since the start of the mission. In lockstep it advances by whole control periods, at wall
//! time it follows the machine's monotonic clock; only the fleet's clock decides. Behaviours and drivers are told the time,
//! they never ask for it.

use std::{
    fmt,
    ops::{Add, Sub},
    time::Duration,
};

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Nanoseconds since the start of the mission.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[serde(transparent)]
#[type_name("orienteer::Time.v1")]
pub struct Time(u64);

impl Time {
    /// The start of the mission.
    pub const START: Self = Self(0);
    /// Later than any other time.
    pub const FAR: Self = Self(u64::MAX);

    /// A time from nanoseconds since the start.
    #[must_use]
    pub const fn from_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    /// A time from seconds since the start; anything negative or not finite is the start.
    #[must_use]
    pub fn from_secs_f64(seconds: f64) -> Self {
        Self((seconds * 1e9).round() as u64)
    }

    /// Nanoseconds since the start.
    #[must_use]
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// Seconds since the start.
    #[must_use]
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Time passed since `earlier`; zero if `earlier` is later.
    #[must_use]
    pub fn since(self, earlier: Time) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }

    /// The same moment for somebody whose time began so many nanoseconds earlier; one before their start is their start, and
    /// [`Time::FAR`] is as far for everybody.
    #[must_use]
    pub fn shifted(self, earlier: i64) -> Time {
        if self == Self::FAR { self } else { Self(self.0.saturating_add_signed(earlier)) }
    }

    /// Seconds passed since `earlier`; zero if `earlier` is later.
    #[must_use]
    pub fn secs_since(self, earlier: Time) -> f64 {
        self.since(earlier).as_secs_f64()
    }
}

impl Add<Duration> for Time {
    type Output = Time;

    fn add(self, span: Duration) -> Time {
        Time(self.0.saturating_add(u64::try_from(span.as_nanos()).unwrap_or(u64::MAX)))
    }
}

impl Sub<Duration> for Time {
    type Output = Time;

    fn sub(self, span: Duration) -> Time {
        Time(self.0.saturating_sub(u64::try_from(span.as_nanos()).unwrap_or(u64::MAX)))
    }
}

impl fmt::Display for Time {
    /// Minutes, seconds and milliseconds: `3:07.250`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let millis = self.0 / 1_000_000;
        write!(f, "{}:{:02}.{:03}", millis / 60_000, millis / 1000 % 60, millis % 1000)
    }
}
