//! Is that a wall? Two questions to a ring (Randazza 1989, §4.3).

use orienteer_runtime::topics::Side;

use crate::clock_ring::{ClockRing, DIRECTIONS};

/// A wall beside the robot is no farther than this from the sonar's face, m.
const BESIDE: f64 = 0.80;
/// Contiguous readings that make a wall ahead.
const CONTIGUOUS: usize = 4;
/// Two ranges are about equal within this, m.
const ABOUT_EQUAL: f64 = 0.20;
/// Readings from here on are no echo, m.
const SATURATED: f64 = 7.57;

/// The transducer that looks straight to a side.
#[must_use]
pub fn abeam(side: Side) -> usize {
    match side {
        Side::Left => 12,
        Side::Right => 4,
    }
}

/// What a ring says of a wall beside the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beside {
    /// There is one.
    Wall,
    /// What is beside is too far away.
    Far,
    /// The ranges do not rise to either side of the nearest, as those to a wall do.
    Rugged,
}

/// Is there a wall on that side, near by? The ranges must rise to both sides of the nearest over three directions at least, and
/// straight to the side there must be something near.
#[must_use]
pub fn wall_beside(ring: &ClockRing, side: Side) -> Beside {
    let (first, last) = (abeam(side) - 2, abeam(side) + 2);
    let nearest = (first..=last).fold(first, |nearest, i| if ring[i] < ring[nearest] { i } else { nearest });
    let falls = (first + 1..=nearest).rev().take_while(|i| ring[i - 1] >= ring[*i]).count();
    let rises = (nearest + 1..=last).take_while(|i| ring[*i] >= ring[i - 1]).count();
    if falls + rises + 1 < 3 {
        Beside::Rugged
    } else if ring[abeam(side)] < BESIDE {
        Beside::Wall
    } else {
        Beside::Far
    }
}

/// Is there a wall ahead, however far? Four neighbours of a [double ring](crate::clock_ring::double) within 56° of ahead must follow each
/// other closely, and what is straight ahead must be about as near as the nearest of them, lest a corner beside an opening be taken for
/// a wall.
#[must_use]
pub fn wall_ahead(double: &[f64; 2 * DIRECTIONS]) -> bool {
    let (mut last, mut count, mut smallest) = (-ABOUT_EQUAL, 1, f64::INFINITY);
    for range in double[27..].iter().chain(&double[..6]).copied() {
        if (range - last).abs() <= ABOUT_EQUAL && last < SATURATED {
            count += 1;
            smallest = f64::min(smallest, range);
        } else {
            (count, smallest) = (1, f64::INFINITY);
        }
        if count == CONTIGUOUS && (double[0] - smallest).abs() <= ABOUT_EQUAL {
            return true;
        }
        last = range;
    }
    false
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Ranges to straight walls in these directions (clock angle, rad) at these distances from the faces; beams of ±12° that hear the
    /// nearest ray, up to 30° from the normal.
    fn ring(walls: &[(f64, f64)], turned: f64) -> ClockRing {
        std::array::from_fn(|i| {
            let bearing = crate::clock_ring::STEP * i as f64 + turned;
            let range = |(wall, distance): &(f64, f64)| {
                let off = (bearing - wall + PI).rem_euclid(2.0 * PI) - PI;
                let incidence = (off.abs() - 12f64.to_radians()).max(0.0);
                if incidence < 30f64.to_radians() { distance / incidence.cos() } else { 7.77 }
            };
            walls.iter().map(range).fold(7.77, f64::min)
        })
    }

    #[test]
    fn a_wall_beside_is_one_up_to_80_centimetres() {
        for (distance, expected) in [(0.2, Beside::Wall), (0.79, Beside::Wall), (0.81, Beside::Far), (3.0, Beside::Far)] {
            assert_eq!(wall_beside(&ring(&[(0.5 * PI, distance)], 0.0), Side::Right), expected, "{distance} m");
            assert_eq!(wall_beside(&ring(&[(1.5 * PI, distance)], 0.0), Side::Left), expected, "{distance} m");
        }
        assert_eq!(wall_beside(&ring(&[(0.5 * PI, 0.4)], 0.0), Side::Left), Beside::Far);
    }

    #[test]
    fn a_ragged_thing_beside_is_no_wall() {
        let mut ring = [0.7; DIRECTIONS];
        // The nearest is at the window's edge, and what is next to it is nearer than what follows.
        (ring[2], ring[3], ring[4], ring[5], ring[6]) = (0.3, 0.6, 0.5, 0.6, 0.5);
        assert_eq!(wall_beside(&ring, Side::Right), Beside::Rugged);
    }

    #[test]
    fn a_wall_ahead_is_seen_from_20_centimetres_to_740() {
        for n in 0..=72 {
            let wall = [(0.0, 0.20 + 0.1 * f64::from(n))];
            let both = crate::clock_ring::double(&ring(&wall, 0.0), &ring(&wall, 0.5 * crate::clock_ring::STEP));
            assert!(wall_ahead(&both), "{} m", wall[0].1);
        }
    }

    #[test]
    fn an_opening_ahead_with_a_corner_beside_it_is_no_wall() {
        let mut both = [7.77; 2 * DIRECTIONS];
        // A corner 35° to the left is heard by four neighbours.
        for range in &mut both[28..32] {
            *range = 0.9;
        }
        assert!(!wall_ahead(&both));
        both[0] = 1.0;
        assert!(wall_ahead(&both), "that would be a wall");
    }
}
