//! How probable is what, given what is known: inference without a choice.
//!
//! Variable elimination (Dechter 1996) for each question, over those nodes only that have to do with it. A diagram with decisions can be asked as well, as long as
//! the answer does not depend on one that is open; tell which alternative was taken, or ask the diagram
//! [under its policies](crate::Solution::applied_to).

use crate::{
    diagram::{Diagram, VariableId},
    engine::{Mark, Program, Round, Task},
    error::SolveError,
    evidence::{self, Evidence},
    table::Table,
};

/// The probability of each state of a variable, given the evidence.
///
/// # Errors
/// [`SolveError`]: evidence that does not fit the diagram or is impossible, an open decision, a diagram too large.
pub fn posterior(diagram: &Diagram, variable: impl Into<VariableId>, evidence: &Evidence) -> Result<Vec<f64>, SolveError> {
    Ok(joint(diagram, &[variable.into()], evidence)?.values().to_vec())
}

/// The [`posterior`] of every variable, in their order.
///
/// # Errors
/// As for [`posterior`].
pub fn posteriors(diagram: &Diagram, evidence: &Evidence) -> Result<Vec<Vec<f64>>, SolveError> {
    diagram.variables().map(|variable| posterior(diagram, variable, evidence)).collect()
}

/// The joint probability of several variables, given the evidence, with the first one slowest.
///
/// # Errors
/// As for [`posterior`]; and a variable that is asked for twice.
pub fn joint(diagram: &Diagram, variables: &[VariableId], evidence: &Evidence) -> Result<Table, SolveError> {
    evidence.check(diagram)?;
    let mut answer = joint_with_evidence(diagram, variables, evidence)?;
    let total = evidence::possible(answer.iter().sum())?;
    answer.iter_mut().for_each(|value| *value /= total);
    Ok(Table::new(diagram, variables.to_vec(), answer))
}

/// How probable the evidence is. With likelihoods it is the mean likelihood.
///
/// # Errors
/// As for [`posterior`].
pub fn probability(diagram: &Diagram, evidence: &Evidence) -> Result<f64, SolveError> {
    evidence.check(diagram)?;
    evidence::possible(joint_with_evidence(diagram, &[], evidence)?.iter().sum())
}

/// The joint probability of some variables and the evidence, not scaled to 1.
fn joint_with_evidence(diagram: &Diagram, variables: &[VariableId], evidence: &Evidence) -> Result<Vec<f64>, SolveError> {
    let mut marks = evidence.marks(diagram);
    check_targets(diagram, variables)?;
    for variable in variables {
        match marks[variable.0] {
            Mark::Hidden if diagram.is_decision(*variable) => {
                return Err(SolveError::Undecided { decision: diagram.name_of(*variable).to_owned() });
            }
            // What is asked for must stay in the table, so its state is told by weights.
            Mark::Fixed => marks[variable.0] = Mark::Weighed,
            Mark::Hidden | Mark::Weighed => {}
        }
    }
    let rounds = [Round::Sum(diagram.variables().collect())];
    let program = Program::compile(&Task { diagram, marks: &marks, keep: variables, rounds: &rounds, utilities: false })?;
    let mut workspace = program.workspace();
    evidence.load(diagram, &program, &mut workspace);
    program.run(&mut workspace);
    Ok(workspace.block(&program.probability).to_vec())
}

/// Checks that each of these is in the diagram, and asked for once.
pub(crate) fn check_targets(diagram: &Diagram, variables: &[VariableId]) -> Result<(), SolveError> {
    for (i, &variable) in variables.iter().enumerate() {
        evidence::known(diagram, variable)?;
        if variables[..i].contains(&variable) {
            return Err(SolveError::Repeated { variable: diagram.name_of(variable).to_owned() });
        }
    }
    Ok(())
}
