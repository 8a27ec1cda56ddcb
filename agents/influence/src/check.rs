//! An independent slow solver, to check the fast one with.
//!
//! [`enumerate`] walks through all states of all variables, straight from the definition of an influence diagram. It shares nothing with the solver but the
//! model, and takes exponential time. [`generate`] makes random diagrams and random evidence, and [`compare()`] asks both solvers everything that there is to be asked.
//! [`survey`] does so for as many diagrams as one likes.
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
use rand::{Rng, RngExt};

use crate::{Memory, SolveError};

/// Compares both solvers on so many random diagrams of up to seven variables, with up to three decisions among them and evidence on some. Those with evidence that can't
/// be are left out.
///
/// # Errors
/// If a diagram can't be solved.
pub fn survey(random: &mut impl Rng, diagrams: usize, memory: Memory) -> Result<Vec<Comparison>, SolveError> {
    let mut comparisons = Vec::with_capacity(diagrams);
    while comparisons.len() < diagrams {
        let decisions = random.random_range(0..=3);
        let shape = Shape {
            chances: random.random_range(0..=7 - decisions),
            decisions,
            utilities: random.random_range(0..=3),
            zeros: random.random_range(0.0..0.4),
            memory,
            ..Shape::default()
        };
        let diagram = random_diagram(random, &shape);
        let evidence = random_evidence(random, &diagram);
        comparisons.extend(compare(&diagram, &evidence)?);
    }
    Ok(comparisons)
}
