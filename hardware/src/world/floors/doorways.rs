//! Doorways and the rooms behind them.

use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt, seq::SliceRandom};

use super::{
    Doorway, FloorSpec, Heading,
    layout::{cm, xy},
    mm,
};
use crate::world::{
    geometry::Bounds,
    plan::{self, Door},
};

/// Thickness of the wall between corridor and room, m: Randazza (1989) measured 14 cm.
pub(super) const WALL: f64 = 0.14;
/// Rooms are so deep, and reach so far behind the edge, m. Either leaves room to drive round the edge.
const ROOM: std::ops::RangeInclusive<f64> = 2.0..=3.0;

/// Where a doorway opens in a corridor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Opening {
    /// On the corridor's centre line, amid the jambs.
    pub at: Point2<f64>,
    /// The corridor from wall to wall, m.
    pub corridor: f64,
    /// From jamb to jamb, m.
    pub width: f64,
    /// Of the wall between corridor and room, m.
    pub thickness: f64,
}

/// A room that begins at a doorway.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    pub doorway: Doorway,
    pub ground: Bounds,
}

impl Opening {
    /// The doorway on this side with its edge toward `edge`, and its room, `depth` m deep from the wall on and reaching
    /// `behind` m beyond the edge.
    pub fn room(&self, side: Heading, edge: Heading, depth: f64, behind: f64) -> Room {
        let (out, along) = (side.vector(), edge.vector());
        let in_wall = self.at + out * (0.5 * self.corridor);
        let corner = in_wall + out * self.thickness - along * (0.5 * self.width);
        let opposite = corner + out * depth + along * (self.width + behind);
        let doorway =
            Doorway { at: xy(in_wall).0, side, width: mm(self.width), edge, corner: edge.back(), thickness: mm(self.thickness) };
        Room { doorway, ground: Bounds { min: corner.inf(&opposite), max: corner.sup(&opposite) } }
    }

    /// One of the six kinds of doorway along a corridor that leads toward `along`, with rooms that keep off `taken` ground;
    /// `None` if no kind has room.
    pub fn draw(&self, along: Heading, taken: &[Bounds], random: &mut impl Rng) -> Option<Vec<Room>> {
        let (right, left, back) = (along.right(), along.left(), along.back());
        let mut kinds: [&[(Heading, Heading)]; 6] = [
            &[(right, along)],
            &[(right, back)],
            &[(left, along)],
            &[(left, back)],
            &[(left, along), (right, back)],
            &[(left, back), (right, along)],
        ];
        kinds.shuffle(random);
        let mut size = || cm(random.random_range(ROOM));
        let sizes = [(size(), size()), (*ROOM.start(), *ROOM.start())];
        let built = sizes.iter().flat_map(|(depth, behind)| {
            kinds.map(|kind| kind.iter().map(|(side, edge)| self.room(*side, *edge, *depth, *behind)).collect::<Vec<_>>())
        });
        built.into_iter().find(|rooms| rooms.iter().all(|room| taken.iter().all(|other| apart(&room.ground, other))))
    }
}

impl Room {
    /// As a world has it.
    pub fn plan(&self) -> plan::Room {
        let wall = Point2::from(self.doorway.at) + self.doorway.side.vector() * self.doorway.thickness;
        let door = Door { at: xy(wall), width: self.doorway.width, open: true };
        plan::Room { name: None, corners: vec![xy(self.ground.min), xy(self.ground.max)], doors: vec![door], reflectance: 1.0 }
    }
}

/// How far along a piece of corridor doorways are, from its beginning, m.
///
/// `from` and `to` are the mouths at its ends. Between any two mouths, those of the doorways included, the gap of the
/// specification is left; what is left beyond that is dealt out at random.
pub(super) fn along(from: f64, to: f64, spec: &FloorSpec, random: &mut impl Rng) -> Vec<f64> {
    /// What rounding to centimetres may take away from a gap, m.
    const ROUNDING: f64 = 0.01;
    let step = spec.gap + ROUNDING + spec.door_width;
    let room = to - from - spec.gap - ROUNDING;
    let slots = (room / step).floor().max(0.0) as u32;
    let count = (0..slots).filter(|_| random.random_bool(spec.doors)).count();
    let spare = room - count as f64 * step;
    let mut shifts: Vec<f64> = (0..count).map(|_| spare * random.random::<f64>()).collect();
    shifts.sort_by(f64::total_cmp);
    let at = |(i, shift): (usize, f64)| cm(from + 0.5 * ROUNDING + spec.gap + 0.5 * spec.door_width + i as f64 * step + shift);
    shifts.into_iter().enumerate().map(at).collect()
}

/// True if a wall stands between the two.
fn apart(a: &Bounds, b: &Bounds) -> bool {
    let grown = a.grown(WALL);
    let clear = |v: Vector2<f64>| v.x > -1e-9 || v.y > -1e-9;
    clear(grown.min - b.max) || clear(b.min - grown.max)
}
