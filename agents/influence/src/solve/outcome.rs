//! What a plan found, still in its memory.

use super::{
    plan::Plan,
    solution::{Optimum, Policy, Solution},
};
use crate::{
    diagram::{DecisionId, Diagram, VariableId},
    evidence::Evidence,
};

/// A solved diagram, in the memory of its plan.
#[derive(Debug, Clone, Copy)]
pub struct Outcome<'p> {
    pub(super) plan: &'p Plan,
    /// The maximum expected utility, given the evidence.
    pub expected_utility: f64,
    /// The probability of the evidence; 1 if there is none.
    pub probability: f64,
}

/// The policy of one decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice<'p> {
    /// On which of the variables known by then the policy depends.
    pub given: &'p [VariableId],
    /// The best alternative for each combination of their states, the first variable slowest.
    pub best: &'p [usize],
}

impl<'p> Outcome<'p> {
    /// The policy of a decision; `None` if it was not open.
    #[must_use]
    pub fn choice(&self, decision: DecisionId) -> Option<Choice<'p>> {
        let plan = self.plan;
        let at = plan.program.stages.iter().position(|stage| stage.decision == decision.into())?;
        let best = match &plan.program.stages[at].choice {
            Some(record) => plan.workspace.choices(record),
            None => &[0],
        };
        Some(Choice { given: &plan.given[at], best })
    }

    /// A copy that outlives the plan's memory. The diagram is the one that was solved, with this evidence.
    #[must_use]
    pub fn to_solution(&self, diagram: &Diagram, evidence: &Evidence) -> Solution {
        let policies = self.plan.program.stages.iter().rev().filter_map(|stage| {
            let decision = diagram.as_decision(stage.decision)?;
            let Choice { given, best } = self.choice(decision)?;
            Some(Policy::new(diagram, decision, given.to_vec(), best.to_vec()))
        });
        Solution {
            expected_utility: self.expected_utility,
            probability: self.probability,
            optimum: Optimum::Global,
            policies: policies.collect(),
            evidence: evidence.clone(),
        }
    }
}
