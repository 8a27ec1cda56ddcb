//! Where everybody stood at the end of the previous step, and who of them is near a robot.

use nalgebra::Point2;

use crate::{
    echo::{self, PERSON_REFLECTANCE},
    world::{disc_grid::DiscGrid, geometry::Disc},
};

/// How much of the sound a robot's shell sends back.
const ROBOT_REFLECTANCE: f64 = 1.0;

/// Everybody as they stood at the end of the previous step.
#[derive(Debug, Clone, Default)]
pub struct Bodies {
    pub(super) robots: DiscGrid,
    pub(super) people: DiscGrid,
}

/// The others about one robot, looked up again and again in the same memory.
#[derive(Debug, Clone)]
pub(super) struct Others<T> {
    /// Robots in the order in which they came, then people.
    found: Vec<T>,
    numbers: Vec<u32>,
}

impl Bodies {
    /// Robots, in the order in which they came.
    #[must_use]
    pub fn robots(&self) -> &[Disc] {
        self.robots.discs()
    }

    /// People, in the order of the world's plan.
    #[must_use]
    pub fn people(&self) -> &[Disc] {
        self.people.discs()
    }
}

impl<T> Default for Others<T> {
    fn default() -> Self {
        // Ample, so that nothing grows in the middle of a run.
        Self { found: Vec::with_capacity(16), numbers: Vec::with_capacity(16) }
    }
}

impl Others<Disc> {
    /// Looks up who is within `reach` of a point, except robot `own`.
    pub fn look(&mut self, bodies: &Bodies, own: usize, at: Point2<f64>, reach: f64) {
        self.look_as(bodies, own, at, reach, |disc, _| disc);
    }
}

impl Others<echo::Disc> {
    /// Looks up who can be heard within `reach` of a point, except robot `own`.
    pub fn listen(&mut self, bodies: &Bodies, own: usize, at: Point2<f64>, reach: f64) {
        self.look_as(bodies, own, at, reach, |disc, is_robot| {
            let reflectance = if is_robot { ROBOT_REFLECTANCE } else { PERSON_REFLECTANCE };
            echo::Disc { centre: disc.center, radius: disc.radius, reflectance }
        });
    }
}

impl<T> Others<T> {
    /// Who was found.
    pub fn found(&self) -> &[T] {
        &self.found
    }

    fn look_as(&mut self, bodies: &Bodies, own: usize, at: Point2<f64>, reach: f64, show: impl Fn(Disc, bool) -> T) {
        self.found.clear();
        for (grid, is_robot) in [(&bodies.robots, true), (&bodies.people, false)] {
            self.numbers.clear();
            grid.near(at, reach, &mut self.numbers);
            let others = self.numbers.iter().map(|number| *number as usize).filter(|number| !(is_robot && *number == own));
            self.found.extend(others.map(|number| show(grid.discs()[number], is_robot)));
        }
    }
}
