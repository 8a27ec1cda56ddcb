//! Decisions that see what their arcs say, and remember nothing else.
//!
//! Single policy updating (Lauritzen & Nilsson 2001, §3): begin with policies that choose blindly, then make one after the other the best answer to all
//! others, until none changes. Every change is for the better and there are finitely many policies, so this ends, in a local maximum.
//!
//! A decision is *extremal* if, what it sees being known, the other decisions and what they see tell nothing about the utilities that it
//! influences (ibid., §4). Then its best policy does not depend on theirs; it can be taken as given, and the next extremal one be looked for. If all can be dealt with so, the
//! diagram is *soluble*, and updating in this order finds the maximum in one pass.

use super::{
    separation::Arcs,
    sequence::{check_evidence_comes_first, open_decisions},
    solution::{Optimum, Policy, Solution},
};
use crate::{
    compiled::first_largest,
    diagram::{DecisionId, Descent, Diagram, VariableId},
    engine::{MAX_CELLS, Mark, Program, Round, Task, Workspace},
    error::SolveError,
    evidence::{self, Evidence},
};

/// By how much a policy must be better to take the place of another, compared with what is expected. Less is rounding, and could go on for ever.
const LEAST_GAIN: f64 = 1e-12;

/// Solves a diagram with limited memory.
pub(super) fn solve(diagram: &Diagram, evidence: &Evidence) -> Result<Solution, SolveError> {
    evidence.check(diagram)?;
    let marks = evidence.marks(diagram);
    check_evidence_comes_first(diagram, &marks)?;
    let (order, soluble) = updating_order(diagram, &marks);
    let mut network = order.iter().try_fold(diagram.clone(), |network, decision| choose_blindly(network, *decision))?;
    let mut updates = Vec::new();
    for &decision in &order {
        updates.push(Update::new(&network, &marks, decision)?);
    }
    // Even blind policies make no evidence possible that is not.
    let expectation = Expectation::new(&network, &marks)?;
    let (_, probability) = expectation.of(&network, evidence)?;
    let mut changed = true;
    while changed {
        changed = false;
        for update in &mut updates {
            changed |= update.run(&mut network, evidence);
        }
    }
    let (expected_utility, _) = expectation.of(&network, evidence)?;
    let mut policies: Vec<Policy> = updates.iter().map(|update| update.policy(diagram)).collect();
    policies.sort_by_key(|policy| diagram.topological().iter().position(|v| *v == policy.decision.into()));
    let optimum = if soluble { Optimum::Global } else { Optimum::Local };
    Ok(Solution { expected_utility, probability, optimum, policies, evidence: evidence.clone() })
}

/// In which order to update, and whether one pass in this order finds the maximum.
fn updating_order(diagram: &Diagram, marks: &[Mark]) -> (Vec<DecisionId>, bool) {
    let made = |variable: VariableId| diagram.is_decision(variable) && marks[variable.0] == Mark::Fixed;
    let arcs = Arcs::new(diagram, made, |variable| marks[variable.0] == Mark::Weighed);
    let descent = Descent::new(diagram, made);
    // The last decision first: that is where extremal ones are, and a good way to begin if there are none.
    let mut open = open_decisions(diagram, marks);
    open.reverse();
    let mut order = Vec::new();
    while let Some(at) = open.iter().position(|decision| extremal(diagram, marks, &arcs, &descent, &open, *decision)) {
        order.push(open.remove(at));
    }
    let soluble = open.is_empty();
    order.extend(open);
    (order, soluble)
}

/// Whether the best policy of a decision is the same whatever those of the other open ones are.
fn extremal(
    diagram: &Diagram,
    marks: &[Mark],
    arcs: &Arcs,
    descent: &Descent<'_>,
    open: &[DecisionId],
    decision: DecisionId,
) -> bool {
    let family = |decision: DecisionId| diagram.parents(decision).iter().copied().chain([decision.into()]);
    let fixed = |node: usize| marks.get(node) == Some(&Mark::Fixed);
    let mut known: Vec<bool> = (0..arcs.len()).map(|node| fixed(node) || arcs.is_likelihood(node, diagram)).collect();
    family(decision).for_each(|variable| known[variable.0] = true);
    let influenced = descent.from(decision.into());
    let mut utilities = diagram.utilities().filter(|utility| diagram.parents(*utility).iter().any(|v| influenced[v.0]));
    utilities.all(|utility| {
        let reached = arcs.reached(arcs.utility(utility), &known);
        let mut others = open.iter().filter(|other| **other != decision).flat_map(|other| family(*other));
        !others.any(|variable| reached[variable.0])
    })
}

