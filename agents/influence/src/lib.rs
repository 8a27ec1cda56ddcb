//! Influence diagrams.
#![forbid(unsafe_code)]

pub mod diagram;

pub use diagram::{BuildError, ChanceId, DecisionId, Diagram, DiagramBuilder, Fault, Memory, NodeId, UtilityId, VariableId};
