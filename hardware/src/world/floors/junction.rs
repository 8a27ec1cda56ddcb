//! One place of each kind, alone and to measures.

use nalgebra::Point2;
use orienteer_runtime::geometry::Pose;
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::{
    Flank, FloorError, Heading, Hypothesis, NEAR_LINE, Place,
    doorways::{Opening, Room, WALL},
    layout::corridor,
    mm,
    spec::within,
    text,
};
use crate::world::plan::{self, WorldPlan, Xy};

/// A measure is perturbed by at most this share.
pub const MOST_PERTURBED: f64 = 0.1;
/// Half the width of corridors and openings, m (Randazza 1989).
const HALF: f64 = 0.56;
/// Corridors lead so far away from the place that no sonar hears their ends, m.
const STUB: f64 = 12.0;
/// How deep rooms are, and how far they reach behind the edge, m.
const ROOM: f64 = 3.0;
/// Where a robot begins that shall come along the corridor first, m before the start pose.
const APPROACH: f64 = 6.0;

/// Factors by which measures differ from the hypothesis; each within 0.9 to 1.1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Perturbation {
    /// Width of the corridor that leads to the place and goes on ahead.
    pub corridor: f64,
    /// Width of what opens beside it.
    pub opening: f64,
    /// Thickness of the walls between corridor and rooms, which is that of edges.
    pub wall: f64,
    /// Length of corridors and rooms.
    pub length: f64,
}

impl Perturbation {
    /// Everything as the hypothesis has it.
    pub const NONE: Self = Self { corridor: 1.0, opening: 1.0, wall: 1.0, length: 1.0 };

    /// Draws each factor between `1 - share` and `1 + share`; no share is larger than [`MOST_PERTURBED`].
    pub fn draw(share: f64, random: &mut impl Rng) -> Self {
        let share = if share >= 0.0 { share.min(MOST_PERTURBED) } else { 0.0 };
        let [corridor, opening, wall, length] = std::array::from_fn(|_| 1.0 + share * (2.0 * random.random::<f64>() - 1.0));
        Self { corridor, opening, wall, length }
    }

    fn check(&self) -> Result<(), FloorError> {
        let Self { corridor, opening, wall, length } = *self;
        let factors = [
            ("the factor of the corridor's width", corridor),
            ("the factor of the opening's width", opening),
            ("the factor of the wall's thickness", wall),
            ("the factor of lengths", length),
        ];
        // Rounding may take a factor a little beyond.
        let [least, most] = [1.0 - MOST_PERTURBED - 1e-9, 1.0 + MOST_PERTURBED + 1e-9];
        factors.into_iter().try_for_each(|(key, value)| within(key, value, least, most))
    }
}

/// A world with a single place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JunctionWorld {
    /// What a robot meets that comes from the south.
    pub hypothesis: Hypothesis,
    /// How far its measures differ from those of the hypothesis.
    pub perturbation: Perturbation,
    /// The robot's start pose: the origin, heading north. m and rad.
    pub start: Pose,
    /// The place.
    pub place: Place,
    /// The world; its places are `start` and `approach`, 6 m before it.
    #[serde(skip)]
    pub plan: WorldPlan,
}

impl JunctionWorld {
    /// The world as a file that people can read and change.
    #[must_use]
    pub fn text(&self) -> String {
        text::junction(self)
    }
}

/// The reference world of a hypothesis (Randazza 1989, appendix A): a single place with the robot's start pose at the origin, x to its
/// right and y ahead, in metres.
///
/// Unperturbed, the walls of the corridor are at x = ±0.56, the near line of the place at y = 0.08 and its far line at y = 1.20.
/// Walls of branches and rooms lie along these lines; an edge is a wall 14 cm thick with a room behind it. Corridors are 12 m long,
/// measured from the middle of the place, further than sonars hear.
///
/// # Errors
/// [`FloorError::Range`] if a factor is not within 0.9 to 1.1.
///
/// ```
/// use orienteer_hardware::world::{World, floors::{Hypothesis, Perturbation, junction_world}};
/// let junction = junction_world(Hypothesis::H2, &Perturbation::NONE)?;
/// let world = World::from_plan(&junction.plan, &|_| unreachable!())?;
/// let corner = nalgebra::Point2::new(0.56, 0.08);
/// assert!(world.outline.vertices.iter().any(|vertex| vertex.at == corner));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn junction_world(hypothesis: Hypothesis, perturbation: &Perturbation) -> Result<JunctionWorld, FloorError> {
    perturbation.check()?;
    let measures = Measures::of(hypothesis, perturbation);
    let rooms = measures.rooms();
    let doorways = rooms.iter().map(|room| room.doorway).collect();
    // None of the thirteen views is refused.
    let Some(mut place) = Place::new(measures.middle, &measures.arms(), doorways) else { return Err(FloorError::TooSmall) };
    place.name = hypothesis.id().to_owned();
    let start = Pose::new(0.0, 0.0, Heading::North.radians());
    let named = |name: &str, y: f64| plan::Place { name: name.to_owned(), at: Xy([0.0, y]), heading_deg: 90.0 };
    let plan = WorldPlan {
        name: format!("{hypothesis}: {}", hypothesis.title()),
        corridor: measures.corridors(),
        room: rooms.iter().map(Room::plan).collect(),
        place: vec![named("start", 0.0), named("approach", -APPROACH)],
        ..WorldPlan::default()
    };
    Ok(JunctionWorld { hypothesis, perturbation: *perturbation, start, place, plan })
}

