//! A world as a person writes it: the tables of a world file.
//!
//! See [`world`](super) for the model of solid and free space behind them. Everything is in metres and degrees, x to the
//! right and y up on paper; all tables may be left out.
//!
//! ```
//! use orienteer_hardware::world::plan::WorldPlan;
//! let plan = WorldPlan::parse(r#"
//!     [[corridor]]
//!     along = [[0, 0], [20, 0]]
//!     width = 1.8
//!
//!     [[room]]
//!     corners = [[4, 1.04], [9, 5]]                 # two points: opposite corners of a rectangle
//!     doors = [{ at = [6, 1.04], width = 0.88 }]
//!
//!     [[box]]
//!     center = [8, 4]
//!     size = [1.6, 0.8]
//!
//!     [[place]]
//!     name = "west end"
//!     at = [1, 0]
//! "#)?;
//! assert_eq!(plan.room[0].doors.len(), 1);
//! # Ok::<(), orienteer_hardware::world::WorldError>(())
//! ```

mod imports;

use nalgebra::Point2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use imports::{FloorPlan, RosMap};

use super::WorldError;

/// Largest magnitude of a coordinate, m.
pub(super) const FAR: f64 = 500.0;

/// A position `[x, y]`, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Xy(#[schemars(inner(range(min = -500.0, max = 500.0)))] pub [f64; 2]);

impl Xy {
    /// The position as a point.
    #[must_use]
    pub fn point(self) -> Point2<f64> {
        Point2::from(self.0)
    }
}

/// A whole world file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WorldPlan {
    /// What the world is called; shown in lists and recordings.
    pub name: String,
    /// Corridors carved out of solid matter.
    pub corridor: Vec<Corridor>,
    /// Rooms carved out of solid matter.
    pub room: Vec<Room>,
    /// Free-standing or dividing walls.
    pub wall: Vec<Wall>,
    /// Solid polygons.
    pub polygon: Vec<Polygon>,
    /// Solid rectangles: furniture, crates.
    #[serde(rename = "box")]
    pub boxes: Vec<Block>,
    /// Round pillars.
    pub disc: Vec<Column>,
    /// A map in the format of the ROS map server, added to what the tables above say.
    pub map: Option<RosMap>,
    /// A plain black-and-white floor plan, added to what the tables above say.
    pub image: Option<FloorPlan>,
    /// People who walk about.
    pub person: Vec<Person>,
    /// Named poses that robots can start from.
    pub place: Vec<Place>,
}

impl WorldPlan {
    /// Reads a world file. Says nothing of whether the elements make sense: that is
    /// [`World::from_plan`](super::World::from_plan).
    ///
    /// # Errors
    /// [`WorldError::Syntax`] if the text is not TOML or has keys or types that no world file has.
    pub fn parse(text: &str) -> Result<Self, WorldError> {
        Ok(toml::from_str(text)?)
    }
}

/// Free space along a centre line. Corridors that overlap join. Write a bend as one corridor with three points: its outer
/// corner is then square.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Corridor {
    /// For error messages.
    #[serde(default)]
    pub name: Option<String>,
    /// The centre line: two points or more, m. Both ends are closed, square to the line.
    #[schemars(length(min = 2, max = 1000))]
    pub along: Vec<Xy>,
    /// From wall to wall, m.
    #[schemars(range(min = 0.3, max = 50.0))]
    pub width: f64,
    /// True if the last point joins the first, as in a ring of corridors.
    #[serde(default)]
    pub closed: bool,
    /// Echo amplitude of the walls as a share of a hard, smooth wall's.
    #[serde(default = "hard")]
    #[schemars(range(min = 0.01, max = 1.0))]
    pub reflectance: f64,
}

/// Free space inside an outline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// For error messages.
    #[serde(default)]
    pub name: Option<String>,
    /// Two opposite corners of a rectangle, or all corners of a polygon in order, m.
    #[schemars(length(min = 2, max = 1000))]
    pub corners: Vec<Xy>,
    /// Doors to whatever free space lies behind the wall, at most 1.5 m away. A door between two rooms is written once.
    #[serde(default)]
    pub doors: Vec<Door>,
    /// Echo amplitude of the walls as a share of a hard, smooth wall's.
    #[serde(default = "hard")]
    #[schemars(range(min = 0.01, max = 1.0))]
    pub reflectance: f64,
}

/// An opening through a wall. The surface on either side of it is that of the wall: a flush leaf.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Door {
    /// The middle of the door, a point on the wall (or within 0.5 m of it: the nearest place on the wall counts), m.
    pub at: Xy,
    /// Clear width, m. Randazza 1989 measured 0.88 m doorways.
    #[serde(default = "door_width")]
    #[schemars(range(min = 0.3, max = 20.0))]
    pub width: f64,
    /// A closed door is a piece of wall.
    #[serde(default = "yes")]
    pub open: bool,
}

