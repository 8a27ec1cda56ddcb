//! Which faults to inject, and when.

use orienteer_runtime::time::Time;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// All faults that a [`FaultInjector`](super::FaultInjector) knows. The default injects none.
#[derive(Debug, Clone, PartialEq)]
pub struct FaultConfig {
    /// Probability that one reading or scan is dropped.
    pub drop: f64,
    /// How late readings and scans come, s.
    pub delay: f64,
    /// When values stand still.
    pub freeze: Vec<Interval>,
    /// When odometry is not a number.
    pub not_a_number: Vec<Interval>,
    /// When nothing gets through in either direction.
    pub link_lost: Vec<Interval>,
    /// When the sonar says nothing.
    pub silent: Vec<Interval>,
    /// With the link lost, the base's own firmware stops it after so long, s.
    pub firmware_timeout: f64,
}

impl Default for FaultConfig {
    fn default() -> Self {
        BaseFaults::default().into()
    }
}

/// Which faults a base has, and when. The default is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BaseFaults {
    /// Probability that one reading is dropped.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub drop: f64,
    /// How late readings come, s.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub delay: f64,
    /// When values stand still.
    #[schemars(length(max = 64))]
    pub freeze: Vec<Interval>,
    /// When odometry is not a number.
    #[schemars(length(max = 64))]
    pub not_a_number: Vec<Interval>,
    /// When nothing gets through in either direction.
    #[schemars(length(max = 64))]
    pub link_lost: Vec<Interval>,
    /// With the link lost, the base's own firmware stops it after so long, s.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub firmware_timeout: f64,
}

impl Default for BaseFaults {
    fn default() -> Self {
        Self { drop: 0.0, delay: 0.0, freeze: Vec::new(), not_a_number: Vec::new(), link_lost: Vec::new(), firmware_timeout: 0.1 }
    }
}

impl From<BaseFaults> for FaultConfig {
    fn from(faults: BaseFaults) -> Self {
        let BaseFaults { drop, delay, freeze, not_a_number, link_lost, firmware_timeout } = faults;
        Self { drop, delay, freeze, not_a_number, link_lost, silent: Vec::new(), firmware_timeout }
    }
}

/// Which faults a sonar has, and when. The default is none.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SonarFaults {
    /// Probability that one scan is dropped.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub drop: f64,
    /// How late scans come, s.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub delay: f64,
    /// When ranges stand still.
    #[schemars(length(max = 64))]
    pub freeze: Vec<Interval>,
    /// When the link is lost, and it says so.
    #[schemars(length(max = 64))]
    pub link_lost: Vec<Interval>,
    /// When the sonar says nothing at all.
    #[schemars(length(max = 64))]
    pub silent: Vec<Interval>,
}

impl From<SonarFaults> for FaultConfig {
    fn from(faults: SonarFaults) -> Self {
        let SonarFaults { drop, delay, freeze, link_lost, silent } = faults;
        Self { drop, delay, freeze, link_lost, silent, ..Self::default() }
    }
}

/// From one time up to, not including, another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// Seconds since the start of the mission.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub from: f64,
    /// Seconds since the start of the mission.
    #[schemars(range(min = 0.0, max = 1e6), extend("x-above" = "from"))]
    pub to: f64,
}

impl Interval {
    fn holds(&self, now: Time) -> bool {
        (self.from..self.to).contains(&now.as_secs_f64())
    }
}

pub(super) fn in_any(intervals: &[Interval], now: Time) -> bool {
    intervals.iter().any(|interval| interval.holds(now))
}
