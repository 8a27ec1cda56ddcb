//! One decision, as if it were to be made now.

use super::{sequence::check_evidence_comes_first, solution::Solution};
use crate::{
    diagram::{DecisionId, Diagram},
    engine::{Mark, Program, Round, Task},
    error::SolveError,
};

/// The elimination that tells what each alternative of one decision is worth, if all others have been made or follow their policies.
#[derive(Debug, Clone)]
pub(crate) struct Now {
    /// The diagram, with policies in place of the other decisions that are open.
    pub(crate) network: Diagram,
    pub(crate) program: Program,
}

impl Now {
    pub(crate) fn new(diagram: &Diagram, solution: &Solution, decision: DecisionId, marks: &[Mark]) -> Result<Self, SolveError> {
        let network = solution.applied_but_to(diagram, |other| other == decision || marks[other.0] == Mark::Fixed);
        check_evidence_comes_first(&network, marks)?;
        let rounds = [Round::Sum(network.variables().collect())];
        let keep = [decision.into()];
        let program = Program::compile(&Task { diagram: &network, marks, keep: &keep, rounds: &rounds, utilities: true })?;
        Ok(Self { network, program })
    }
}
