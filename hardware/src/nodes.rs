//! The two devices of a robot as nodes: base and sonar, each over a driver.

mod base;
mod guard;
mod sonar;

pub use base::BaseNode;
pub use guard::{Guard, Guarded};
pub use sonar::{NoSonar, SonarNode};
