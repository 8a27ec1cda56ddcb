//! What a robot is made of, as far as behaviours need to know: its body and its sonar ring.

use serde::Serialize;

use crate::{
    geometry::{Limits, Pose},
    topics::FiringProgram,
};

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
    /// Distance needed to come to rest from `speed`, m: `v² / 2a`.
    #[must_use]
    pub fn stopping_distance(&self, speed: f64) -> f64 {
        speed * speed / (2.0 * self.acceleration)
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

impl Ring {
    /// The transducer whose beam points nearest to `bearing` (rad, robot frame); `None` if the ring is empty.
    #[must_use]
    pub fn nearest_to(&self, bearing: f64) -> Option<usize> {
        let off = |t: &Transducer| crate::geometry::angle::turn(t.mount.heading, bearing).abs();
        (0..self.transducers.len()).min_by(|a, b| off(&self.transducers[*a]).total_cmp(&off(&self.transducers[*b])))
    }

    /// Indices of the transducers whose beams point within `half_angle` of `bearing`, in ring order.
    pub fn within(&self, bearing: f64, half_angle: f64) -> impl Iterator<Item = usize> + '_ {
        let inside = move |t: &Transducer| crate::geometry::angle::turn(t.mount.heading, bearing).abs() <= half_angle + 1e-9;
        self.transducers.iter().enumerate().filter(move |(_, t)| inside(t)).map(|(i, _)| i)
    }
}
