//! How dead reckoning errs.
//!
//! A simulated base knows how it truly moved; its odometry must not. Following MacPherson (1993, ch. IX), the error has a
//! systematic part, which calibration could remove, and a random part, which it could not:
//!
//! ```text
//! measured distance = |true| / (1 + scale) + σ_d·√|distance|·N(0, 1)
//! measured turn     =  true  / (1 + e(v)) − drift·distance + σ_θ·√|turn|·N(0, 1) + σ_b·√|distance|·N(0, 1)
//! ```
//!
//! Random errors grow with the root of the way, so that a way driven in a thousand steps errs as much as in one. `e(v)` is the
//! turn excess of MacPherson's table 9.2, read as the mean heading correction per lap of one full turn:
//!
//! | v, m/s | 0.10 | 0.15 | 0.20 | 0.25 | 0.30 |
//! |---|---|---|---|---|---|
//! | e | 0.00032 | 0.00072 | 0.00134 | 0.00282 | 0.00266 |
//!
//! Encoders count whole steps; what is left over is counted later, never lost. Velocity is what was counted in the last
//! [`GATE`], as a drive measures it: a way divided by the time between two looks at it, however short, would be noise.

use orienteer_runtime::{
    geometry::{Pose, Twist},
    time::Time,
    topics::{Odometry, flags},
};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The error of a base's odometry. The default is Yamabico-11's (MacPherson 1993).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OdometryConfig {
    /// The base truly drives this much farther than measured, as a share of the distance.
    #[schemars(range(min = -0.5, max = 0.5))]
    pub scale: f64,
    /// The base truly turns this much farther than measured, as a share of the turn, by speed. Interpolated linearly; the first
    /// and the last row hold beyond them. In order of speed.
    #[schemars(length(max = 32))]
    pub turn_excess: Vec<TurnExcess>,
    /// The base truly veers to the left by so much per metre, unseen by the encoders (unequal wheels), rad/m.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub drift: f64,
    /// Standard deviation of the measured distance after one metre, m; grows with the root of the distance.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub distance_noise: f64,
    /// Standard deviation of the measured turn after one radian of turning, rad; grows with the root of the turn.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub turn_noise: f64,
    /// Standard deviation of the measured heading after one metre of driving, rad; grows with the root of the distance.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub drift_noise: f64,
    /// Distance of one encoder step, m; 0 for none.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub distance_step: f64,
    /// Turn of one encoder step, rad; 0 for none. For a differential base, `distance_step / tread`.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub turn_step: f64,
}

/// One row of [`OdometryConfig::turn_excess`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurnExcess {
    /// Speed, m/s.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub speed: f64,
    /// True turn / measured turn − 1.
    #[schemars(range(min = -0.5, max = 0.5))]
    pub excess: f64,
}

impl Default for OdometryConfig {
    fn default() -> Self {
        let rows = [(0.10, 0.00032), (0.15, 0.00072), (0.20, 0.00134), (0.25, 0.00282), (0.30, 0.00266)];
        Self {
            scale: 0.002,
            turn_excess: rows.into_iter().map(|(speed, excess)| TurnExcess { speed, excess }).collect(),
            drift: 0.0,
            // 0.4 cm per lap of 9.14 m, and 0.0089 rad per lap of one turn
            distance_noise: 0.004 / 9.14f64.sqrt(),
            turn_noise: 0.0089 / std::f64::consts::TAU.sqrt(),
            drift_noise: 0.0,
            distance_step: 0.0,
            turn_step: 0.0,
        }
    }
}

impl OdometryConfig {
    /// Odometry without any error.
    #[must_use]
    pub fn exact() -> Self {
        Self {
            scale: 0.0,
            turn_excess: Vec::new(),
            drift: 0.0,
            distance_noise: 0.0,
            turn_noise: 0.0,
            drift_noise: 0.0,
            distance_step: 0.0,
            turn_step: 0.0,
        }
    }

    /// `e(v)`.
    #[must_use]
    pub fn excess_at(&self, speed: f64) -> f64 {
        let speed = speed.abs();
        let rows = &self.turn_excess;
        let above = rows.partition_point(|row| row.speed <= speed);
        match (above.checked_sub(1).and_then(|i| rows.get(i)), rows.get(above)) {
            (Some(low), Some(high)) => low.excess + (high.excess - low.excess) * (speed - low.speed) / (high.speed - low.speed),
            (Some(only), None) | (None, Some(only)) => only.excess,
            (None, None) => 0.0,
        }
    }
}

/// The time over which velocity is measured, s.
pub const GATE: f64 = 0.01;

/// Counts what the encoders of a simulated base see.
#[derive(Debug, Clone)]
pub struct Odometer {
    config: OdometryConfig,
    distance: Encoder,
    turn: Encoder,
    state: Odometry,
    /// Time, distance and turn counted since the gate opened.
    counted: (f64, f64, f64),
}

