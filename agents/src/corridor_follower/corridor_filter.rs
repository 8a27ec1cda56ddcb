//! Where the robot is between the walls, from all transducers that can see one.

use nalgebra::{Matrix3, RowVector3, Vector3};
use orienteer_runtime::{
    geometry::{Pose, angle},
    robot_model::{Ring, Transducer},
    topics::{Echo, SonarScan},
};

use super::Side;

/// Where the robot is between the two walls of a corridor: a Kalman filter over lateral offset, heading and width.
///
/// The corridor's axis is the x axis of its frame, walls stand at `y = ±W/2`. State: `e`, offset of the robot's centre to the
/// left of the axis; `φ`, its heading relative to the axis; `W`. Odometry predicts `e` and `φ`; every transducer that can see
/// a wall corrects them. A beam of half angle `α` whose axis is `δ` off the wall's normal hears the nearest answering point,
/// which lies `γ = max(0, |δ| − α)` off the normal, so for a face `D` away from the wall
///
/// ```text
/// z = D / cos γ,    D = W/2 ∓ (e + m_x sin φ + m_y cos φ)      (− left wall, + right wall; m: mount of the transducer)
/// ```
///
/// While the normal is within the beam the reading is the perpendicular distance itself, whatever the heading. Readings that
/// do not fit are passed over, so people, openings and spurious echoes do not pull the estimate.
#[derive(Debug, Clone)]
pub struct CorridorFilter {
    state: Vector3<f64>,
    covariance: Matrix3<f64>,
}

/// How a reading compares with the wall that its transducer should hear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Which wall.
    pub side: Side,
    /// Reading minus expectation, m; [`f64::INFINITY`] if nothing answered.
    pub surplus: f64,
    /// True if the beam holds the wall's normal, so that the reading is the perpendicular distance.
    pub perpendicular: bool,
    /// How far ahead of the robot's centre, along the corridor, the transducer's face is, m.
    pub ahead: f64,
    /// Expected range, m.
    pub expected: f64,
    /// Slope of the beam's trailing edge: how far it lags behind the face for each metre away from it.
    pub lag: f64,
}

/// Beams farther than this off the wall's normal (beyond the beam's own half angle) are not used: they may hear nothing.
pub(super) const GRAZING: f64 = 0.30;
/// Standard deviation of a reading: noise, quantisation and rough walls.
const READING: f64 = 0.03;
/// Standard deviation of the distance to a wall that was seen at the start: quantised readings, and a robot that is not aligned.
const SEEN: f64 = 0.08;
/// Standard deviation of the distance to a wall that was not.
const GUESSED: f64 = 0.4;
/// A reading this far off is not the wall, however uncertain the estimate.
const FAR_OFF: f64 = 0.5;

impl CorridorFilter {
    /// A robot in a corridor, given the distances from its centre to the walls on the left and on the right (m) and its heading
    /// relative to them. An unseen side is taken to be as far as the other, and known to be a guess. It is no nearer than `room`,
    /// which a robot in the middle has to either side: one that begins at a wall does not follow it at a hand's breadth.
    #[must_use]
    pub fn new(left: Option<f64>, right: Option<f64>, heading: f64, room: f64) -> Option<Self> {
        let (l, r) = match (left, right) {
            (Some(left), Some(right)) => (left, right),
            (Some(left), None) => (left, left.max(room)),
            (None, Some(right)) => (right.max(room), right),
            (None, None) => return None,
        };
        let variance = |seen: Option<f64>| if seen.is_some() { SEEN * SEEN } else { GUESSED * GUESSED };
        let (vl, vr) = (variance(left), variance(right));
        let (both, skew) = (vl + vr, 0.5 * (vr - vl));
        let covariance = Matrix3::new(0.25 * both, 0.0, skew, 0.0, 0.15 * 0.15, 0.0, skew, 0.0, both);
        Some(Self { state: Vector3::new(0.5 * (r - l), heading, l + r), covariance })
    }

