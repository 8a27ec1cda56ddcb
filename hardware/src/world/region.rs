//! Sets of points with polygonal borders, and what can be done with them: union and difference.
//!
//! All coordinates are whole micrometres. Boolean operations on such a grid are exact decisions on integers, so they come out
//! the same on every machine, and a wall written at 1.8 m is at 1.8 m afterwards: `1_800_000 / 1e6` is the double nearest to
//! 1.8. Where slanted edges cross, the crossing is rounded to the grid; [`Region::rings`] takes out the slivers, a few
//! micrometres thin, that this can leave.

use i_overlay::{
    core::{fill_rule::FillRule, overlay::Overlay, overlay_rule::OverlayRule},
    i_float::int::point::IntPoint,
};
use nalgebra::Point2;

/// Micrometres in a metre.
const SCALE: f64 = 1e6;
/// Detail thinner than this is an artefact of rounding, µm.
const SLIVER: f64 = 20.0;
/// Largest coordinate, m, for which every intermediate result of the overlay fits its integers.
pub(super) const REACH: f64 = 1000.0;

/// A closed line, m.
pub(super) type Ring = Vec<Point2<f64>>;
type Contour = Vec<IntPoint<i32>>;

/// A set of points in the plane. Its contours have the inside on their left.
#[derive(Debug, Clone, Default)]
pub(super) struct Region {
    contours: Vec<Contour>,
}

impl Region {
    /// Everything inside at least one of the rings, in whichever direction each of them runs.
    pub(super) fn covered_by<'a>(rings: impl IntoIterator<Item = &'a Ring>) -> Self {
        let contours = rings.into_iter().map(|ring| {
            let mut contour = to_grid(ring);
            if doubled_area(&contour) < 0 {
                contour.reverse();
            }
            contour
        });
        Self { contours: combine(&contours.collect::<Vec<_>>(), &[], OverlayRule::Subject) }
    }

    /// The inside of rings that already run the right way round: counter-clockwise about matter, clockwise about holes.
    /// Where rings of a thin wall cross each other, what lies between them belongs to the region.
    pub(super) fn bordered_by(rings: &[Ring]) -> Self {
        let contours: Vec<Contour> = rings.iter().map(|ring| to_grid(ring)).collect();
        Self { contours: combine(&contours, &[], OverlayRule::Subject) }
    }

    pub(super) fn union(&self, other: &Self) -> Self {
        Self { contours: combine(&self.contours, &other.contours, OverlayRule::Union) }
    }

    pub(super) fn minus(&self, other: &Self) -> Self {
        Self { contours: combine(&self.contours, &other.contours, OverlayRule::Difference) }
    }

    /// The border in metres, inside on the left, without slivers.
    pub(super) fn rings(&self) -> Vec<Ring> {
        let back = |p: &IntPoint<i32>| Point2::new(f64::from(p.x) / SCALE, f64::from(p.y) / SCALE);
        self.contours.iter().map(|c| without_slivers(c)).filter(|c| c.len() > 2).map(|c| c.iter().map(back).collect()).collect()
    }
}

fn combine(subject: &[Contour], clip: &[Contour], rule: OverlayRule) -> Vec<Contour> {
    if subject.is_empty() && clip.is_empty() {
        return Vec::new();
    }
    Overlay::from_subj_and_clip(subject, clip).overlay(rule, FillRule::NonZero).into_iter().flatten().collect()
}

fn to_grid(ring: &[Point2<f64>]) -> Contour {
    // The plan has been checked to lie within reach; the cast saturates whatever else comes.
    let grid = |v: f64| (v.clamp(-REACH, REACH) * SCALE).round() as i32;
    ring.iter().map(|p| IntPoint::new(grid(p.x), grid(p.y))).collect()
}

fn doubled_area(contour: &[IntPoint<i32>]) -> i128 {
    let wide = |p: &IntPoint<i32>| (i128::from(p.x), i128::from(p.y));
    let next = contour.iter().cycle().skip(1);
    contour.iter().zip(next).map(|(a, b)| (wide(a), wide(b))).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum()
}

/// Drops every corner whose triangle with its neighbours is thinner than [`SLIVER`], until none is left: points on a straight
/// line, spikes and slits of no width.
fn without_slivers(contour: &[IntPoint<i32>]) -> Contour {
    let mut kept = contour.to_vec();
    let mut i = 0;
    let mut since_change = 0;
    while kept.len() > 2 && since_change < kept.len() {
        let n = kept.len();
        i %= n;
        if thinness(kept[(i + n - 1) % n], kept[i], kept[(i + 1) % n]) < SLIVER {
            kept.remove(i);
            since_change = 0;
            i = (i + kept.len() - 1) % kept.len().max(1);
        } else {
            since_change += 1;
            i += 1;
        }
    }
    kept
}

/// Smallest height of a triangle, µm.
fn thinness(a: IntPoint<i32>, b: IntPoint<i32>, c: IntPoint<i32>) -> f64 {
    let side = |p: IntPoint<i32>, q: IntPoint<i32>| f64::from(q.x - p.x).hypot(f64::from(q.y - p.y));
    let longest = side(a, b).max(side(b, c)).max(side(c, a));
    let (ux, uy) = (f64::from(b.x - a.x), f64::from(b.y - a.y));
    let (vx, vy) = (f64::from(c.x - a.x), f64::from(c.y - a.y));
    if longest > 0.0 { (ux * vy - uy * vx).abs() / longest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Ring {
        points.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    #[test]
    fn coordinates_come_back_as_they_were_written() {
        let square = ring(&[(0.1, 0.2), (1.8, 0.2), (1.8, 2.46), (0.1, 2.46)]);
        let back = Region::covered_by([&square]).rings();
        assert_eq!(back.len(), 1);
        assert!(square.iter().all(|p| back[0].contains(p)), "{back:?}");
    }

    #[test]
    fn a_slit_of_a_micrometre_is_no_slit() {
        let left = ring(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        let right = ring(&[(1.000_002, 0.0), (2.0, 0.0), (2.0, 1.0), (1.000_002, 1.0)]);
        let floor = ring(&[(0.0, -1.0), (2.0, -1.0), (2.0, 0.1), (0.0, 0.1)]);
        let rings = Region::covered_by([&left, &right, &floor]).rings();
        assert_eq!(rings.iter().map(Vec::len).collect::<Vec<_>>(), [4], "{rings:?}");
    }

    #[test]
    fn crossing_sides_of_a_thin_wall_leave_it_closed() {
        // The hole sticks out of the outer ring on the right: the wall must not open there.
        let outer = ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]);
        let hole = ring(&[(0.1, 0.1), (0.1, 3.9), (4.1, 3.9), (4.1, 0.1)]);
        let rings = Region::bordered_by(&[outer, hole]).rings();
        let sides = rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
        let crossed: Vec<f64> = sides.filter(|(a, b)| (a.y < 2.0) != (b.y < 2.0) && a.x > 2.0).map(|(a, _)| a.x).collect();
        assert_eq!(crossed.len(), 2, "from the middle to the right, into the wall and out of it: {rings:?}");
    }
}