/// One shaft: a real position, and the whole steps of it that have been reported.
#[derive(Debug, Clone, Copy)]
struct Encoder {
    step: f64,
    position: f64,
    counted: f64,
}

impl Encoder {
    fn new(step: f64) -> Self {
        Self { step, position: 0.0, counted: 0.0 }
    }

    /// Turns on by `way`; what newly counts of it.
    fn turn_on(&mut self, way: f64) -> f64 {
        if self.step <= 0.0 {
            return way;
        }
        self.position += way / self.step;
        let steps = self.position.round() - self.counted;
        self.counted += steps;
        steps * self.step
    }
}

impl Odometer {
    /// Starts at the origin of the odometry frame, at rest.
    #[must_use]
    pub fn new(config: OdometryConfig) -> Self {
        let (distance, turn) = (Encoder::new(config.distance_step), Encoder::new(config.turn_step));
        let state = Odometry { flags: flags::ENABLED, ..Odometry::default() };
        Self { config, distance, turn, state, counted: (0.0, 0.0, 0.0) }
    }

    /// What it has measured so far.
    #[must_use]
    pub fn state(&self) -> &Odometry {
        &self.state
    }

    /// Measures a true step of `distance` m and `turn` rad that took `seconds` and ended `now`.
    ///
    /// The step should be short enough to be one arc. `rng` is drawn from a fixed number of times, so that noise that is
    /// switched off leaves the other noise as it was.
    pub fn measure(&mut self, now: Time, distance: f64, turn: f64, seconds: f64, rng: &mut impl Rng) -> Odometry {
        let [n_distance, n_turn, n_drift]: [f64; 3] = std::array::from_fn(|_| rng.sample(StandardNormal));
        let config = &self.config;
        let speed = if seconds > 0.0 { distance / seconds } else { 0.0 };
        let root = distance.abs().sqrt();
        let seen_distance = distance / (1.0 + config.scale) + config.distance_noise * root * n_distance;
        let seen_turn = turn / (1.0 + config.excess_at(speed)) - config.drift * distance
            + config.turn_noise * turn.abs().sqrt() * n_turn
            + config.drift_noise * root * n_drift;
        self.count(now, seen_distance, seen_turn, seconds)
    }

    fn count(&mut self, now: Time, distance: f64, turn: f64, seconds: f64) -> Odometry {
        let (distance, turn) = (self.distance.turn_on(distance), self.turn.turn_on(turn));
        let state = &mut self.state;
        state.stamp = now;
        state.pose = state.pose.along_arc(distance, turn);
        state.travelled += distance.abs();
        state.turned += turn;
        let (time, way, angle) = (self.counted.0 + seconds, self.counted.1 + distance, self.counted.2 + turn);
        // A gate of ten steps of a millisecond, summed, must not be one short.
        let full = time >= GATE - 1e-9;
        if full {
            state.twist = Twist::new(way / time, angle / time);
        }
        self.counted = if full { (0.0, 0.0, 0.0) } else { (time, way, angle) };
        *state
    }

    /// Moves the origin so that the measured pose is `pose` from now on.
    pub fn set_pose(&mut self, pose: Pose) {
        self.state.pose = pose;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::time::Duration;

    use orienteer_runtime::random::Streams;
    use proptest::prelude::*;

    use super::*;

    /// Drives `steps` equal steps `runs` times; distance and turn measured in each run.
    fn runs(config: &OdometryConfig, runs: usize, steps: usize, distance: f64, turn: f64) -> Vec<(f64, f64)> {
        let mut rng = Streams::new(11).stream("ann", "odometry");
        (0..runs)
            .map(|_| {
                let mut odometer = Odometer::new(config.clone());
                let mut measured = 0.0;
                for i in 0..steps {
                    let now = Time::START + Duration::from_millis(50 * i as u64);
                    let odometry = odometer.measure(now, distance, turn, 0.05, &mut rng);
                    measured += odometry.twist.linear * 0.05;
                }
                (measured, odometer.state().turned)
            })
            .collect()
    }

    fn mean_and_variance(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
        let n = values.clone().count() as f64;
        let mean = values.clone().sum::<f64>() / n;
        (mean, values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0))
    }

    /// `(n − 1)·s² / σ²` is chi-square with n − 1 degrees of freedom: mean n − 1, variance 2(n − 1). Five of its standard
    /// deviations to either side; the mean lies within five of its own.
    fn assert_normal(values: impl Iterator<Item = f64> + Clone, mean: f64, sigma: f64) {
        let n = values.clone().count() as f64;
        let (found, variance) = mean_and_variance(values);
        assert!((found - mean).abs() < 5.0 * sigma / n.sqrt(), "mean {found}, expected {mean}");
        let chi_square = (n - 1.0) * variance / (sigma * sigma);
        assert!((chi_square - (n - 1.0)).abs() < 5.0 * (2.0 * (n - 1.0)).sqrt(), "{chi_square} of {}", n - 1.0);
    }

