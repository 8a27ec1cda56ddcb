//! What a robot is made of, as far as behaviours need to know: its body and its sonar ring.

use std::f64::consts::FRAC_PI_2;

use serde::Serialize;

use crate::{
    geometry::{Limits, Pose, angle},
    topics::FiringProgram,
};

/// A transducer within this angle of a direction looks that way, rad.
const STRAIGHT: f64 = 0.2;

/// A mobile base as its maker describes it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Platform {
    /// Name of the kind of base.
    pub name: String,
    /// Radius of the smallest circle about the robot's centre that contains the body, m.
    pub radius: f64,
    /// What the base can do, and what protection will allow at most.
    pub limits: Limits,
    /// Largest change of speed, m/s²; also what a stop may use.
    pub acceleration: f64,
    /// Largest change of turn rate, rad/s².
    pub angular_acceleration: f64,
    /// Smallest radius of a curve, m; 0 for a base that turns on the spot.
    pub turning_radius: f64,
}

impl Platform {
    /// What no base can be, if it is: protection reckons with these numbers, and with NaN everything would look free.
    #[must_use]
    pub fn flaw(&self) -> Option<String> {
        let positive = |number: f64| number.is_finite() && number > 0.0;
        let flaw = |what: &str, number: f64| Some(format!("the {what} of `{}` is {number}", self.name));
        match self {
            Self { radius, .. } if !positive(*radius) => flaw("radius", *radius),
            Self { acceleration, .. } if !positive(*acceleration) => flaw("acceleration", *acceleration),
            Self { angular_acceleration, .. } if !positive(*angular_acceleration) => {
                flaw("angular acceleration", *angular_acceleration)
            }
            Self { turning_radius, .. } if !(turning_radius.is_finite() && *turning_radius >= 0.0) => {
                flaw("turning radius", *turning_radius)
            }
            Self { limits: Limits { linear, .. }, .. } if !positive(*linear) => flaw("top speed", *linear),
            Self { limits: Limits { angular, .. }, .. } if !positive(*angular) => flaw("top turn rate", *angular),
            _ => None,
        }
    }
}

/// One transducer of a ring.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Transducer {
    /// Where its face is and where its beam points, robot frame.
    pub mount: Pose,
    /// Half the beam's opening angle, rad.
    pub half_beam: f64,
}

/// The sonar ring of a robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ring {
    /// Name of the ring.
    pub name: String,
    /// At most [`MAX_TRANSDUCERS`](crate::topics::MAX_TRANSDUCERS), in the order of scans.
    pub transducers: Vec<Transducer>,
    /// Anything nearer than this, m from the face, reads as too near.
    pub min_range: f64,
    /// Nothing beyond this is heard, m from the face.
    pub max_range: f64,
    /// Seconds from one slot of a firing program to the next.
    pub slot_time: f64,
    /// What the ring does unless somebody asks for something else.
    pub program: FiringProgram,
}

/// The transducers of a ring by which a robot finds its way along corridors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LookOut {
    /// The one that looks ahead, or, where none does, those that look past it on either side and whose beams reach as far.
    pub ahead: Vec<usize>,
    /// Those that look to the left and to the right.
    pub flanks: [usize; 2],
}

impl Ring {
    /// What no ring can be, if it is.
    #[must_use]
    pub fn flaw(&self) -> Option<String> {
        let sound = |transducer: &Transducer| {
            let Transducer { mount, half_beam } = transducer;
            mount.is_sound() && *half_beam > 0.0 && *half_beam < std::f64::consts::FRAC_PI_2
        };
        let Self { name, min_range, max_range, slot_time, .. } = self;
        if !(*min_range >= 0.0 && max_range > min_range && max_range.is_finite()) {
            return Some(format!("`{name}` hears from {min_range} to {max_range} m"));
        }
        if !(slot_time.is_finite() && *slot_time >= 0.0) {
            return Some(format!("the slot time of `{name}` is {slot_time} s"));
        }
        let wrong = self.transducers.iter().position(|transducer| !sound(transducer))?;
        Some(format!("transducer {wrong} of `{name}` has a place or a beam that can't be: {:?}", self.transducers[wrong]))
    }

    /// Least time from the start of a pass of the ring's own program to the start of the next, s.
    #[must_use]
    pub fn pass_time(&self) -> f64 {
        f64::from(self.program.period).max(self.program.slots.len() as f64 * self.slot_time)
    }

    /// The transducer that looks along `bearing` (rad, robot frame), if one points near enough there to tell what lies ahead.
    #[must_use]
    pub fn facing(&self, bearing: f64) -> Option<usize> {
        self.nearest_to(bearing).filter(|nearest| self.within(bearing, STRAIGHT).any(|within| within == *nearest))
    }

