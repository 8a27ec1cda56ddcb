//! What stands in corridors, and who walks there.

use nalgebra::Point2;
use rand::{Rng, RngExt};

use super::{
    FloorSpec, Heading,
    layout::{cm, xy},
    mm,
    spec::SHALLOWEST_BOX,
};
use crate::world::plan::{Block, Courtesy, Loop, Person};

/// Boxes are so long, m.
const LENGTH: std::ops::RangeInclusive<f64> = 0.6..=1.2;
/// No box is deeper, m; so the long side is always at the wall.
const DEEPEST: f64 = 0.5;

/// A corridor from the mouth of one place to that of the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passage {
    /// Where it begins, on its centre line.
    pub from: Point2<f64>,
    /// Where it leads.
    pub heading: Heading,
    /// From mouth to mouth, m.
    pub length: f64,
    /// From wall to wall, m.
    pub width: f64,
}

/// A box against a wall.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crate {
    /// The heading out of the corridor, through that wall.
    side: Heading,
    /// How far along the passage its middle is, m.
    at: f64,
    length: f64,
    depth: f64,
}

impl Crate {
    /// A box in the passage, if the specification has one there and there is room.
    pub fn draw(passage: &Passage, spec: &FloorSpec, random: &mut impl Rng) -> Option<Self> {
        let (wanted, left) = (random.random_bool(spec.boxes), random.random_bool(0.5));
        let [length, depth, place]: [f64; 3] = std::array::from_fn(|_| random.random());
        let deepest = DEEPEST.min(0.5 * passage.width - spec.berth);
        let length = cm(LENGTH.start() + length * (LENGTH.end() - LENGTH.start()));
        let room = passage.length - 2.0 * spec.clear - length;
        if !wanted || room < 0.0 || deepest < SHALLOWEST_BOX - 1e-9 {
            return None;
        }
        // Whole centimetres, and never a millimetre deeper than the berth allows.
        let depth = (100.0 * (SHALLOWEST_BOX + depth * (deepest - SHALLOWEST_BOX)) + 1e-6).floor() / 100.0;
        let side = if left { passage.heading.left() } else { passage.heading.right() };
        Some(Self { side, at: spec.clear + 0.5 * length + place * room, length, depth })
    }

    /// As a world has it.
    pub fn plan(&self, passage: &Passage) -> Block {
        let off = 0.5 * (passage.width - self.depth);
        let center = passage.from + passage.heading.vector() * self.at + self.side.vector() * off;
        let size = match passage.heading {
            Heading::East | Heading::West => [self.length, self.depth],
            Heading::North | Heading::South => [self.depth, self.length],
        };
        Block { name: None, center: xy(center), size: size.map(mm), rotation_deg: 0.0, reflectance: 1.0 }
    }
}

/// The way along a passage, in the middle of what a box leaves of it.
pub(super) fn way_along(passage: &Passage, past: Option<&Crate>) -> [Point2<f64>; 2] {
    let aside = past.map_or(nalgebra::Vector2::zeros(), |it| it.side.vector() * (-0.5 * it.depth));
    let from = passage.from + aside;
    [from, from + passage.heading.vector() * passage.length]
}

/// Somebody who walks there.
pub(super) fn walker(path: &[Point2<f64>], looping: Loop, random: &mut impl Rng) -> Person {
    let length: f64 = path.windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum();
    Person {
        name: None,
        radius: 0.25,
        path: path.iter().copied().map(xy).collect(),
        speed: cm(random.random_range(0.4..=0.9)),
        speed_variation: 0.1,
        looping,
        pause: cm(random.random_range(0.0..=5.0)),
        start: cm(random.random_range(0.0..=length)),
        courtesy: Courtesy::Stops,
        patience: Some(15.0),
    }
}