    #[test]
    fn long_runs_spread_as_configured_however_they_are_cut_into_steps() {
        let config = OdometryConfig { scale: 0.002, turn_excess: vec![], drift_noise: 0.002, ..OdometryConfig::default() };
        for steps in [10, 400] {
            let way = 9.14 / steps as f64;
            let turn = std::f64::consts::TAU / steps as f64;
            let found = runs(&config, 400, steps, way, turn);
            assert_normal(found.iter().map(|run| run.0), 9.14 / 1.002, 0.004);
            let sigma = 0.0089f64.hypot(0.002 * 9.14f64.sqrt());
            assert_normal(found.iter().map(|run| run.1), std::f64::consts::TAU, sigma);
        }
    }

    #[test]
    fn the_table_is_interpolated_and_held_at_its_ends() {
        let config = OdometryConfig::default();
        assert_eq!(config.excess_at(0.0), 0.00032);
        assert_eq!(config.excess_at(-0.25), 0.00282);
        assert_eq!(config.excess_at(1.0), 0.00266);
        assert!((config.excess_at(0.125) - 0.00052).abs() < 1e-12);
        assert_eq!(OdometryConfig::exact().excess_at(0.3), 0.0);
    }

    /// MacPherson's table 9.2: after a lap of one turn at 25 cm/s the heading is short by 0.0177 rad.
    #[test]
    fn a_lap_is_wrong_by_what_the_table_says() {
        let config = OdometryConfig { turn_excess: OdometryConfig::default().turn_excess, ..OdometryConfig::exact() };
        let found = runs(&config, 1, 731, 9.1375 / 731.0, std::f64::consts::TAU / 731.0);
        assert!((std::f64::consts::TAU - found[0].1 - 0.0177).abs() < 1e-4, "{}", found[0].1);
    }

    /// A base that is read whenever its readers like still has encoders that need time to count.
    #[test]
    fn a_velocity_is_measured_over_a_time_in_which_there_is_something_to_count() {
        let mut rng = Streams::new(3).stream("ann", "odometry");
        let mut odometer = Odometer::new(OdometryConfig::default());
        let (mut now, mut sum, mut farthest) = (Time::START, 0.0, 0.0f64);
        for i in 0..4000 {
            let seconds = if i % 2 == 0 { 2e-6 } else { 0.01 - 2e-6 };
            now = now + Duration::from_secs_f64(seconds);
            let measured = odometer.measure(now, 0.3 * seconds, 0.2 * seconds, seconds, &mut rng).twist;
            // Nothing is measured before the first gate is full.
            if i > 0 {
                sum += measured.linear;
                farthest = farthest.max((measured.linear - 0.3).abs());
            }
        }
        assert!((sum / 3999.0 - 0.3).abs() < 0.005, "{}", sum / 3999.0);
        assert!(farthest < 0.1, "off by {farthest} m/s");
    }

    #[test]
    fn drift_is_unseen_by_the_encoders() {
        let config = OdometryConfig { drift: 0.01, ..OdometryConfig::exact() };
        let found = runs(&config, 1, 100, 0.1, 0.001);
        assert!(found[0].1.abs() < 1e-12, "a curve to the left that the base does not know of");
    }

    proptest! {
        #[test]
        fn whole_steps_are_counted_and_none_is_lost(
            ways in prop::collection::vec((-0.02..0.02f64, -0.02..0.02f64), 1..300), step in 0.0005..0.01f64
        ) {
            let config = OdometryConfig { distance_step: step, turn_step: step, ..OdometryConfig::exact() };
            let mut odometer = Odometer::new(config);
            let mut rng = Streams::new(0).stream("ann", "odometry");
            let (mut true_distance, mut distance, mut true_turn) = (0.0, 0.0, 0.0);
            for (way, turn) in ways {
                let odometry = odometer.measure(Time::START, way, turn, 0.01, &mut rng);
                distance += odometry.twist.linear * 0.01;
                true_distance += way;
                true_turn += turn;
                prop_assert!((distance - true_distance).abs() <= 0.5 * step + 1e-9);
                prop_assert!((odometry.turned - true_turn).abs() <= 0.5 * step + 1e-9);
                let steps = distance / step;
                prop_assert!((steps - steps.round()).abs() < 1e-6);
            }
        }

        #[test]
        fn exact_odometry_is_the_truth(ways in prop::collection::vec((-0.1..0.1f64, -0.2..0.2f64), 1..50)) {
            let mut odometer = Odometer::new(OdometryConfig::exact());
            let mut rng = Streams::new(0).stream("ann", "odometry");
            let mut pose = Pose::default();
            for (way, turn) in ways {
                pose = pose.along_arc(way, turn);
                odometer.measure(Time::START, way, turn, 0.05, &mut rng);
            }
            prop_assert!(odometer.state().pose.distance(&pose) < 1e-12);
        }
    }
}