/// Puts a chance node in place of a decision, which takes each alternative with the same probability.
fn choose_blindly(network: Diagram, decision: DecisionId) -> Result<Diagram, SolveError> {
    let seen = network.parents(decision).to_vec();
    let rows = seen.iter().fold(1usize, |rows, variable| rows.saturating_mul(network.extent(*variable)));
    let alternatives = network.extent(decision);
    let cells = rows.saturating_mul(alternatives);
    if cells > MAX_CELLS {
        return Err(SolveError::TooLarge { cells, limit: MAX_CELLS });
    }
    Ok(network.with_chance(decision.into(), seen, vec![1.0 / alternatives as f64; cells]))
}

/// What can be expected under given policies.
struct Expectation {
    program: Program,
}

impl Expectation {
    fn new(network: &Diagram, marks: &[Mark]) -> Result<Self, SolveError> {
        let rounds = [Round::Sum(network.variables().collect())];
        let program = Program::compile(&Task { diagram: network, marks, keep: &[], rounds: &rounds, utilities: true })?;
        Ok(Self { program })
    }

    /// The expected utility, and the probability of the evidence.
    fn of(&self, network: &Diagram, evidence: &Evidence) -> Result<(f64, f64), SolveError> {
        let mut workspace = self.program.workspace();
        evidence.load(network, &self.program, &mut workspace);
        self.program.run(&mut workspace);
        let probability = evidence::possible(workspace.block(&self.program.probability)[0])?;
        Ok((workspace.block(&self.program.utility)[0], probability))
    }
}

/// One decision, as it is made best if the others stay as they are.
struct Update {
    decision: DecisionId,
    /// What it sees; its policy has these in this order.
    seen: Vec<VariableId>,
    /// Those of them whose state is not given by the evidence.
    open: Vec<VariableId>,
    alternatives: usize,
    best: Vec<Option<usize>>,
    program: Program,
    workspace: Workspace,
}

impl Update {
    fn new(network: &Diagram, marks: &[Mark], decision: DecisionId) -> Result<Self, SolveError> {
        let structure = network.clone().with_decision(decision.into());
        let seen = network.parents(decision).to_vec();
        let open: Vec<VariableId> = seen.iter().copied().filter(|variable| marks[variable.0] != Mark::Fixed).collect();
        let keep: Vec<VariableId> = open.iter().copied().chain([decision.into()]).collect();
        let rounds = [Round::Sum(network.variables().collect())];
        let program = Program::compile(&Task { diagram: &structure, marks, keep: &keep, rounds: &rounds, utilities: true })?;
        let rows = open.iter().map(|variable| network.extent(*variable)).product();
        let workspace = program.workspace();
        Ok(Self { decision, seen, open, alternatives: network.extent(decision), best: vec![None; rows], program, workspace })
    }

    /// Makes this policy the best answer to the others; says whether it changed.
    fn run(&mut self, network: &mut Diagram, evidence: &Evidence) -> bool {
        evidence.load(network, &self.program, &mut self.workspace);
        self.program.run(&mut self.workspace);
        let probability = self.workspace.block(&self.program.probability);
        let utility = self.workspace.block(&self.program.utility);
        let mut changed = false;
        let rows = probability.chunks(self.alternatives).zip(utility.chunks(self.alternatives));
        for (best, (probability, utility)) in self.best.iter_mut().zip(rows) {
            // Where the past is impossible, nothing is better than anything else.
            let possible = probability.iter().any(|p| *p > 0.0);
            let top = if possible { first_largest(utility) } else { 0 };
            let better =
                best.is_none_or(|best| possible && utility[top] - utility[best] > LEAST_GAIN * (1.0 + utility[best].abs()));
            if better {
                (*best, changed) = (Some(top), true);
            }
        }
        if changed {
            let table = self.as_probabilities(network, evidence);
            *network = std::mem::take(network).with_chance(self.decision.into(), self.seen.clone(), table);
        }
        changed
    }

    /// The policy over all that is seen, with what is fixed; rows that contradict the evidence are never asked for, and choose blindly.
    fn as_probabilities(&self, network: &Diagram, evidence: &Evidence) -> Vec<f64> {
        let rows: usize = self.seen.iter().map(|variable| network.extent(*variable)).product();
        let mut table = vec![1.0 / self.alternatives as f64; rows * self.alternatives];
        for (place, best) in self.best.iter().enumerate() {
            let (mut rest, mut row, mut below) = (place, 0, 1);
            for &variable in self.seen.iter().rev() {
                let extent = network.extent(variable);
                let state = if self.open.contains(&variable) {
                    let state = rest % extent;
                    rest /= extent;
                    state
                } else {
                    evidence.state(variable).unwrap_or_default()
                };
                row += state * below;
                below *= extent;
            }
            let row = &mut table[row * self.alternatives..(row + 1) * self.alternatives];
            row.fill(0.0);
            row[best.unwrap_or_default()] = 1.0;
        }
        table
    }

    fn policy(&self, diagram: &Diagram) -> Policy {
        let best = self.best.iter().map(|best| best.unwrap_or_default()).collect();
        Policy::new(diagram, self.decision, self.open.clone(), best)
    }
}