    /// Takes the wall on one side to stand `by` farther away than thought, or nearer if negative.
    pub fn shift_wall(&mut self, side: Side, by: f64) {
        self.state[0] -= 0.5 * side.sign() * by;
        self.state[2] += by;
        self.covariance[(0, 0)] += 0.25 * SEEN * SEEN;
        self.covariance[(2, 2)] += SEEN * SEEN;
    }

    /// Offset of the robot's centre to the left of the middle, m.
    #[must_use]
    pub fn offset(&self) -> f64 {
        self.state[0]
    }

    /// Heading relative to the corridor, rad; positive is turned to the left.
    #[must_use]
    pub fn heading(&self) -> f64 {
        self.state[1]
    }

    /// Distance between the walls, m.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.state[2]
    }

    /// Follows a displacement given in the robot's frame.
    pub fn predict(&mut self, moved: Pose) {
        let (sin, cos) = self.heading().sin_cos();
        let jacobian = Matrix3::new(1.0, cos * moved.x - sin * moved.y, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        self.state[0] += sin * moved.x + cos * moved.y;
        self.state[1] = angle::wrap(self.state[1] + moved.heading);
        let distance = moved.x.hypot(moved.y);
        self.covariance = jacobian * self.covariance * jacobian.transpose();
        self.covariance[(0, 0)] += (0.02 * distance).powi(2);
        self.covariance[(1, 1)] += (0.03 * moved.heading).powi(2) + 1e-4 * distance;
        self.covariance[(2, 2)] += 4e-4 * distance;
    }

    /// Corrects the estimate with every fresh reading that fits a wall, and tells `compared` how each reading fitted.
    pub fn correct(&mut self, ring: &Ring, scan: &SonarScan, mut compared: impl FnMut(usize, Comparison)) {
        for (i, transducer) in ring.transducers.iter().enumerate().filter(|(i, _)| scan.is_fresh(*i)) {
            let Some((side, expected, slope)) = self.expect(transducer) else { continue };
            let reading = match scan.echo(i) {
                Echo::Range(range) => f64::from(range),
                Echo::Nothing => f64::INFINITY,
                Echo::TooNear | Echo::NotFired => continue,
            };
            let surplus = reading - expected;
            let off = off_normal(self.heading() + transducer.mount.heading, side);
            let perpendicular = off.abs() <= transducer.half_beam;
            let (sin, cos) = self.heading().sin_cos();
            let ahead = transducer.mount.x * cos - transducer.mount.y * sin;
            let lag = (side.sign() * off + transducer.half_beam).tan();
            compared(i, Comparison { side, surplus, perpendicular, ahead, expected, lag });
            self.update(surplus, slope);
        }
    }

    /// Which wall a transducer should hear, at what range, and how the range depends on the state.
    fn expect(&self, transducer: &Transducer) -> Option<(Side, f64, RowVector3<f64>)> {
        let (sin, cos) = self.heading().sin_cos();
        let mount = transducer.mount;
        let side = if angle::wrap(self.heading() + mount.heading) > 0.0 { Side::Left } else { Side::Right };
        let off = off_normal(self.heading() + mount.heading, side);
        let grazing = (off.abs() - transducer.half_beam).max(0.0);
        if grazing > GRAZING {
            return None;
        }
        let face = self.offset() + mount.x * sin + mount.y * cos;
        let face_slope = mount.x * cos - mount.y * sin;
        let sign = side.sign();
        let distance = 0.5 * self.width() - sign * face;
        let stretch = 1.0 / grazing.cos();
        let by_heading =
            -sign * face_slope * stretch + distance * stretch * grazing.tan() * off.signum() * f64::from(u8::from(grazing > 0.0));
        (distance > 0.0).then(|| (side, distance * stretch, RowVector3::new(-sign * stretch, by_heading, 0.5 * stretch)))
    }

    fn update(&mut self, surplus: f64, slope: RowVector3<f64>) {
        let variance = (slope * self.covariance * slope.transpose())[0] + READING * READING;
        if surplus.abs() > FAR_OFF || surplus * surplus > 9.0 * variance {
            return;
        }
        let gain = self.covariance * slope.transpose() / variance;
        self.state += gain * surplus;
        self.state[1] = angle::wrap(self.state[1]);
        self.covariance -= gain * slope * self.covariance;
        // Rounding must not make it lopsided over an hour.
        self.covariance = 0.5 * (self.covariance + self.covariance.transpose());
    }
}

