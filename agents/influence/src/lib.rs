//! Influence diagrams.
#![forbid(unsafe_code)]

pub mod bifxml;
pub mod check;
mod compiled;
pub mod diagram;
mod engine;
mod error;
mod evidence;
mod infer;
mod information;
pub mod samples;
mod solve;
mod table;

pub use compiled::{Advice, CompiledPolicy, CompiledQuery};
pub use diagram::{BuildError, ChanceId, DecisionId, Diagram, DiagramBuilder, Fault, Memory, NodeId, UtilityId, VariableId};
pub use engine::MAX_CELLS;
pub use error::SolveError;
pub use evidence::{Evidence, Finding};
pub use infer::{joint, posterior, posteriors, probability};
pub use information::{entropy, entropy_of, mutual_information, value_of_observing, value_of_perfect_information};
pub use solve::{Choice, Optimum, Outcome, Plan, Policy, Solution, solve};
pub use table::Table;
