//! The simulated world: what is solid, who walks about, and where robots may start.
//!
//! # The model
//!
//! Every point of a world is either solid or free, and the order of elements in the file never matters:
//!
//! 1. **Carve.** Corridors, rooms and the open doors of rooms are free space, carved out of solid matter. A world that has any
//!    of them is solid everywhere else; a world without is open ground.
//! 2. **Put up walls.** Walls are solid, except where one of their open doors goes through.
//! 3. **Fill.** Polygons, boxes, discs and imported maps are solid.
//!
//! ```text
//! free  = (corridors ∪ rooms ∪ doors of rooms, or the whole plane if there are none)
//!         ∖ ((walls ∖ doors of walls) ∪ polygons ∪ boxes ∪ discs ∪ maps)
//! ```
//!
//! So an office floor is a few `[[corridor]]`s and `[[room]]`s, as on a floor plan, with furniture put into them; a yard is
//! `[[wall]]`s and `[[box]]`es on open ground. What remains is the border between solid and free ([`geometry::Outline`]): no
//! piece of it lies inside matter, joints of walls leave no seam, and each door has four clean corners. [`plan`] has all keys.
//!
//! # Parts
//!
//! * [`plan`]: the tables of a world file; [`map`]: maps of the ROS map server and floor plans as pictures
//! * [`geometry`]: segments, corners and pillars, plain data for the echo model and whoever else looks at the world
//! * [`obstacles`]: how near is the next wall, and where does a moving body touch it
//! * [`people`]: those who walk about
//! * [`disc_grid`]: which of all that move stand near
//! * [`draw`]: a picture of it all
//! * [`floors`]: floors of corridors, made from a seed, with what is true of them

mod build;
mod check;
pub mod disc_grid;
pub mod draw;
mod error;
pub mod floors;
pub mod geometry;
pub mod map;
pub mod obstacles;
pub mod people;
pub mod plan;
mod region;
mod shapes;

use std::{io, path::Path};

use nalgebra::Point2;
use orienteer_runtime::geometry::Pose;

pub use error::{Element, WorldError};
use geometry::{Disc, Outline};
use obstacles::Obstacles;
use plan::{Loop, Person, WorldPlan};

/// How a world gets at the files it refers to.
pub type ReadFile<'a> = dyn Fn(&Path) -> io::Result<Vec<u8>> + 'a;

/// A world, ready to be sensed and driven through. It never changes; people and robots move in front of it.
#[derive(Debug, Clone)]
pub struct World {
    /// What it is called.
    pub name: String,
    /// Border between solid and free.
    pub outline: Outline,
    /// The same border, arranged for collision queries.
    pub obstacles: Obstacles,
    /// Named poses.
    pub places: Vec<Place>,
    /// Those who walk about, as the plan has them; [`people::People`] moves them.
    pub people: Vec<Person>,
}

/// A named pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// How robots refer to it.
    pub name: String,
    /// Where it is.
    pub pose: Pose,
}

impl World {
    /// Builds a world. `files` reads the maps and pictures that the plan names; paths are passed as the plan has them, so
    /// resolve them against the folder of the world file.
    ///
    /// # Errors
    /// [`WorldError`] names the element that is wrong: a number out of range, an outline that crosses itself, a door that does
    /// not fit its wall or leads nowhere, a place inside solid matter, a person whose path goes through a wall, a map that
    /// can't be read.
    pub fn from_plan(plan: &WorldPlan, files: &ReadFile<'_>) -> Result<Self, WorldError> {
        check::ranges(plan)?;
        let outline = build::outline(plan, files)?;
        let obstacles = Obstacles::new(&outline);
        let places = plan.place.iter().map(|place| Place {
            name: place.name.clone(),
            pose: Pose::new(place.at.0[0], place.at.0[1], place.heading_deg.to_radians()),
        });
        let world = Self { name: plan.name.clone(), outline, obstacles, places: places.collect(), people: plan.person.clone() };
        world.check_places(plan)?;
        world.check_people(plan)?;
        Ok(world)
    }

    /// Reads a world file and builds what it describes; `files` reads it too, and everything it refers to relative to its
    /// folder.
    ///
    /// # Errors
    /// As [`World::from_plan`]; [`WorldError::Unreadable`] if the file can't be read, [`WorldError::Syntax`] if it is no world
    /// file.
    pub fn load(path: &Path, files: &ReadFile<'_>) -> Result<Self, WorldError> {
        let unreadable = |reason| WorldError::Unreadable { path: path.to_owned(), reason };
        let text = files(path).map_err(unreadable)?;
        let text = String::from_utf8(text).map_err(|e| unreadable(io::Error::new(io::ErrorKind::InvalidData, e)))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::from_plan(&WorldPlan::parse(&text)?, &|file| files(&folder.join(file)))
    }

    /// The pose that the world file gives this name.
    #[must_use]
    pub fn place(&self, name: &str) -> Option<Pose> {
        self.places.iter().find(|place| place.name == name).map(|place| place.pose)
    }

    /// True if the point lies in free space, people and robots aside.
    #[must_use]
    pub fn is_free(&self, point: Point2<f64>) -> bool {
        self.outline.is_free(point)
    }

    fn check_places(&self, plan: &WorldPlan) -> Result<(), WorldError> {
        for (i, place) in plan.place.iter().enumerate() {
            if !self.is_free(place.at.point()) {
                return Err(Element::nth("place", i, Some(&place.name)).refuse("lies inside solid matter"));
            }
        }
        Ok(())
    }

    fn check_people(&self, plan: &WorldPlan) -> Result<(), WorldError> {
        for (i, person) in plan.person.iter().enumerate() {
            let on = Element::nth("person", i, person.name.as_deref());
            let mut path = build::points(&person.path);
            if let Some(at) = path.iter().position(|p| !self.is_free(*p) || self.obstacles.overlaps(Disc::new(*p, person.radius)))
            {
                return Err(on.refuse(format!("waypoint {} is nearer to solid matter than the radius allows", at + 1)));
            }
            if person.looping == Loop::Round {
                path.extend(path.first().copied());
            }
            let blocked =
                path.windows(2).position(|w| self.obstacles.sweep(Disc::new(w[0], person.radius), w[1] - w[0]).is_some());
            if let Some(leg) = blocked {
                let next = if leg + 2 > person.path.len() { 1 } else { leg + 2 };
                return Err(on.refuse(format!("the way from waypoint {} to {next} touches solid matter", leg + 1)));
            }
        }
        Ok(())
    }
}
