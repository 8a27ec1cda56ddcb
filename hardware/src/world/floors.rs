//! Floors of straight corridors that meet at right angles, made from a seed, and what is true of them.
//!
//! [`Floor::generate`] makes a connected floor of any size; [`junction_world`] makes a single place of any kind, to measures.
//! Both come as a world's plan and text, which loads like any other world, and with the ground truth that a robot's own account of
//! it can be held against.
//!
//! # How a floor is made
//!
//! 1. **Grid.** All neighbours in a grid of crossings are joined; then edges are taken away in random order, as long as all stays
//!    connected.
//! 2. **Measures.** Columns and rows get their distances, straight corridors their widths.
//! 3. **Doorways.** Where a corridor is long enough, doorways open beside it, with rooms that keep off everything else.
//! 4. **Furniture and people.** Boxes stand against the walls, people walk up and down, both away from the places.
//!
//! Every step has a random stream of its own, so more boxes don't move a wall. Same seed and specification: same floor, byte
//! for byte, on every machine.
//!
//! # What a place is
//!
//! A place is where corridors meet or end, or where doorways open. *What* it is depends on where a robot comes from, so each
//! [`Arm`] of a place says what it [`meets`](Arm::meets): one of the twelve [hypotheses](Hypothesis) of Randazza (1989), or a
//! dead end.

mod doorways;
mod frame;
mod furniture;
mod generate;
mod grid;
mod heading;
mod hypothesis;
mod junction;
mod layout;
mod place;
mod rounds;
mod sketch;
mod spec;
mod text;

use serde::{Deserialize, Serialize};

pub use frame::{HypothesisFrame, NEAR_LINE};
pub use heading::Heading;
pub use hypothesis::{Flank, Hypothesis, View};
pub use junction::{JunctionWorld, MOST_PERTURBED, Perturbation, junction_world};
pub use place::{Arm, Doorway, Place};
pub use spec::{FloorError, FloorSpec, MOST_LINES, Width};

use super::plan::WorldPlan;

/// A floor: a world, and what is true of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    /// The world.
    pub plan: WorldPlan,
    /// What is true of it.
    pub truth: Truth,
    /// Corridors as lines and places by their numbers; empty if the floor is too wide for a text.
    pub sketch: String,
}

/// What is true of a floor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// The floor's name.
    pub name: String,
    /// What it was made from, with [`spec`](Truth::spec).
    pub seed: u64,
    /// The specification, with the columns and rows that have been chosen.
    pub spec: FloorSpec,
    /// All places, numbered from the north-west as one reads.
    pub places: Vec<Place>,
    /// All corridors from place to place.
    pub corridors: Vec<Corridor>,
}

/// A corridor between two places, straight and without another place on its way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Corridor {
    /// Its western or southern end.
    pub from: CorridorEnd,
    /// Its eastern or northern end.
    pub to: CorridorEnd,
    /// From the middle of one place to that of the other, m.
    pub length: f64,
    /// From wall to wall, m.
    pub width: f64,
}

/// Where a corridor ends.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CorridorEnd {
    /// Name of the place.
    pub place: String,
    /// The arm of the place that this corridor is.
    pub arm: Heading,
}

impl Floor {
    /// Makes a floor.
    ///
    /// # Errors
    /// [`FloorError`] if the specification asks for what can't be.
    ///
    /// ```
    /// use orienteer_hardware::world::{World, floors::{Floor, FloorSpec}, plan::WorldPlan};
    /// let floor = Floor::generate(7, &FloorSpec { places: Some(10), ..FloorSpec::default() })?;
    /// assert!(floor.truth.places.len() >= 10);
    /// let world = World::from_plan(&WorldPlan::parse(&floor.text())?, &|_| unreachable!())?;
    /// assert!(world.place("p1").is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn generate(seed: u64, spec: &FloorSpec) -> Result<Self, FloorError> {
        spec.check()?;
        generate::floor(seed, spec)
    }

    /// The world as a file that people can read and change.
    #[must_use]
    pub fn text(&self) -> String {
        text::floor(self)
    }
}

impl Truth {
    /// The place with this name.
    #[must_use]
    pub fn place(&self, name: &str) -> Option<&Place> {
        self.places.iter().find(|place| place.name == name)
    }
}

/// Rounds to whole millimetres, so that every coordinate is as short in a file as it is in memory.
fn mm(length: f64) -> f64 {
    // Adding 0 turns -0 into 0.
    (1000.0 * length).round() / 1000.0 + 0.0
}