/// Solid matter along a line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// For error messages.
    #[serde(default)]
    pub name: Option<String>,
    /// The middle of the wall: two points or more, m. Its ends are square.
    #[schemars(length(min = 2, max = 1000))]
    pub along: Vec<Xy>,
    /// Thickness, m. Randazza 1989 measured 0.14 m.
    #[serde(default = "wall_thickness")]
    #[schemars(range(min = 0.01, max = 10.0))]
    pub thickness: f64,
    /// True if the last point joins the first.
    #[serde(default)]
    pub closed: bool,
    /// Openings. They go through every wall that stands there, but not through other matter.
    #[serde(default)]
    pub doors: Vec<Door>,
    /// Echo amplitude as a share of a hard, smooth wall's.
    #[serde(default = "hard")]
    #[schemars(range(min = 0.01, max = 1.0))]
    pub reflectance: f64,
}

/// Solid matter inside an outline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Polygon {
    /// For error messages.
    #[serde(default)]
    pub name: Option<String>,
    /// Two opposite corners of a rectangle, or all corners in order, m.
    #[schemars(length(min = 2, max = 1000))]
    pub corners: Vec<Xy>,
    /// Echo amplitude as a share of a hard, smooth wall's.
    #[serde(default = "hard")]
    #[schemars(range(min = 0.01, max = 1.0))]
    pub reflectance: f64,
}

/// A solid rectangle at any angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// For error messages.
    #[serde(default)]
    pub name: Option<String>,
    /// Its middle, m.
    pub center: Xy,
    /// Length along x and along y before it is turned, m.
    #[schemars(inner(range(min = 0.01, max = 500.0)))]
    pub size: [f64; 2],
    /// How far it is turned, degrees, counter-clockwise.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation_deg: f64,
    /// Echo amplitude as a share of a hard, smooth wall's.
    #[serde(default = "hard")]
    #[schemars(range(min = 0.01, max = 1.0))]
    pub reflectance: f64,
}

/// A round pillar, kept as the exact circle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// For error messages.
    #[serde(default)]
    pub name: Option<String>,
    /// Its middle, m.
    pub center: Xy,
    /// Radius, m.
    #[schemars(range(min = 0.01, max = 50.0))]
    pub radius: f64,
    /// Echo amplitude as a share of a hard, smooth wall's.
    #[serde(default = "hard")]
    #[schemars(range(min = 0.01, max = 1.0))]
    pub reflectance: f64,
}

/// What a person does at the end of the path.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Loop {
    /// Turns round and walks back.
    #[default]
    BackAndForth,
    /// Walks from the last waypoint straight to the first and starts again.
    Round,
}

/// What a person does about a robot in the way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Courtesy {
    /// Stops half a metre short of it and waits.
    #[default]
    Stops,
    /// Walks on as if it were not there.
    Ignores,
}

/// Somebody who walks along a path. Sonar hears and bodies hit a cylinder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Person {
    /// For messages and recordings; `person 1`, `person 2`, … if left out.
    #[serde(default)]
    pub name: Option<String>,
    /// Radius of the cylinder, m.
    #[serde(default = "person_radius")]
    #[schemars(range(min = 0.05, max = 1.0))]
    pub radius: f64,
    /// Waypoints, m. With a single one the person stands there.
    #[schemars(length(min = 1, max = 1000))]
    pub path: Vec<Xy>,
    /// Walking speed, m/s.
    #[serde(default = "person_speed")]
    #[schemars(range(min = 0.0, max = 3.0))]
    pub speed: f64,
    /// Standard deviation of the speed from one leg of the path to the next, as a share of the speed.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.3))]
    pub speed_variation: f64,
    /// What happens at the end of the path.
    #[serde(default, rename = "loop")]
    pub looping: Loop,
    /// How long the person stands at each waypoint, s.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub pause: f64,
    /// How far along the path the person starts, m; further than the path is long counts on from its end as in walking.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub start: f64,
    /// What the person does about a robot in the way.
    #[serde(default)]
    pub courtesy: Courtesy,
    /// After so many seconds of waiting for a robot, the person turns round and walks back; waits for ever if left out.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub patience: Option<f64>,
}

/// A named pose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// How robots refer to it; no two places may share one.
    #[schemars(length(min = 1, max = 64))]
    pub name: String,
    /// Position, m.
    pub at: Xy,
    /// Heading, degrees, counter-clockwise from the x axis.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub heading_deg: f64,
}

fn hard() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}

fn door_width() -> f64 {
    0.88
}

fn wall_thickness() -> f64 {
    0.14
}

fn person_radius() -> f64 {
    0.25
}

fn person_speed() -> f64 {
    0.8
}
