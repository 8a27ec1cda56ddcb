//! What is best to do: optimal policies, and what they are worth.
//!
//! [`solve()`] takes any diagram. Under [perfect memory](crate::Memory::Perfect) it eliminates in a strong order, from the last decision back to the first
//! (Jensen, Jensen & Dittmer 1994); the result is the maximum. Under [limited memory](crate::Memory::Limited) it updates one policy after the other
//! (Lauritzen & Nilsson 2001), and says whether what it found is the maximum or a local one.
//!
//! Solving happens in two parts, and [`Plan`] keeps them apart: the structure decides in which order to eliminate and where each number
//! lies; the numbers are only arithmetic then.

mod limid;
mod now;
mod outcome;
mod plan;
mod separation;
mod sequence;
mod solution;

pub use outcome::{Choice, Outcome};
pub use plan::Plan;
pub(crate) use plan::marks;
pub use solution::{Optimum, Policy, Solution};

pub(crate) use now::Now;
pub(crate) use sequence::check_evidence_comes_first;

use crate::{
    diagram::{Diagram, Memory, VariableId},
    error::SolveError,
    evidence::{Evidence, Finding},
};

/// Solves a diagram once.
///
/// The evidence is known before any open decision. Decisions that it gives the state of are made already, and are taken as they are. Utilities are conditional: what can be expected given the
/// evidence. Of alternatives that are worth the same, the first one is chosen; so it is where the past is impossible.
///
/// ```
/// use orienteer_influence::{Diagram, Evidence, solve};
///
/// let mut build = Diagram::builder("bet");
/// let coin = build.chance("coin", ["heads", "tails"]).table([0.6, 0.4]);
/// let bet = build.decision("bet", ["heads", "tails"]).id();
/// build.utility("win").given(coin).given(bet).table([1.0, -1.0, -1.0, 1.0]);
/// let diagram = build.build()?;
/// let solution = solve(&diagram, &Evidence::none())?;
/// assert!((solution.expected_utility - 0.2).abs() < 1e-12);
/// assert_eq!(solution.best(&diagram, bet, &Evidence::none())?, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`SolveError`]: evidence that does not fit, is impossible or comes after an open decision; decisions without an order; a diagram too large.
pub fn solve(diagram: &Diagram, evidence: &Evidence) -> Result<Solution, SolveError> {
    if diagram.memory() == Memory::Limited {
        return limid::solve(diagram, evidence);
    }
    evidence.check(diagram)?;
    let of_kind = |wanted: fn(&Finding) -> bool| -> Vec<VariableId> {
        evidence.iter().filter(|(_, finding)| wanted(finding)).map(|(variable, _)| variable).collect()
    };
    let fixed = of_kind(|finding| matches!(finding, Finding::State(_)));
    let weighed = of_kind(|finding| matches!(finding, Finding::Likelihood(_)));
    let mut plan = Plan::new(diagram, &fixed, &weighed)?;
    Ok(plan.solve(diagram, evidence)?.to_solution(diagram, evidence))
}
