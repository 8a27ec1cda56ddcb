//! The fast solver against the slow one.

use super::enumerate;
use crate::{
    diagram::{Diagram, Memory, VariableId},
    error::SolveError,
    evidence::Evidence,
    infer::posterior,
    solve::{Optimum, Solution, solve},
};

/// The most combinations of policies that are gone through to find the best of a diagram with limited memory.
const MAX_POLICIES: usize = 1 << 12;

/// How well both agree on one diagram.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// How many numbers were compared.
    pub numbers: usize,
    /// The largest difference, relative to numbers larger than 1.
    pub largest_error: f64,
    /// Whether the solver says that it found the maximum.
    pub optimum: Optimum,
    /// Whether the maximum was looked for by going through all policies; only with limited memory.
    pub exhausted: bool,
}

impl Comparison {
    fn see(&mut self, fast: f64, slow: f64) {
        self.numbers += 1;
        let error = (fast - slow).abs() / slow.abs().max(1.0);
        // What is no number must never pass.
        self.largest_error = if error.is_nan() { f64::INFINITY } else { self.largest_error.max(error) };
    }

    /// A number that must not be larger than another.
    fn at_most(&mut self, small: f64, large: f64) {
        self.see(small.max(large), large);
    }
}

/// Compares everything about one diagram: probability of the evidence, expected utility, what each alternative is worth after each past, what the policies
/// bring if they are followed, and all posteriors under them. With limited memory: that no change of one policy is for the better, and if it is said to be the maximum, that it is.
///
/// `None` if the diagram is too large to enumerate, or if both find the evidence impossible.
///
/// # Errors
/// What the solver said, unless it was right.
pub fn compare(diagram: &Diagram, evidence: &Evidence) -> Result<Option<Comparison>, SolveError> {
    let Some(slow) = enumerate::solve(diagram, evidence) else { return Ok(None) };
    let fast = match solve(diagram, evidence) {
        Err(SolveError::Impossible) if slow.probability == 0.0 => return Ok(None),
        fast => fast?,
    };
    let mut comparison = Comparison { numbers: 0, largest_error: 0.0, optimum: fast.optimum, exhausted: false };
    comparison.see(fast.probability, slow.probability);
    match diagram.memory() {
        Memory::Perfect => {
            comparison.see(fast.expected_utility, slow.expected_utility);
            for node in &slow.nodes {
                let past = node.past.iter().fold(Evidence::none(), |past, (variable, state)| past.observe(*variable, *state));
                let alternatives = fast.alternatives(diagram, node.decision, &past)?;
                alternatives.iter().zip(&node.alternatives).for_each(|(fast, slow)| comparison.see(*fast, *slow));
                // The one that is chosen is as good as any.
                let largest = node.alternatives.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                comparison.see(node.alternatives[fast.best(diagram, node.decision, &past)?], largest);
            }
        }
        Memory::Limited => limited(diagram, evidence, &fast, &mut comparison),
    }
    let network = fast.applied_to(diagram);
    let Some(followed) = enumerate::solve(&network, evidence) else { return Ok(None) };
    comparison.see(fast.expected_utility, followed.expected_utility);
    let slow = enumerate::posteriors(&network, evidence).unwrap_or_default();
    for (variable, slow) in network.variables().zip(slow) {
        let fast = posterior(&network, variable, evidence)?;
        fast.iter().zip(slow).for_each(|(fast, slow)| comparison.see(*fast, slow));
    }
    Ok(Some(comparison))
}

/// Tries to do better than a solution under limited memory.
fn limited(diagram: &Diagram, evidence: &Evidence, solution: &Solution, comparison: &mut Comparison) {
    let value = |network: &Diagram| enumerate::solve(network, evidence).map_or(f64::NAN, |slow| slow.expected_utility);
    let followed = solution.applied_to(diagram);
    for policy in &solution.policies {
        let decision = VariableId::from(policy.decision);
        for row in 0..policy.best().len() {
            for alternative in 0..diagram.extent(decision) {
                let mut best = policy.best().to_vec();
                best[row] = alternative;
                let other = with_policy(followed.clone(), decision, policy.given().to_vec(), &best);
                comparison.at_most(value(&other), solution.expected_utility);
            }
        }
    }
    let Some(maximum) = maximum(diagram, evidence, solution) else { return };
    comparison.exhausted = true;
    comparison.at_most(solution.expected_utility, maximum);
    if solution.optimum == Optimum::Global {
        comparison.see(solution.expected_utility, maximum);
    }
}

/// The most that any policies bring; `None` if there are too many.
fn maximum(diagram: &Diagram, evidence: &Evidence, solution: &Solution) -> Option<f64> {
    let rows = solution.policies.iter().flat_map(|policy| policy.best().iter().map(|_| diagram.extent(policy.decision)));
    let extents: Vec<usize> = rows.collect();
    let count = extents.iter().try_fold(1usize, |count, extent| count.checked_mul(*extent))?;
    let leaves: usize = diagram.variables().map(|variable| diagram.extent(variable)).product();
    if count.checked_mul(leaves)? > MAX_POLICIES * 64 || count > MAX_POLICIES {
        return None;
    }
    let mut maximum = f64::NEG_INFINITY;
    for number in 0..count {
        let mut rest = number;
        let mut digits = extents.iter().map(|extent| {
            let digit = rest % extent;
            rest /= extent;
            digit
        });
        let network = solution.policies.iter().fold(diagram.clone(), |network, policy| {
            let best: Vec<usize> = digits.by_ref().take(policy.best().len()).collect();
            with_policy(network, policy.decision.into(), policy.given().to_vec(), &best)
        });
        maximum = maximum.max(enumerate::solve(&network, evidence)?.expected_utility);
    }
    Some(maximum)
}

fn with_policy(network: Diagram, decision: VariableId, given: Vec<VariableId>, best: &[usize]) -> Diagram {
    let alternatives = network.extent(decision);
    let row = |best: &usize| -> Vec<f64> { (0..alternatives).map(|a| f64::from(u8::from(a == *best))).collect() };
    network.with_chance(decision, given, best.iter().flat_map(row).collect())
}
