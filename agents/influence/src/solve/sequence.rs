//! Which decision comes first, and what is known by then.

use crate::{
    diagram::{DecisionId, Descent, Diagram, VariableId},
    engine::{Mark, Round},
    error::SolveError,
};

/// The decisions that are still open.
pub(super) fn open_decisions(diagram: &Diagram, marks: &[Mark]) -> Vec<DecisionId> {
    let in_order = diagram.topological().iter().filter_map(|variable| diagram.as_decision(*variable));
    in_order.filter(|decision| marks[VariableId::from(*decision).0] != Mark::Fixed).collect()
}

/// Checks that nothing is known that an open decision could still change.
pub(crate) fn check_evidence_comes_first(diagram: &Diagram, marks: &[Mark]) -> Result<(), SolveError> {
    // A decision that was made does not listen any more.
    let made = |variable: VariableId| diagram.is_decision(variable) && marks[variable.0] == Mark::Fixed;
    let descent = Descent::new(diagram, made);
    for decision in open_decisions(diagram, marks) {
        let influenced = descent.from(decision.into());
        let known = diagram.variables().find(|variable| influenced[variable.0] && marks[variable.0] != Mark::Hidden);
        if let Some(variable) = known {
            return Err(SolveError::EvidenceAfterDecision {
                variable: diagram.name_of(variable).to_owned(),
                decision: diagram.name_of(decision).to_owned(),
            });
        }
    }
    Ok(())
}

/// The strong order of elimination: what is never seen, the last decision, what is seen just before it, and so on back to what is
/// seen before the first decision.
///
/// # Errors
/// [`SolveError::UnorderedDecisions`] unless one path leads over all decisions.
pub(super) fn strong_rounds(diagram: &Diagram, marks: &[Mark]) -> Result<Vec<Round>, SolveError> {
    let decisions: Vec<DecisionId> = diagram.topological().iter().filter_map(|variable| diagram.as_decision(*variable)).collect();
    let descent = Descent::new(diagram, |_| false);
    for pair in decisions.windows(2) {
        if !descent.from(pair[0].into())[VariableId::from(pair[1]).0] {
            let name = |decision| diagram.name_of(decision).to_owned();
            return Err(SolveError::UnorderedDecisions { first: name(pair[0]), second: name(pair[1]) });
        }
    }
    let mut seen = vec![false; diagram.variables().len()];
    let mut rounds = Vec::new();
    for &decision in &decisions {
        let new: Vec<VariableId> =
            diagram.parents(decision).iter().copied().filter(|v| !diagram.is_decision(*v) && !seen[v.0]).collect();
        new.iter().for_each(|variable| seen[variable.0] = true);
        rounds.push(Round::Sum(new));
        if marks[VariableId::from(decision).0] != Mark::Fixed {
            rounds.push(Round::Maximise(decision.into()));
        }
    }
    rounds.push(Round::Sum(diagram.variables().filter(|v| !diagram.is_decision(*v) && !seen[v.0]).collect()));
    rounds.reverse();
    Ok(rounds)
}
