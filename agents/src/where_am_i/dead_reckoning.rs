//! Dead reckoning with covariance, along arcs.

use nalgebra::{Matrix3, Vector3};
use orienteer_runtime::{
    geometry::Pose,
    topics::{Odometry, PoseEstimate},
};

use super::WhereAmIConfig;

/// A pose that follows odometry, and how far it can be trusted.
#[derive(Debug, Clone)]
pub struct DeadReckoning {
    config: WhereAmIConfig,
    covariance: Matrix3<f64>,
    last: Option<Odometry>,
    estimate: PoseEstimate,
}

impl DeadReckoning {
    /// Starts at `start` (map frame) with certainty.
    #[must_use]
    pub fn new(config: WhereAmIConfig, start: Pose) -> Self {
        let estimate = PoseEstimate { pose: start, ..PoseEstimate::default() };
        Self { config, covariance: Matrix3::zeros(), last: None, estimate }
    }

    /// Takes the next reading of the odometry. Readings that are not finite, or older than the last, are passed over.
    ///
    /// The odometry's own pose gives the displacement; where the odometry was started does not matter.
    pub fn update(&mut self, odometry: &Odometry) {
        if !odometry.pose.is_sound() || self.last.is_some_and(|last| odometry.stamp < last.stamp) {
            return;
        }
        if let Some(last) = self.last {
            let moved = last.pose.between(odometry.pose);
            self.grow(&moved);
            self.estimate.pose = self.estimate.pose.then(moved);
            self.estimate.travelled += (odometry.travelled - last.travelled).max(0.0);
        }
        self.estimate.stamp = odometry.stamp;
        self.last = Some(*odometry);
    }

    /// The estimate after the last reading.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        let mut estimate = self.estimate;
        // Row by row; the matrix is symmetric, so the storage order does not matter.
        estimate.covariance.copy_from_slice(self.covariance.as_slice());
        estimate
    }

    fn grow(&mut self, moved: &Pose) {
        let heading = self.estimate.pose.heading + 0.5 * moved.heading;
        let (sin, cos) = heading.sin_cos();
        // Along the chord; its sign tells forward from backward.
        let distance = moved.x.hypot(moved.y) * moved.x.signum();
        let jacobian = Matrix3::new(1.0, 0.0, -distance * sin, 0.0, 1.0, distance * cos, 0.0, 0.0, 1.0);
        let along = Vector3::new(cos, sin, 0.0);
        let config = &self.config;
        self.covariance = jacobian * self.covariance * jacobian.transpose()
            + along * along.transpose() * (config.distance_error * distance).powi(2);
        self.covariance[(2, 2)] += (config.drift * distance).powi(2) + (config.turn_error * moved.heading).powi(2);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};

    use orienteer_runtime::{geometry::Twist, time::Time};
    use proptest::prelude::*;

    use super::*;

    fn drive(reckoning: &mut DeadReckoning, twists: &[(Twist, f64)], started: Pose) {
        let mut odometry = Odometry { pose: started, ..Odometry::default() };
        reckoning.update(&odometry);
        for (n, (twist, seconds)) in twists.iter().enumerate() {
            odometry.stamp = Time::from_secs_f64(1.0 + n as f64);
            odometry.pose = odometry.pose.after(*twist, *seconds);
            odometry.travelled += (twist.linear * seconds).abs();
            reckoning.update(&odometry);
        }
    }

    #[test]
    fn a_quarter_circle_is_an_arc_not_a_chord() {
        let mut reckoning = DeadReckoning::new(WhereAmIConfig::default(), Pose::new(5.0, 1.0, FRAC_PI_2));
        drive(&mut reckoning, &[(Twist::new(FRAC_PI_2, FRAC_PI_2), 1.0)], Pose::new(-3.0, 7.0, 0.3));
        let estimate = reckoning.estimate();
        assert!(estimate.pose.distance(&Pose::new(4.0, 2.0, 0.0)) < 1e-12, "{estimate:?}");
        assert!((estimate.travelled - FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn uncertainty_along_a_straight_line_is_as_the_model_says() {
        let config = WhereAmIConfig { distance_error: 0.01, turn_error: 0.0, drift: 0.0 };
        let mut reckoning = DeadReckoning::new(config, Pose::default());
        drive(&mut reckoning, &[(Twist::new(1.0, 0.0), 4.0)], Pose::default());
        let covariance = reckoning.estimate().covariance();
        assert!((covariance[(0, 0)].sqrt() - 0.04).abs() < 1e-12 && covariance[(1, 1)] == 0.0);
    }

    proptest! {
        #[test]
        fn the_covariance_stays_symmetric_and_never_shrinks_in_trace(
            twists in prop::collection::vec((-0.5..0.5f64, -1.0..1.0f64), 1..40)
        ) {
            let mut reckoning = DeadReckoning::new(WhereAmIConfig::default(), Pose::default());
            let mut trace = 0.0;
            let mut odometry = Odometry::default();
            reckoning.update(&odometry);
            for (n, (v, w)) in twists.iter().enumerate() {
                odometry.stamp = Time::from_secs_f64(n as f64);
                odometry.pose = odometry.pose.after(Twist::new(*v, *w), 0.5);
                reckoning.update(&odometry);
                let p = reckoning.estimate().covariance();
                prop_assert!((p - p.transpose()).norm() < 1e-12);
                prop_assert!(p.symmetric_eigenvalues().min() > -1e-12);
                prop_assert!(p[(2, 2)] >= trace);
                trace = p[(2, 2)];
            }
        }

        #[test]
        fn rubbish_from_the_encoders_is_passed_over(x in prop::num::f64::ANY, heading in -TAU..TAU) {
            let mut reckoning = DeadReckoning::new(WhereAmIConfig::default(), Pose::default());
            reckoning.update(&Odometry::default());
            reckoning.update(&Odometry { pose: Pose { x, y: f64::NAN, heading }, ..Odometry::default() });
            prop_assert!(reckoning.estimate().pose.is_sound());
        }
    }
}
