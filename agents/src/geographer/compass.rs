//! The four directions of a floor whose corridors meet at right angles.

use std::f64::consts::FRAC_PI_2;

use orienteer_runtime::{geometry::angle, topics::Way};
use serde::Serialize;

/// One of four directions, a quarter turn to the left of each other. The first is that of the first corridor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct Quarter(u8);

impl Quarter {
    /// All four.
    pub const ALL: [Self; 4] = [Self(0), Self(1), Self(2), Self(3)];

    /// The opposite direction.
    #[must_use]
    pub fn back(self) -> Self {
        self.turned(2)
    }

    /// Where a way leads, for who goes in this direction.
    #[must_use]
    pub fn toward(self, way: Way) -> Self {
        match way {
            Way::Left => self.turned(1),
            Way::Ahead => self,
            Way::Right => self.turned(3),
        }
    }

    /// Which way leads in a direction, for who goes in this one; `None` for the way back.
    #[must_use]
    pub fn way_to(self, direction: Self) -> Option<Way> {
        Way::ALL.into_iter().find(|way| self.toward(*way) == direction)
    }

    /// Its number, 0 to 3.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    fn turned(self, quarters: u8) -> Self {
        Self((self.0 + quarters) % 4)
    }
}

/// Directions and headings of one floor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Compass {
    /// Heading of the first direction, rad.
    first: f64,
}

impl Compass {
    /// A floor of which one corridor has this heading, rad.
    #[must_use]
    pub fn new(heading: f64) -> Self {
        Self { first: angle::wrap(heading) }
    }

    /// The heading of a direction, rad.
    #[must_use]
    pub fn heading(&self, quarter: Quarter) -> f64 {
        angle::wrap(self.first + f64::from(quarter.0) * FRAC_PI_2)
    }

    /// The direction that is nearest to a heading, rad.
    #[must_use]
    pub fn nearest(&self, heading: f64) -> Quarter {
        let quarters = (angle::turn(self.first, heading) / FRAC_PI_2).round() as i64;
        Quarter(quarters.rem_euclid(4) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_turned_with_the_robot() {
        let compass = Compass::new(0.3);
        for quarter in Quarter::ALL {
            assert_eq!(compass.nearest(compass.heading(quarter) + 0.5), quarter);
            assert_eq!(quarter.way_to(quarter.back()), None);
            for way in Way::ALL {
                assert_eq!(quarter.way_to(quarter.toward(way)), Some(way));
            }
        }
        assert_eq!(Quarter(3).toward(Way::Left), Quarter(0));
    }
}
