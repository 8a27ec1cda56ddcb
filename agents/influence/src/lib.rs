//! Influence diagrams: what to believe, what to do, and what it would be worth to know more.
//!
//! An influence diagram is a Bayesian network with decisions and utilities. *Chance* nodes have a probability table given their parents; *decision* nodes are
//! free to choose, and the arcs into them say what is known by then; *utility* nodes have a value for each combination of their parents, and add up.
//!
//! # A first diagram
//!
//! Is it a wall? A test that is right in nine of ten cases costs 1; to report the wrong thing costs 20. Is the test worth it?
//!
//! ```
//! use orienteer_influence::{Diagram, Evidence, posterior, solve, value_of_observing};
//!
//! let mut build = Diagram::builder("wall");
//! let wall = build.chance("wall", ["yes", "no"]).table([0.7, 0.3]);
//! let test = build.chance("test", ["positive", "negative"]).given(wall).table([0.9, 0.1, 0.1, 0.9]);
//! let report = build.decision("report", ["yes", "no"]).id();
//! build.utility("loss").given(wall).given(report).table([0.0, -20.0, -20.0, 0.0]);
//! let diagram = build.build()?;
//!
//! // What to believe.
//! let seen = Evidence::none().observe(test, 0);
//! assert!((posterior(&diagram, wall, &seen)?[0] - 0.63 / 0.66).abs() < 1e-12);
//!
//! // What to do: without the test, report a wall, and be wrong in three of ten cases.
//! let blind = solve(&diagram, &Evidence::none())?;
//! assert!((blind.expected_utility - -6.0).abs() < 1e-12);
//! assert_eq!(blind.best(&diagram, report, &Evidence::none())?, 0);
//!
//! // What it is worth to know more: more than the test costs.
//! assert!((value_of_observing(&diagram, &[test], report, &Evidence::none())? - 4.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is where
//!
//! | question | answer |
//! |---|---|
//! | what is probable, given what is known? | [`posterior`], [`posteriors`], [`joint`], [`probability`] |
//! | what is best, and what can be expected of it? | [`solve()`], and [`Plan`] to solve the same structure with new numbers |
//! | what to do now, thousands of times a second? | [`CompiledPolicy`] and [`CompiledQuery`], which allocate nothing |
//! | what is an observation worth? | [`value_of_observing`], [`value_of_perfect_information`], [`mutual_information`], [`entropy`] |
//! | how to exchange diagrams with other programs? | [`bifxml`] |
//! | is all this right? | [`check`], a slow solver of its own to compare with |
//!
//! Evidence is hard (a state was seen) or soft (how well each state agrees with what was seen), see [`Evidence`]. What can't be is an error
//! ([`SolveError::Impossible`]), never a NaN. A diagram that makes no sense is not built: [`BuildError`] names every fault in it.
//!
//! # Algorithms
//!
//! * Probabilities come by variable elimination (Dechter 1996) in an order by least fill, over the part of the network that bears on the question.
//! * With perfect memory ([`Memory::Perfect`]: who decides remembers all that was known and decided before), decisions are solved by the same elimination in a
//!   strong order: the last decision and what is seen after it first (Shachter 1986; Jensen, Jensen & Dittmer 1994).
//! * With limited memory ([`Memory::Limited`]: what the arcs into a decision say and no more), by single policy updating (Lauritzen & Nilsson 2001). That finds the
//!   maximum in soluble diagrams, and elsewhere a policy that no change of a single decision improves; [`Solution::optimum`] says which.
//!
//! # Limits
//!
//! States are finite, and tables dense. A diagram for which some table would have more than [`MAX_CELLS`] cells is refused before anything is
//! allocated; forgetting often makes it small enough.
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
