//! The four headings of a floor on which all corridors are straight and square to each other.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// A direction along a corridor, in the frame of the world: north is up on paper, toward larger y.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Heading {
    /// Along x, 0°.
    East,
    /// Along y, 90°.
    North,
    /// Against x, 180°.
    West,
    /// Against y, -90°.
    South,
}

impl Heading {
    /// All four, counter-clockwise from the x axis.
    pub const ALL: [Self; 4] = [Self::East, Self::North, Self::West, Self::South];

    /// After a quarter turn to the left.
    ///
    /// ```
    /// use orienteer_hardware::world::floors::Heading;
    /// assert_eq!(Heading::East.left(), Heading::North);
    /// assert_eq!(Heading::East.right(), Heading::South);
    /// assert_eq!(Heading::East.back(), Heading::West);
    /// ```
    #[must_use]
    pub const fn left(self) -> Self {
        match self {
            Self::East => Self::North,
            Self::North => Self::West,
            Self::West => Self::South,
            Self::South => Self::East,
        }
    }

    /// After half a turn.
    #[must_use]
    pub const fn back(self) -> Self {
        self.left().left()
    }

    /// After a quarter turn to the right.
    #[must_use]
    pub const fn right(self) -> Self {
        self.back().left()
    }

    /// Unit vector, exact.
    #[must_use]
    pub fn vector(self) -> Vector2<f64> {
        match self {
            Self::East => Vector2::new(1.0, 0.0),
            Self::North => Vector2::new(0.0, 1.0),
            Self::West => Vector2::new(-1.0, 0.0),
            Self::South => Vector2::new(0.0, -1.0),
        }
    }

    /// Counter-clockwise from the x axis, degrees.
    #[must_use]
    pub const fn degrees(self) -> f64 {
        match self {
            Self::East => 0.0,
            Self::North => 90.0,
            Self::West => 180.0,
            Self::South => -90.0,
        }
    }

    /// Counter-clockwise from the x axis, radians in `(-π, π]`.
    #[must_use]
    pub const fn radians(self) -> f64 {
        match self {
            Self::East => 0.0,
            Self::North => FRAC_PI_2,
            Self::West => PI,
            Self::South => -FRAC_PI_2,
        }
    }

    /// As in "from the north".
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::East => "east",
            Self::North => "north",
            Self::West => "west",
            Self::South => "south",
        }
    }
}
