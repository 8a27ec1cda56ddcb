//! Two transducers that look the same way from side by side (Good 1992, §2.3.1).
//!
//! If both hear the same distance, the object is most likely in front of both: one virtual transducer between them speaks for the
//! pair. If they disagree, then from afar each has probably met an object of its own, in the part of its beam that the other
//! does not share; that object is drawn as a narrow arc on the outer side, and with less certainty. Close by, where avoidance
//! depends on the place, each is drawn as if it were alone.

use nalgebra::center;
use orienteer_runtime::{
    geometry::{Pose, angle},
    robot_model::Transducer,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    level,
    marking::{Arc, Reading},
};

/// Which transducers make a pair and when they agree.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PairConfig {
    /// Whether transducers that look the same way are fused in pairs.
    pub enabled: bool,
    /// Two transducers make a pair if they look the same way and are less than this apart, m. (Luey: 0.24.)
    #[schemars(range(min = 0.0, max = 1.0))]
    pub spacing: f64,
    /// Ranges that differ by less than this, m, agree. (The source: one cell of 20 cm.)
    #[schemars(range(min = 0.0, max = 2.0))]
    pub agreement: f64,
    /// Where the two disagree, an object nearer than this, m, is drawn as its own transducer saw it.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub near: f64,
}

impl Default for PairConfig {
    fn default() -> Self {
        Self { enabled: true, spacing: 0.3, agreement: 0.2, near: 0.5 }
    }
}

/// Two parallel transducers side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// The left one, looking along the beams.
    pub left: usize,
    /// The right one.
    pub right: usize,
    /// Between the two, robot frame.
    pub centre: Pose,
}

/// One transducer's reading before it is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sounding {
    /// Where the sound left and which way, map frame.
    pub face: Pose,
    /// How far away the echo came from; the maximum range for silence, m.
    pub range: f64,
    /// True if nothing was heard.
    pub silent: bool,
    /// Weight `δ`, 1 to 6.
    pub weight: f32,
    /// Half the opening angle of cone and arc, rad.
    pub half_angle: f64,
}

/// Largest difference of direction within a pair, rad, and largest distance of one behind the other, m.
const PARALLEL: f64 = 0.02;
const ABREAST: f64 = 0.05;

