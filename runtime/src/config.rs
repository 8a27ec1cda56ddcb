//! Configuration: TOML for people, checked to the last key.
//!
//! Every problem names file, line and column, shows the offending text and hints at the repair; all are told at once. Nothing
//! is ignored in silence, and nothing panics.
//!
//! * [`source`] - the files, from the disk or out of a recording
//! * [`problem`] - what is wrong, for people and for programs
//! * [`document`] - TOML in which every value knows its place
//! * [`validate`] - a table against the JSON schema of its type
//! * [`layers`] - one table laid over another, templates
//! * [`mission`] - what a mission file says

pub mod document;
pub mod layers;
pub mod mission;
#[doc(hidden)]
pub mod mutate;
pub mod problem;
pub mod source;
pub mod suggest;
mod syntax;
pub mod validate;

pub use document::Section;
pub use mission::Mission;
pub use problem::{Location, Problem, Problems};
pub use source::{SourceId, Sources, Span};
