//! The mapper: draws what the sonar ring hears into a certainty grid as the robot moves (Good 1992, §2).
//!
//! [`Mapper`] is a plain state machine. It is told poses as they become known and scans as they arrive, and for each scan it
//!
//! 1. places every reading at the pose the robot had when that transducer was read, not at the pose of the whole scan,
//! 2. weighs it by its region of constant depth ([`rcd`](crate::certainty_grid::rcd)),
//! 3. fuses transducers that stand in pairs ([`pairs`](crate::certainty_grid::pairs)),
//! 4. draws all empty cones, then all objects ([`marking`](crate::certainty_grid::marking)),
//! 5. marks the ground it has driven over as free beyond doubt,
//! 6. lets the map fade, if told so ([`decay`](crate::certainty_grid::decay)).
//!
//! The window follows the robot, or grows with the building ([`Extent`]). [`files`] writes the map for machines (PNG and
//! `map_server` YAML) and [`picture`] draws it for people.

mod agent;
mod config;
pub mod files;
mod history;
pub mod picture;
mod state;
mod trail;

pub use agent::MapperAgent;
pub use config::{Config, Extent, TrailConfig};
pub use history::PoseHistory;
pub use state::{Mapper, Report, WindowChange};
