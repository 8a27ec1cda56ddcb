//! Everything by going through all states of all variables.
//!
//! The tree of Howard & Matheson (1981): the variables one below the other in the order in which they become known, what is never seen last. At
//! the leaves stand a probability and a utility. Going back up, chances add and decisions take the largest. Nothing here is clever.

use crate::{
    diagram::{DecisionId, Diagram, VariableId},
    evidence::{Evidence, Finding},
};

/// The most leaves that a tree may have.
pub const MAX_LEAVES: usize = 1 << 22;

/// A decision after one past.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Which decision.
    pub decision: DecisionId,
    /// Everything that was seen and done before.
    pub past: Vec<(VariableId, usize)>,
    /// How probable the past is together with the evidence, if those decisions are made.
    pub probability: f64,
    /// What can be expected of each alternative.
    pub alternatives: Vec<f64>,
}

/// What came of going through all states.
#[derive(Debug, Clone, PartialEq)]
pub struct Enumeration {
    /// The probability of the evidence.
    pub probability: f64,
    /// The maximum expected utility, given the evidence; no number if that is impossible.
    pub expected_utility: f64,
    /// All decisions after all pasts that are possible.
    pub nodes: Vec<Node>,
}

/// Solves a diagram as if it had perfect memory. `None` if it is too large.
#[must_use]
pub fn solve(diagram: &Diagram, evidence: &Evidence) -> Option<Enumeration> {
    let mut tree = Tree::new(diagram, evidence)?;
    let (probability, weighted) = tree.descend(0);
    Some(Enumeration { probability, expected_utility: weighted / probability, nodes: tree.nodes })
}

/// The probability of each state of each variable, given the evidence, in a diagram without open decisions. `None` if it is too large. No numbers if the evidence
/// is impossible.
#[must_use]
pub fn posteriors(diagram: &Diagram, evidence: &Evidence) -> Option<Vec<Vec<f64>>> {
    let mut tree = Tree::new(diagram, evidence)?;
    tree.marginals = diagram.variables().map(|variable| vec![0.0; diagram.extent(variable)]).collect();
    let (probability, _) = tree.descend(0);
    Some(tree.marginals.into_iter().map(|row| row.into_iter().map(|weight| weight / probability).collect()).collect())
}

struct Tree<'t> {
    diagram: &'t Diagram,
    evidence: &'t Evidence,
    /// The variables in the order in which they become known, and which of them are open decisions.
    sequence: Vec<(VariableId, bool)>,
    states: Vec<usize>,
    nodes: Vec<Node>,
    /// The weight of each state of each variable; empty if nobody wants to know.
    marginals: Vec<Vec<f64>>,
}

impl<'t> Tree<'t> {
    fn new(diagram: &'t Diagram, evidence: &'t Evidence) -> Option<Self> {
        let leaves = diagram.variables().try_fold(1usize, |leaves, variable| leaves.checked_mul(diagram.extent(variable)))?;
        if leaves > MAX_LEAVES {
            return None;
        }
        let mut sequence: Vec<(VariableId, bool)> = Vec::new();
        let mut add = |variable: VariableId| {
            if !sequence.iter().any(|(known, _)| *known == variable) {
                sequence.push((variable, diagram.is_decision(variable) && evidence.state(variable).is_none()));
            }
        };
        for &variable in diagram.topological().iter().filter(|variable| diagram.is_decision(**variable)) {
            diagram.parents(variable).iter().for_each(|parent| add(*parent));
            add(variable);
        }
        diagram.variables().for_each(add);
        let states = vec![0; sequence.len()];
        Some(Self { diagram, evidence, sequence, states, nodes: Vec::new(), marginals: Vec::new() })
    }

    /// The probability of all that is below a node of the tree, and the utility weighted with it.
    fn descend(&mut self, depth: usize) -> (f64, f64) {
        let Some(&(variable, open)) = self.sequence.get(depth) else { return self.leaf() };
        let mut branches = Vec::new();
        for state in 0..self.diagram.extent(variable) {
            self.states[variable.0] = state;
            branches.push(self.descend(depth + 1));
        }
        if !open {
            return branches.iter().fold((0.0, 0.0), |(p, u), (q, v)| (p + q, u + v));
        }
        let best = branches.iter().copied().reduce(|best, next| if next.1 > best.1 { next } else { best });
        let probability = branches.first().map_or(0.0, |(probability, _)| *probability);
        if probability > 0.0
            && let Some(decision) = self.diagram.as_decision(variable)
        {
            let past = self.sequence[..depth].iter().map(|(known, _)| (*known, self.states[known.0])).collect();
            let alternatives = branches.iter().map(|(probability, weighted)| weighted / probability).collect();
            self.nodes.push(Node { decision, past, probability, alternatives });
        }
        best.unwrap_or((0.0, 0.0))
    }

    fn leaf(&mut self) -> (f64, f64) {
        let diagram = self.diagram;
        let mut probability = 1.0;
        for variable in diagram.variables() {
            let state = self.states[variable.0];
            probability *= match self.evidence.get(variable) {
                None => 1.0,
                Some(Finding::State(known)) => f64::from(u8::from(*known == state)),
                Some(Finding::Likelihood(likelihoods)) => likelihoods[state],
            };
            if !diagram.is_decision(variable) {
                let row = self.row(diagram.parents(variable));
                probability *= diagram.table(variable)[row * diagram.extent(variable) + state];
            }
        }
        for (row, state) in self.marginals.iter_mut().zip(&self.states) {
            row[*state] += probability;
        }
        let utility: f64 = diagram.utilities().map(|utility| diagram.table(utility)[self.row(diagram.parents(utility))]).sum();
        (probability, probability * utility)
    }

    fn row(&self, parents: &[VariableId]) -> usize {
        parents.iter().fold(0, |row, parent| row * self.diagram.extent(*parent) + self.states[parent.0])
    }
}
