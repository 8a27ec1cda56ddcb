//! A beam in the world, and what it may meet.

use nalgebra::{Point2, Vector2};
use orienteer_runtime::geometry::Pose;

/// The widest half beam that a [`Beam`] can have, rad (40°).
pub const MAX_HALF_BEAM: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// The cone that one transducer fills.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    pub(super) origin: Point2<f64>,
    pub(super) axis: Vector2<f64>,
    pub(super) tan_half: f64,
    pub(super) sec_half: f64,
    pub(super) cos_half: f64,
    pub(super) max_range: f64,
}

impl Beam {
    /// The beam of a transducer at `pose` (world frame) that opens `half_beam` rad to both sides and hears up to
    /// `max_range` m from its face. The half beam is clamped to [`MAX_HALF_BEAM`].
    #[must_use]
    pub fn new(pose: Pose, half_beam: f64, max_range: f64) -> Self {
        Self::along(pose.point(), pose.direction(), half_beam, max_range)
    }

    /// The same from a point and a unit vector along the axis.
    #[must_use]
    pub fn along(origin: Point2<f64>, axis: Vector2<f64>, half_beam: f64, max_range: f64) -> Self {
        let tan_half = half_beam.clamp(0.0, MAX_HALF_BEAM).tan();
        let sec_half = (1.0 + tan_half * tan_half).sqrt();
        Self { origin, axis, tan_half, sec_half, cos_half: sec_half.recip(), max_range }
    }

    /// The same beam from elsewhere: saves the tangent of the half beam.
    pub(super) fn moved(&self, origin: Point2<f64>, axis: Vector2<f64>) -> Self {
        Self { origin, axis, ..*self }
    }

    /// A world point in the frame of the beam: along the axis, and to its left.
    pub(super) fn local(&self, x: f64, y: f64) -> (f64, f64) {
        self.turned(x - self.origin.x, y - self.origin.y)
    }

    /// A world vector in the frame of the beam.
    pub(super) fn turned(&self, x: f64, y: f64) -> (f64, f64) {
        (x * self.axis.x + y * self.axis.y, y * self.axis.x - x * self.axis.y)
    }
}

/// What an echo came from. Indices are those of the lists that were handed over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Source {
    /// A wall of the grid.
    Wall(usize),
    /// A pillar of the grid.
    Pillar(usize),
    /// A vertex of the grid.
    Vertex(usize),
    /// A moving body.
    Body(usize),
}

/// The nearest point that answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Metres from the transducer.
    pub range: f64,
    /// Tangent of the angle between the beam's axis and the way to the point, positive to the left.
    pub slope: f64,
    /// What the point belongs to.
    pub source: Source,
}

impl Answer {
    /// Where the point lies off the beam's axis, rad, positive to the left.
    #[must_use]
    pub fn bearing(&self) -> f64 {
        self.slope.atan()
    }

    /// Where the point lies in the world, m; `beam` is the one that it answered.
    #[must_use]
    pub fn at(&self, beam: &Beam) -> Point2<f64> {
        let left = Vector2::new(-beam.axis.y, beam.axis.x);
        beam.origin + (beam.axis + left * self.slope) * (self.range / (1.0 + self.slope * self.slope).sqrt())
    }
}

/// What a thin ray meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Metres from the ray's origin.
    pub range: f64,
    /// Where, m.
    pub at: Point2<f64>,
    /// Unit normal of the surface there, on the side of the ray's origin.
    pub normal: Vector2<f64>,
    /// Share of the sound sent back.
    pub reflectance: f64,
    /// What was met; never a vertex.
    pub source: Source,
}