/// Angle from the normal of a side's wall to a beam of this bearing in the corridor's frame, rad.
pub(super) fn off_normal(bearing: f64, side: Side) -> f64 {
    angle::turn(side.sign() * std::f64::consts::FRAC_PI_2, bearing)
}

#[cfg(test)]
pub(super) mod fixtures {
    use std::f64::consts::FRAC_PI_8;

    use orienteer_runtime::topics::FiringProgram;

    use super::*;

    pub fn ring() -> Ring {
        let transducers = (0..16)
            .map(|k| {
                let bearing = -f64::from(k) * FRAC_PI_8;
                Transducer { mount: Pose::new(0.08 * bearing.cos(), 0.08 * bearing.sin(), bearing), half_beam: 0.21 }
            })
            .collect();
        Ring {
            name: "test".into(),
            transducers,
            min_range: 0.1,
            max_range: 7.0,
            slot_time: 0.01,
            program: FiringProgram::default(),
        }
    }

    /// An independent oracle: the nearest point of either wall over a fan of rays through the beam, within 30° of normal.
    pub fn range(transducer: &Transducer, e: f64, phi: f64, width: f64) -> Echo {
        let face = Pose::new(0.0, e, phi).then(transducer.mount);
        let rays = (-2000..=2000).map(|n| face.heading + transducer.half_beam * f64::from(n) / 2000.0);
        let nearest = rays
            .filter_map(|bearing| {
                let sin = bearing.sin();
                (sin.abs() > 30f64.to_radians().cos()).then(|| (0.5 * width * sin.signum() - face.y) / sin)
            })
            .fold(f64::INFINITY, f64::min);
        if nearest.is_finite() { Echo::Range(nearest as f32) } else { Echo::Nothing }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::f64::consts::TAU;

    use orienteer_runtime::time::Time;
    use proptest::prelude::*;

    use super::{
        fixtures::{range, ring},
        *,
    };

    proptest! {
        #[test]
        fn finds_offset_and_heading_within_a_metre_of_travel(
            e in -0.2..0.2f64, phi in -0.17..0.17f64, width in 1.12..2.5f64
        ) {
            let ring = ring();
            let mut filter = CorridorFilter::new(Some(0.5 * width), Some(0.5 * width), 0.0, 0.55).unwrap();
            let (mut pose, step) = (Pose::new(0.0, e, phi), Pose::new(0.02, 0.0, 0.0));
            for n in 0..50 {
                let echoes: Vec<_> = ring.transducers.iter().map(|t| range(t, pose.y, pose.heading, width)).collect();
                filter.correct(&ring, &SonarScan::from_echoes(Time::START, n, &echoes), |_, _| {});
                filter.predict(step);
                pose = pose.then(step);
            }
            prop_assert!((filter.offset() - pose.y).abs() < 0.02, "{} {}", filter.offset(), pose.y);
            prop_assert!((filter.heading() - pose.heading).abs() < 0.03, "{} {}", filter.heading(), pose.heading);
            prop_assert!((filter.width() - width).abs() < 0.03);
        }

        #[test]
        fn any_heading_leaves_a_finite_estimate(phi in -TAU..TAU, readings in prop::collection::vec(0.0f32..8.0, 16)) {
            let ring = ring();
            let mut filter = CorridorFilter::new(Some(0.6), None, 0.0, 0.55).unwrap();
            filter.predict(Pose::new(0.1, 0.0, phi));
            let echoes: Vec<_> = readings.into_iter().map(Echo::Range).collect();
            filter.correct(&ring, &SonarScan::from_echoes(Time::START, 1, &echoes), |_, _| {});
            prop_assert!(filter.offset().is_finite() && filter.heading().is_finite() && filter.width().is_finite());
        }
    }
}
