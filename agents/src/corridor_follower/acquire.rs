//! Finding the walls where the follower starts, by vote.

use orienteer_runtime::robot_model::Ring;

use super::{
    CorridorFilter, Side,
    corridor_filter::{GRAZING, off_normal},
};

/// Walls farther away than this do not make a corridor, m.
const FARTHEST: f64 = 2.0;
/// Headings that are tried reach so far to either side, rad; beyond, the other direction of the corridor is nearer.
const WIDEST: f64 = 0.8;
/// Number of headings tried to each side.
const HEADINGS: i32 = 20;
/// A reading within this of what a wall would give supports it, m.
const FITS: f64 = 0.08;
/// What two beams that fit fairly well make; one alone may be anything.
const ENOUGH: f64 = 1.2;
/// What facing along the corridor is worth, against the widest heading tried.
const STRAIGHT: f64 = 0.8;

/// Finds a corridor around a robot that stands: from one range for each transducer (m, the greatest range if it hears nothing)
/// to the first estimate of a filter. `None` if no wall is near. In the middle of a corridor the robot has at least this much `room` to
/// either side of its centre, m.
///
/// Headings are tried one after another. For each, every beam that could hear a wall proposes one, and the others vote: for
/// it if they fit (`1 − (residual / 8 cm)²`), against it if they look through it. Furniture that one beam hears is thus
/// outvoted by the wall beside it, and a robot that has been turned aside finds its way back. The precondition that the robot
/// faces along the corridor (Randazza 1989, §3.1) enters as a slight preference.
pub(super) fn acquire(ring: &Ring, ranges: &[f64], room: f64) -> Option<CorridorFilter> {
    let mut best: Option<(f64, CorridorFilter)> = None;
    for n in -HEADINGS..=HEADINGS {
        let share = f64::from(n) / f64::from(HEADINGS);
        let heading = WIDEST * share;
        let walls = [Side::Left, Side::Right].map(|side| wall(ring, ranges, heading, side));
        let votes: f64 = walls.iter().flatten().map(|(votes, _)| votes).sum::<f64>() - STRAIGHT * share * share;
        if best.as_ref().is_some_and(|(most, _)| *most >= votes) {
            continue;
        }
        let [left, right] = walls.map(|wall| wall.map(|(_, distance)| distance));
        if let Some(filter) = CorridorFilter::new(left, right, heading, room) {
            best = Some((votes, filter));
        }
    }
    best.map(|(_, filter)| filter)
}

/// The wall on one side that has the most votes, if it has enough, and its distance from the robot's centre.
fn wall(ring: &Ring, ranges: &[f64], heading: f64, side: Side) -> Option<(f64, f64)> {
    let beams = || {
        ring.transducers.iter().zip(ranges).filter_map(|(transducer, range)| {
            let off = off_normal(heading + transducer.mount.heading, side);
            let grazing = (off.abs() - transducer.half_beam).max(0.0);
            let (sin, cos) = heading.sin_cos();
            let face = side.sign() * (transducer.mount.x * sin + transducer.mount.y * cos);
            (grazing <= GRAZING).then(|| (face, grazing.cos(), grazing == 0.0, *range))
        })
    };
    let proposals = beams().map(|(face, cos, _, range)| face + range * cos).filter(|distance| *distance < FARTHEST);
    let vote = |distance: f64| -> f64 {
        beams()
            .map(|(face, cos, perpendicular, range)| {
                let residual = range - (distance - face) / cos;
                if residual.abs() < FITS {
                    1.0 - (residual / FITS).powi(2)
                } else if residual > 0.0 && perpendicular {
                    -0.5
                } else {
                    0.0
                }
            })
            .sum()
    };
    let best = proposals.map(|distance| (vote(distance), distance)).max_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(votes, _)| *votes >= ENOUGH)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use orienteer_runtime::geometry::angle;
    use proptest::prelude::*;

    use super::{super::corridor_filter::fixtures, *};

    const ROOM: f64 = 0.55;

    fn ranges(e: f64, heading: f64, width: f64) -> Vec<f64> {
        let echo = |transducer| fixtures::range(transducer, e, heading, width).free_distance(7.0);
        fixtures::ring().transducers.iter().map(|transducer| f64::from(echo(transducer).unwrap())).collect()
    }

    proptest! {
        #[test]
        fn finds_a_corridor_however_the_robot_stands(e in -0.2..0.2f64, heading in -0.6..0.6f64, width in 1.12..2.5f64) {
            let filter = acquire(&fixtures::ring(), &ranges(e, heading, width), ROOM).unwrap();
            prop_assert!((filter.offset() - e).abs() < 0.1, "{} {e}", filter.offset());
            prop_assert!(angle::turn(filter.heading(), heading).abs() < 0.22, "{} {heading}", filter.heading());
            prop_assert!((filter.width() - width).abs() < 0.15, "{} {width}", filter.width());
        }

        #[test]
        fn one_thing_before_a_wall_does_not_matter(near in 0.2..0.5f64, beam in 0usize..16) {
            let mut ranges = ranges(0.0, 0.0, 1.8);
            ranges[beam] = near;
            let filter = acquire(&fixtures::ring(), &ranges, ROOM).unwrap();
            prop_assert!(filter.offset().abs() < 0.1 && (filter.width() - 1.8).abs() < 0.15, "{filter:?}");
        }
    }

    #[test]
    fn nothing_near_is_no_corridor() {
        assert!(acquire(&fixtures::ring(), &[7.0; 16], ROOM).is_none());
    }

    #[test]
    fn one_wall_is_enough() {
        let mut ranges = ranges(0.1, 0.0, 1.5);
        for (range, transducer) in ranges.iter_mut().zip(&fixtures::ring().transducers) {
            if transducer.mount.heading.sin() < -0.1 {
                *range = 7.0;
            }
        }
        let filter = acquire(&fixtures::ring(), &ranges, ROOM).unwrap();
        assert!((0.5 * filter.width() - filter.offset() - 0.65).abs() < 0.05, "{filter:?}");
    }
}