/// The pairs of a ring, in the order of their first member. Of several possible partners the nearest is taken; no transducer
/// is in two pairs.
#[must_use]
pub fn detect(transducers: &[Transducer], config: &PairConfig) -> Vec<Pair> {
    let mut candidates = Vec::new();
    for i in 0..transducers.len() {
        for j in i + 1..transducers.len() {
            let seen = transducers[i].mount.between(transducers[j].mount);
            let parallel = seen.heading.abs() < PARALLEL && seen.x.abs() < ABREAST;
            if config.enabled && parallel && seen.y.abs() > 0.0 && seen.y.abs() < config.spacing {
                candidates.push((seen.y.abs(), i, j, seen.y > 0.0));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut taken = vec![false; transducers.len()];
    let mut pairs: Vec<Pair> = Vec::new();
    for (_, i, j, second_is_left) in candidates {
        if !taken[i] && !taken[j] {
            (taken[i], taken[j]) = (true, true);
            let (left, right) = if second_is_left { (j, i) } else { (i, j) };
            let centre = between(transducers[left].mount, transducers[right].mount);
            pairs.push(Pair { left, right, centre });
        }
    }
    pairs.sort_by_key(|pair| pair.left.min(pair.right));
    pairs
}

/// The pose halfway between two faces that look almost the same way.
fn between(a: Pose, b: Pose) -> Pose {
    let middle = center(&a.point(), &b.point());
    Pose::new(middle.x, middle.y, a.heading + 0.5 * angle::turn(a.heading, b.heading))
}

/// The reading of a transducer without a partner.
#[must_use]
pub fn alone(sounding: &Sounding) -> Reading {
    let object = Arc { value: level::HIGH_OCCUPIED, half_angle: sounding.half_angle, aside: 0.0 };
    Reading {
        face: sounding.face,
        range: sounding.range,
        silent: sounding.silent,
        weight: sounding.weight,
        cone: Some(sounding.half_angle),
        object: Some(object),
    }
}

/// What a pair says: one reading if it agrees, two if it does not.
pub fn fuse(left: &Sounding, right: &Sounding, config: &PairConfig, readings: &mut Vec<Reading>) {
    if (left.range - right.range).abs() < config.agreement {
        readings.push(alone(&Sounding {
            face: between(left.face, right.face),
            range: 0.5 * (left.range + right.range),
            silent: left.silent && right.silent,
            weight: left.weight.min(right.weight),
            half_angle: left.half_angle.min(right.half_angle),
        }));
        return;
    }
    // An object that only one of the two hears lies on that one's outer side.
    for (sounding, outward) in [(left, 1.0), (right, -1.0)] {
        let mut reading = alone(sounding);
        if sounding.range >= config.near {
            let half_angle = 0.5 * sounding.half_angle;
            reading.object = Some(Arc { value: level::MEDIUM_OCCUPIED, half_angle, aside: outward * half_angle });
        }
        readings.push(reading);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    use super::*;

    /// Luey's square arrangement, cm and degrees as in the source.
    fn luey() -> Vec<Transducer> {
        let table = [
            (-8.2, -8.5, -90.0),
            (-8.2, 9.5, 90.0),
            (-5.7, 12.0, 180.0),
            (-5.7, -11.0, 180.0),
            (13.3, -11.0, 0.0),
            (13.3, 12.0, 0.0),
            (15.8, -8.5, -90.0),
            (15.8, 9.5, 90.0),
        ];
        table
            .map(|(x, y, facing): (f64, f64, f64)| Transducer {
                mount: Pose::new(x / 100.0, y / 100.0, facing.to_radians()),
                half_beam: 15f64.to_radians(),
            })
            .to_vec()
    }

    fn sounding(y: f64, range: f64) -> Sounding {
        let half_angle = 8f64.to_radians();
        Sounding { face: Pose::new(0.0, y, 0.0), range, silent: false, weight: 3.0, half_angle }
    }

    #[test]
    fn finds_the_four_pairs_of_luey() {
        let pairs = detect(&luey(), &PairConfig::default());
        let found: Vec<_> = pairs.iter().map(|pair| (pair.left, pair.right)).collect();
        // the rear pair looks backward, so its left is the robot's right
        assert_eq!(found, [(6, 0), (1, 7), (3, 2), (5, 4)]);
        let centres = [(0.038, -0.085, -FRAC_PI_2), (0.038, 0.095, FRAC_PI_2), (-0.057, 0.005, PI), (0.133, 0.005, 0.0)];
        for (pair, (x, y, facing)) in pairs.iter().zip(centres) {
            let want = Pose::new(x, y, facing);
            assert!(pair.centre.distance(&want) < 1e-9 && angle::turn(pair.centre.heading, want.heading).abs() < 1e-9);
        }
    }

    #[test]
    fn rings_without_parallel_neighbours_have_no_pairs() {
        let ring: Vec<_> = (0..16)
            .map(|i| f64::from(i) * PI / 8.0)
            .map(|bearing| Transducer { mount: Pose::new(0.2 * bearing.cos(), 0.2 * bearing.sin(), bearing), half_beam: 0.2 })
            .collect();
        assert!(detect(&ring, &PairConfig::default()).is_empty());
        assert!(detect(&luey(), &PairConfig { enabled: false, ..PairConfig::default() }).is_empty());
        assert!(detect(&luey(), &PairConfig { spacing: 0.2, ..PairConfig::default() }).is_empty());
        // moved to the front corners, as in the other arrangement, the rear ones are no pair
        let mut front = luey();
        front[2].mount.heading = -FRAC_PI_4;
        front[3].mount.heading = FRAC_PI_4;
        assert_eq!(detect(&front, &PairConfig::default()).len(), 3);
    }

    #[test]
    fn agreement_is_one_reading_from_the_middle() {
        let mut readings = Vec::new();
        let weak = Sounding { weight: 1.0, ..sounding(-0.12, 2.1) };
        fuse(&sounding(0.12, 2.0), &weak, &PairConfig::default(), &mut readings);
        let [reading] = readings[..] else { panic!("{readings:?}") };
        assert_eq!((reading.range, reading.weight, reading.silent), (2.05, 1.0, false));
        assert!(reading.face.distance(&Pose::default()) < 1e-12);
        assert_eq!(reading.object.map(|arc| (arc.value, arc.aside)), Some((1.0, 0.0)));
    }

    #[test]
    fn two_silent_partners_agree_on_silence() {
        let mut readings = Vec::new();
        let silent = |y| Sounding { silent: true, ..sounding(y, 5.99) };
        fuse(&silent(0.12), &silent(-0.12), &PairConfig::default(), &mut readings);
        assert_eq!(readings.len(), 1);
        assert!(readings[0].silent);
    }

    #[test]
    fn far_disagreement_puts_objects_outside() {
        let mut readings = Vec::new();
        fuse(&sounding(0.12, 2.0), &sounding(-0.12, 2.2), &PairConfig::default(), &mut readings);
        let four = 4f64.to_radians();
        let arcs: Vec<_> = readings.iter().filter_map(|reading| reading.object).collect();
        assert_eq!(arcs, [four, -four].map(|aside| Arc { value: 0.75, half_angle: four, aside }));
        assert!(readings.iter().all(|reading| reading.cone == Some(8f64.to_radians()) && reading.weight == 3.0));
    }

    #[test]
    fn near_disagreement_is_drawn_as_heard() {
        let mut readings = Vec::new();
        fuse(&sounding(0.12, 0.4), &sounding(-0.12, 3.0), &PairConfig::default(), &mut readings);
        assert_eq!(readings[0], alone(&sounding(0.12, 0.4)));
        assert_eq!(readings[1].object.map(|arc| arc.value), Some(0.75));
    }
}