    /// Who looks ahead, to the left and to the right; otherwise where nobody looks, in words.
    ///
    /// # Errors
    /// The directions in which nobody looks.
    pub fn look_out(&self) -> Result<LookOut, String> {
        let (ahead, left, right) = (self.toward(0.0), self.facing(FRAC_PI_2), self.facing(-FRAC_PI_2));
        let blind = [(ahead.is_empty(), "ahead"), (left.is_none(), "to the left"), (right.is_none(), "to the right")];
        let blind: Vec<_> = blind.iter().filter(|(blind, _)| *blind).map(|(_, side)| *side).collect();
        match (left, right) {
            (Some(left), Some(right)) if blind.is_empty() => Ok(LookOut { ahead, flanks: [left, right] }),
            _ => Err(format!("no transducer of `{}` looks {}", self.name, blind.join(" or "))),
        }
    }

    /// The one that points there, or those on either side of it whose beams reach as far.
    fn toward(&self, bearing: f64) -> Vec<usize> {
        if let Some(one) = self.facing(bearing) {
            return vec![one];
        }
        let off = |i: &usize| angle::turn(bearing, self.transducers[*i].mount.heading);
        let reaches = |i: &usize| off(i).abs() <= self.transducers[*i].half_beam + 1e-9;
        let reaching: Vec<_> = (0..self.transducers.len()).filter(reaches).collect();
        let both = reaching.iter().any(|i| off(i) > 0.0) && reaching.iter().any(|i| off(i) < 0.0);
        if both { reaching } else { Vec::new() }
    }

    /// The transducer whose beam points nearest to `bearing` (rad, robot frame); `None` if the ring is empty.
    #[must_use]
    pub fn nearest_to(&self, bearing: f64) -> Option<usize> {
        let off = |t: &Transducer| angle::turn(t.mount.heading, bearing).abs();
        (0..self.transducers.len()).min_by(|a, b| off(&self.transducers[*a]).total_cmp(&off(&self.transducers[*b])))
    }

    /// Indices of the transducers whose beams point within `half_angle` of `bearing`, in ring order.
    pub fn within(&self, bearing: f64, half_angle: f64) -> impl Iterator<Item = usize> + '_ {
        let inside = move |t: &Transducer| angle::turn(t.mount.heading, bearing).abs() <= half_angle + 1e-9;
        self.transducers.iter().enumerate().filter(move |(_, t)| inside(t)).map(|(i, _)| i)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_no_base_and_no_ring_can_be_is_told() {
        let limits = Limits { linear: 0.5, angular: 1.0 };
        let sound = Platform {
            name: "base".into(),
            radius: 0.3,
            limits,
            acceleration: 0.5,
            angular_acceleration: 1.0,
            turning_radius: 0.0,
        };
        assert_eq!(sound.flaw(), None);
        for wrong in [f64::NAN, f64::INFINITY, -1.0] {
            assert!(Platform { radius: wrong, ..sound.clone() }.flaw().is_some_and(|flaw| flaw.contains("radius")));
            assert!(Platform { acceleration: wrong, ..sound.clone() }.flaw().is_some_and(|flaw| flaw.contains("acceleration")));
            assert!(Platform { turning_radius: wrong, ..sound.clone() }.flaw().is_some());
            assert!(Platform { limits: Limits { linear: wrong, ..limits }, ..sound.clone() }.flaw().is_some());
        }
        let transducers = vec![Transducer { mount: Pose::default(), half_beam: 0.2 }];
        let (name, program) = ("ring".into(), FiringProgram::default());
        let ring = Ring { name, transducers, min_range: 0.1, max_range: 5.0, slot_time: 0.01, program };
        assert_eq!(ring.flaw(), None);
        assert!(Ring { max_range: f64::NAN, ..ring.clone() }.flaw().is_some());
        let blunt = Transducer { mount: Pose::default(), half_beam: 2.0 };
        assert!(
            Ring { transducers: vec![ring.transducers[0], blunt], ..ring }
                .flaw()
                .is_some_and(|flaw| flaw.contains("transducer 1"))
        );
    }

    #[test]
    fn a_pair_that_looks_past_it_on_either_side_looks_ahead() {
        let ring = |bearings: &[f64]| {
            let at =
                |degrees: &f64| Transducer { mount: Pose::new(0.1, 0.0, degrees.to_radians()), half_beam: 15f64.to_radians() };
            let transducers = bearings.iter().map(at).collect();
            let (name, program) = ("ring".into(), FiringProgram::default());
            Ring { name, transducers, min_range: 0.1, max_range: 5.0, slot_time: 0.01, program }
        };
        let seen = |ahead: &[usize], flanks| Ok(LookOut { ahead: ahead.to_vec(), flanks });
        assert_eq!(ring(&[90.0, 15.0, -15.0, -90.0]).look_out(), seen(&[1, 2], [0, 3]));
        assert_eq!(ring(&[90.0, 15.0, 5.0, -15.0, -90.0]).look_out(), seen(&[2], [0, 4]));
        let blind = |bearings: &[f64]| ring(bearings).look_out().unwrap_err();
        assert_eq!(blind(&[90.0, 15.0, -90.0]), "no transducer of `ring` looks ahead");
        assert_eq!(blind(&[90.0, 16.0, -16.0, -90.0]), "no transducer of `ring` looks ahead");
        assert_eq!(blind(&[0.0, 60.0]), "no transducer of `ring` looks to the left or to the right");
    }
}
