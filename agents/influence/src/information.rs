//! What it would be worth to know more, and how much there is to know.
//!
//! The value of an observation is by how much the maximum expected utility grows if an arc is drawn from it into a decision (Howard 1966). It is never negative, and in
//! the units of the utilities. Entropy and mutual information (Shannon 1948) know nothing of utilities; they are in bits.

use crate::{
    diagram::{ChanceId, DecisionId, Descent, Diagram, VariableId},
    error::SolveError,
    evidence::{self, Evidence},
    infer::{joint, posterior},
    solve::{Optimum, solve},
};

/// The entropy of a distribution, in bits: 0 if one state is certain, and 1 for a fair coin.
///
/// ```
/// assert_eq!(orienteer_influence::entropy(&[0.5, 0.25, 0.25]), 1.5);
/// assert_eq!(orienteer_influence::entropy(&[1.0, 0.0]), 0.0);
/// ```
#[must_use]
pub fn entropy(distribution: &[f64]) -> f64 {
    // Begun with 0, because a sum of nothing is -0.
    distribution.iter().filter(|p| **p > 0.0).fold(0.0, |bits, p| bits - p * p.log2())
}

/// The entropy of a variable, given the evidence, in bits.
///
/// # Errors
/// As for [`posterior`].
pub fn entropy_of(diagram: &Diagram, variable: impl Into<VariableId>, evidence: &Evidence) -> Result<f64, SolveError> {
    Ok(entropy(&posterior(diagram, variable, evidence)?))
}

/// How much one variable tells about another, given the evidence, in bits: by how much the entropy of either can be expected to fall when the other becomes
/// known.
///
/// # Errors
/// As for [`joint`].
pub fn mutual_information(
    diagram: &Diagram,
    a: impl Into<VariableId>,
    b: impl Into<VariableId>,
    evidence: &Evidence,
) -> Result<f64, SolveError> {
    let (a, b) = (a.into(), b.into());
    let joint = joint(diagram, &[a, b], evidence)?;
    let (mut of_a, mut of_b) = (vec![0.0; diagram.extent(a)], vec![0.0; diagram.extent(b)]);
    for (i, row) in joint.values().chunks(of_b.len()).enumerate() {
        for (j, p) in row.iter().enumerate() {
            of_a[i] += p;
            of_b[j] += p;
        }
    }
    // Never negative, but for rounding.
    Ok((entropy(&of_a) + entropy(&of_b) - entropy(joint.values())).max(0.0))
}

/// By how much the maximum expected utility grows if these chance nodes are seen before this decision.
///
/// What was seen already is worth nothing more. With perfect memory, later decisions will know it as well.
///
/// # Errors
/// [`SolveError::NotObservable`] for what the decision has an influence on, [`SolveError::OnlyLocal`] with limited memory unless the diagram is soluble, and as for [`solve()`].
pub fn value_of_observing(
    diagram: &Diagram,
    chances: &[ChanceId],
    before: DecisionId,
    evidence: &Evidence,
) -> Result<f64, SolveError> {
    evidence::known(diagram, before.into())?;
    let influenced = Descent::new(diagram, |_| false).from(before.into());
    let mut seen = Vec::new();
    for &chance in chances {
        evidence::known(diagram, chance.into())?;
        if influenced[VariableId::from(chance).0] {
            let name = |variable: VariableId| diagram.name_of(variable).to_owned();
            return Err(SolveError::NotObservable { variable: name(chance.into()), decision: name(before.into()) });
        }
        seen.push(chance.into());
    }
    let blind = maximum(diagram, evidence)?;
    let sighted = maximum(&diagram.clone().with_sight(before, &seen), evidence)?;
    Ok((sighted - blind).max(0.0))
}

/// The expected value of perfect information (EVPI): by how much the maximum expected utility grows if everything that bears on the utilities, and on which
/// the decision has no influence, is seen before it.
///
/// What the decision does have an influence on can't be seen before; where such a node is uncertain for reasons of its own, give these a node.
///
/// # Errors
/// As for [`value_of_observing`].
pub fn value_of_perfect_information(diagram: &Diagram, before: DecisionId, evidence: &Evidence) -> Result<f64, SolveError> {
    evidence::known(diagram, before.into())?;
    let influenced = Descent::new(diagram, |_| false).from(before.into());
    let mut bears = vec![false; influenced.len()];
    diagram.utilities().flat_map(|utility| diagram.parents(utility)).for_each(|parent| bears[parent.0] = true);
    for variable in diagram.topological().iter().rev().filter(|variable| diagram.as_chance(**variable).is_some()) {
        if bears[variable.0] {
            diagram.parents(*variable).iter().for_each(|parent| bears[parent.0] = true);
        }
    }
    let chances: Vec<ChanceId> = diagram.chances().filter(|chance| bears[chance.0] && !influenced[chance.0]).collect();
    value_of_observing(diagram, &chances, before, evidence)
}

fn maximum(diagram: &Diagram, evidence: &Evidence) -> Result<f64, SolveError> {
    let solution = solve(diagram, evidence)?;
    if solution.optimum == Optimum::Local {
        return Err(SolveError::OnlyLocal);
    }
    Ok(solution.expected_utility)
}
