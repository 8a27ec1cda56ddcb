//! Echoes over one mirror, which read too far.

use super::{
    acoustics::Acoustics,
    beam::Beam,
    cone::{Scratch, first_surface},
    grid::{Disc, SegmentGrid},
};

/// Range of the echo that comes back over one mirror, m; `None` if there is none within the beam's range.
///
/// The beam's axis is followed to the first surface, mirrored there, and followed to the next. If that one is met within its
/// incidence limit, the sound returns the way it came, and half of its path is the sum of the two legs. This is the usual
/// cause of readings that are too long (Good 1992, multi-bounce; MacPherson 1993, §VIII on concave corners). Only the axis is
/// followed, not the whole cone.
#[must_use]
pub fn second_bounce(
    grid: &SegmentGrid,
    bodies: &[Disc],
    beam: &Beam,
    acoustics: &Acoustics,
    scratch: &mut Scratch,
) -> Option<f64> {
    let mirror = first_surface(grid, bodies, beam, None, scratch)?;
    let axis = beam.axis - 2.0 * beam.axis.dot(&mirror.normal) * mirror.normal;
    let onward = Beam { max_range: beam.max_range - mirror.range, ..beam.moved(mirror.at, axis) };
    let target = first_surface(grid, bodies, &onward, Some(mirror.source), scratch)?;
    let range = mirror.range + target.range;
    acoustics.answers(range, -axis.dot(&target.normal), mirror.reflectance * target.reflectance).then_some(range)
}