/// A hypothesis in metres.
struct Measures {
    hypothesis: Hypothesis,
    middle: Point2<f64>,
    /// Half the corridor's width.
    corridor: f64,
    /// Half the width of what opens beside it.
    opening: f64,
    wall: f64,
    stub: f64,
    room: f64,
}

impl Measures {
    fn of(hypothesis: Hypothesis, perturbation: &Perturbation) -> Self {
        let corridor = mm(HALF * perturbation.corridor);
        let opening = mm(HALF * perturbation.opening);
        let ahead = if hypothesis == Hypothesis::DeadEnd { 0.0 } else { NEAR_LINE + opening };
        let [wall, stub, room] = [WALL * perturbation.wall, STUB * perturbation.length, ROOM * perturbation.length].map(mm);
        Self { hypothesis, middle: Point2::new(0.0, ahead), corridor, opening, wall, stub, room }
    }

    /// What is on either side.
    fn flanks(&self) -> [(Heading, Flank); 2] {
        let view = self.hypothesis.view();
        [(Heading::East, view.right), (Heading::West, view.left)]
    }

    /// Corridors that lead away, counter-clockwise from the east, each with its width and mouth.
    fn arms(&self) -> Vec<(Heading, f64, f64)> {
        let [(_, right), (_, left)] = self.flanks();
        let across = |heading| (heading, 2.0 * self.opening, self.corridor);
        let mouth = if self.hypothesis == Hypothesis::DeadEnd { self.corridor } else { self.opening };
        let along = |heading| (heading, 2.0 * self.corridor, mouth);
        let arms = [
            (right == Flank::Corridor).then(|| across(Heading::East)),
            self.hypothesis.view().ahead.then(|| along(Heading::North)),
            (left == Flank::Corridor).then(|| across(Heading::West)),
            Some(along(Heading::South)),
        ];
        arms.into_iter().flatten().collect()
    }

    /// One corridor from south to north, and one across if any branches off.
    fn corridors(&self) -> Vec<plan::Corridor> {
        let arms = self.arms();
        let reach = |heading: Heading, otherwise: f64| {
            let open = arms.iter().any(|(arm, ..)| *arm == heading);
            self.middle + heading.vector() * if open { self.stub } else { otherwise }
        };
        // Without a corridor ahead, the far line of the place is its end wall.
        let end = if self.hypothesis == Hypothesis::DeadEnd { self.corridor } else { self.opening };
        let along = corridor(reach(Heading::South, 0.0), reach(Heading::North, end), 2.0 * self.corridor);
        let branches = self.flanks().iter().any(|(_, flank)| *flank == Flank::Corridor);
        let across = || corridor(reach(Heading::West, self.corridor), reach(Heading::East, self.corridor), 2.0 * self.opening);
        [Some(along), branches.then(across)].into_iter().flatten().collect()
    }

    /// The rooms behind doorways.
    fn rooms(&self) -> Vec<Room> {
        let opening = Opening { at: self.middle, corridor: 2.0 * self.corridor, width: 2.0 * self.opening, thickness: self.wall };
        let room = |(side, flank): (Heading, Flank)| {
            let edge = match flank {
                Flank::CornerThenEdge => Heading::North,
                Flank::EdgeThenCorner => Heading::South,
                Flank::Wall | Flank::Corridor => return None,
            };
            Some(opening.room(side, edge, self.room, self.room))
        };
        self.flanks().into_iter().filter_map(room).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use orienteer_runtime::random::Streams;

    use super::*;

    #[test]
    fn each_is_what_it_is_called() {
        for hypothesis in Hypothesis::ALL {
            let junction = junction_world(hypothesis, &Perturbation::NONE).unwrap();
            assert_eq!(junction.place.seen_from(Heading::South), Some(hypothesis));
            assert_eq!(junction.place.arm(Heading::South).unwrap().start, junction.start, "{hypothesis}");
        }
    }

    #[test]
    fn a_perturbation_stays_within_its_share() {
        let mut random = Streams::new(5).stream("junction", "perturbation");
        for share in [0.0, 0.05, 0.1, 7.0, f64::NAN] {
            let perturbation = Perturbation::draw(share, &mut random);
            assert_eq!(perturbation.check(), Ok(()), "{perturbation:?}");
            let Perturbation { corridor, opening, wall, length } = perturbation;
            let most = if share > 0.0 { share } else { 0.0 };
            assert!([corridor, opening, wall, length].iter().all(|factor| (factor - 1.0).abs() <= most));
        }
        for factor in [0.8, 1.2, f64::NAN] {
            assert!(junction_world(Hypothesis::H1, &Perturbation { wall: factor, ..Perturbation::NONE }).is_err());
        }
    }
}
