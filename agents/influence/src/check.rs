//! An independent slow solver, to check the fast one with.
//!
//! [`enumerate`] walks through all states of all variables, straight from the definition of an influence diagram. It shares nothing with the solver but the
//! model, and takes exponential time. [`generate`] makes random diagrams and random evidence, and [`compare()`] asks both solvers everything that there is to be asked.
//!
//! ```
//! use orienteer_influence::check::{Shape, compare, random_diagram, random_evidence};
//! use rand::SeedableRng;
//!
//! let mut random = rand_pcg::Pcg64::seed_from_u64(1);
//! let diagram = random_diagram(&mut random, &Shape::default());
//! let evidence = random_evidence(&mut random, &diagram);
//! if let Some(comparison) = compare(&diagram, &evidence)? {
//!     assert!(comparison.largest_error < 1e-9);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod compare;
pub mod enumerate;
pub mod generate;

pub use compare::{Comparison, compare};
pub use enumerate::{Enumeration, Node};
pub use generate::{Shape, random_diagram, random_evidence};
