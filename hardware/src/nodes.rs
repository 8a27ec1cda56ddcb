//! The two devices of a robot as nodes: base and sonar, each over a driver.

mod base;
mod guard;
mod sonar;
pub(crate) mod trouble;

pub use base::BaseNode;
pub use guard::{Guard, Guarded};
pub use sonar::{NoSonar, SonarNode};

/// What a device says to have measured later than the step by more than this, s, is refused: it would make all that comes after it
/// look old. A driver on its own thread may be a little ahead.
const IN_THE_FUTURE: f64 = 0.25;
