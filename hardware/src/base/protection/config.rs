//! The parameters of protection.

use orienteer_runtime::robot_model::Platform;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the base protects itself. It can't be switched off, but a base without sonar has to say so.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ProtectionConfig {
    /// The control period, s: for how long a permitted twist is held. The mission's control rate says it, no key of its own.
    #[serde(skip)]
    pub period: f64,
    /// For how long the base goes on before it heeds a new command, s.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub latency: f64,
    /// The share of the platform's deceleration that stops are planned with.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub braking_share: f64,
    /// Distance along the path that is left before contact, m.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub margin: f64,
    /// Added to the body's radius on all sides, m.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub clearance: f64,
    /// Whether the base may only drive where its sonar looks. False for a base without sonar: rules 8 and 9 are off.
    pub sonar_required: bool,
    /// Readings older than this, on top of two passes of the ring's own firing program, are stale, s.
    #[schemars(range(min = 0.05, max = 60.0))]
    pub max_sonar_age: f64,
    /// Transducers whose beams point within this angle of the direction of travel must not be stale, degrees.
    #[schemars(range(min = 1.0, max = 90.0))]
    pub look_half_angle_deg: f64,
    /// Speed that is permitted while the sonar is stale, m/s; 0 to stop.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub stale_speed: f64,
    /// Speed that is permitted where the ring has no transducer looking, m/s.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub blind_speed: f64,
    /// Speed at which the base may back off from a contact, m/s.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub back_off_speed: f64,
    /// Odometry older than this stops the base, s.
    #[schemars(range(min = 0.02, max = 60.0))]
    pub max_odometry_age: f64,
}

impl Default for ProtectionConfig {
    fn default() -> Self {
        Self {
            period: 0.05,
            latency: 0.0,
            braking_share: 0.8,
            margin: 0.03,
            clearance: 0.01,
            sonar_required: true,
            max_sonar_age: 0.5,
            look_half_angle_deg: 31.0,
            stale_speed: 0.0,
            blind_speed: 0.1,
            back_off_speed: 0.1,
            max_odometry_age: 0.5,
        }
    }
}

impl ProtectionConfig {
    /// For a base that heeds a command after up to so many seconds.
    #[must_use]
    pub fn for_a_base(self, latency: f64) -> Self {
        Self { latency: self.latency.max(latency), ..self }
    }

    /// The distance ahead within which a base must see to go at this speed (m/s), m: what it drives in a control period and its
    /// latency, brakes in, and leaves as a margin.
    #[must_use]
    pub fn stopping_distance(&self, platform: &Platform, speed: f64) -> f64 {
        speed * (self.period + self.latency) + speed * speed / (2.0 * self.braking_share * platform.acceleration) + self.margin
    }

    /// What can't be, if anything is: a NaN among these numbers would make everything look free.
    #[must_use]
    pub fn flaw(&self) -> Option<String> {
        let numbers = [
            ("latency", self.latency),
            ("braking_share", self.braking_share),
            ("margin", self.margin),
            ("clearance", self.clearance),
            ("max_sonar_age", self.max_sonar_age),
            ("look_half_angle_deg", self.look_half_angle_deg),
            ("stale_speed", self.stale_speed),
            ("blind_speed", self.blind_speed),
            ("back_off_speed", self.back_off_speed),
            ("max_odometry_age", self.max_odometry_age),
        ];
        let wrong = numbers.into_iter().find(|(_, number)| !(number.is_finite() && *number >= 0.0));
        let wrong = wrong.or((self.braking_share == 0.0).then_some(("braking_share", 0.0)));
        wrong.map(|(name, number)| format!("`{name}` of the base's protection is {number}"))
    }
}
