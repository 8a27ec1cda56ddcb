//! The simulated world in motion: walls, people, and the bodies of all robots.

use std::{
    sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock},
    time::Duration,
};

use nalgebra::Point2;
use orienteer_runtime::{fleet::Environment, geometry::Pose, random::Streams, time::Time};

use super::{Bodies, SimBody, SimBodyConfig};
use crate::{
    echo::{self, SegmentGrid},
    world::{World, geometry, people::People},
};

/// A world with everything that moves in it.
#[derive(Debug)]
pub struct Arena {
    world: World,
    walls: SegmentGrid,
    robots: Mutex<Vec<Arc<Mutex<SimBody>>>>,
    names: Mutex<Vec<String>>,
    bodies: RwLock<Bodies>,
    people: Mutex<People>,
    /// Memory for where the robots are while they are being looked up.
    places: Mutex<Vec<Point2<f64>>>,
    streams: Streams,
}

/// A world can't be simulated.
#[derive(Debug, thiserror::Error)]
pub enum ArenaError {
    /// Its walls can't be put into a grid.
    #[error("the world can't be simulated: {0}")]
    Grid(#[from] echo::GridError),
    /// A robot would start where it does not fit.
    #[error("robot `{robot}` can't start at ({x:.2}, {y:.2}): {reason}")]
    Occupied {
        /// The robot's name.
        robot: String,
        /// m.
        x: f64,
        /// m.
        y: f64,
        /// What is in the way.
        reason: String,
    },
}

impl Arena {
    /// A world in which nobody but its people is yet.
    ///
    /// # Errors
    /// If its walls can't be put into a grid.
    pub fn new(world: World, streams: Streams) -> Result<Arc<Self>, ArenaError> {
        let people = People::new(&world.people, &streams);
        let mut bodies = Bodies::default();
        bodies.people.arrange(people.bodies().iter().map(|body| body.disc));
        Ok(Arc::new(Self {
            walls: walls(&world)?,
            world,
            robots: Mutex::default(),
            names: Mutex::default(),
            bodies: RwLock::new(bodies),
            people: Mutex::new(people),
            places: Mutex::default(),
            streams,
        }))
    }

    /// The world itself.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The source of the arena's random numbers.
    #[must_use]
    pub fn streams(&self) -> Streams {
        self.streams
    }

    pub(super) fn walls(&self) -> &SegmentGrid {
        &self.walls
    }

    /// Puts a robot into the arena.
    ///
    /// # Errors
    /// If it does not fit where it is to start.
    pub fn add(self: &Arc<Self>, name: &str, start: Pose, config: SimBodyConfig) -> Result<Arc<Mutex<SimBody>>, ArenaError> {
        let disc = geometry::Disc::new(start.point(), config.base.radius);
        if let Some(reason) = self.in_the_way(disc) {
            return Err(ArenaError::Occupied { robot: name.to_string(), x: start.x, y: start.y, reason });
        }
        let mut robots = lock(&self.robots);
        let body = Arc::new(Mutex::new(SimBody::new(self, robots.len(), name, start, config)));
        self.bodies.write().unwrap_or_else(PoisonError::into_inner).robots.push(disc);
        robots.push(body.clone());
        lock(&self.names).push(name.to_owned());
        Ok(body)
    }

    /// The body of the robot of this name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<Arc<Mutex<SimBody>>> {
        let number = lock(&self.names).iter().position(|other| other == name)?;
        lock(&self.robots).get(number).cloned()
    }

    fn in_the_way(&self, disc: geometry::Disc) -> Option<String> {
        if !self.world.is_free(disc.center) {
            return Some("that is inside solid matter".to_string());
        }
        if self.world.obstacles.overlaps(disc) {
            return Some("it would touch a wall".to_string());
        }
        let touching = |other: &geometry::Disc| (other.center - disc.center).norm() < other.radius + disc.radius;
        let touched = self.with_bodies(|bodies| bodies.robots().iter().chain(bodies.people()).any(touching));
        touched.then(|| "somebody stands there".to_string())
    }

    /// Where everybody stood at the end of the previous step.
    pub fn with_bodies<T>(&self, look: impl FnOnce(&Bodies) -> T) -> T {
        look(&self.bodies.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// The bodies of the robots, in the order in which they came.
    #[must_use]
    pub fn robots(&self) -> Vec<Arc<Mutex<SimBody>>> {
        lock(&self.robots).clone()
    }

    /// The people and how they move, in the order of the world's plan.
    pub fn with_people<T>(&self, look: impl FnOnce(&mut People) -> T) -> T {
        look(&mut lock(&self.people))
    }

    /// Moves the people on by `span` and publishes where everybody stands.
    pub fn advance(&self, span: Duration) {
        // Whoever moves a body on holds it and looks at `bodies`: nobody may hold `bodies` and wait for a body.
        let mut places = lock(&self.places);
        places.clear();
        places.extend(lock(&self.robots).iter().map(|robot| lock(robot).pose().point()));
        let mut bodies = self.bodies.write().unwrap_or_else(PoisonError::into_inner);
        bodies.robots.move_to(places.iter().copied());
        let mut people = lock(&self.people);
        people.advance(span.as_secs_f64(), &bodies.robots);
        bodies.people.move_to(people.bodies().iter().map(|body| body.disc.center));
    }
}

/// Moves an arena on between the steps of a fleet.
#[derive(Debug)]
pub struct ArenaClock {
    arena: Arc<Arena>,
    now: Time,
}

impl ArenaClock {
    /// A clock for an arena at the start of its mission.
    #[must_use]
    pub fn new(arena: Arc<Arena>) -> Self {
        Self { arena, now: Time::START }
    }
}

impl Environment for ArenaClock {
    fn advance(&mut self, now: Time) {
        self.arena.advance(now.since(self.now));
        self.now = now;
    }
}

/// A panic elsewhere leaves a body as it was between two assignments of plain numbers: still usable.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn walls(world: &World) -> Result<SegmentGrid, echo::GridError> {
    let outline = &world.outline;
    let segments: Vec<_> = outline
        .segments
        .iter()
        .map(|segment| echo::Wall { a: segment.a, b: segment.b, reflectance: segment.material.reflectance })
        .collect();
    // A corner that points into the room sends sound back to wherever it came from; one that points away is two walls.
    let corners = outline.vertices.iter().filter(|vertex| vertex.kind != geometry::Corner::Concave);
    let vertices: Vec<_> = corners.map(|vertex| echo::Vertex { at: vertex.at, strength: 1.0 }).collect();
    let pillars: Vec<_> = outline
        .pillars
        .iter()
        .map(|pillar| echo::Disc {
            centre: pillar.disc.center,
            radius: pillar.disc.radius,
            reflectance: pillar.material.reflectance,
        })
        .collect();
    SegmentGrid::new(&segments, &vertices, &pillars)
}
