//! Simulated robots in a simulated world.
//!
//! An [`Arena`] is a world with everything that moves in it. Each robot has a [`SimBody`] there, which its [`SimBase`] drives
//! and its [`SimSonar`] listens from. Between two steps the arena moves its people on and publishes where everybody stands;
//! within a step a robot sees the others as they stood then, so the order in which robots are stepped can't matter.

mod arena;
mod bodies;
mod body;
mod drivers;

pub use arena::{Arena, ArenaClock, ArenaError};
pub use bodies::Bodies;
pub use body::{SimBody, SimBodyConfig};
pub use drivers::{SimBase, SimSonar};
