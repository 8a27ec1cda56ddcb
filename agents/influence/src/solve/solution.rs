//! Policies, and what alternatives are worth.

use super::now::Now;
use crate::{
    diagram::{DecisionId, Diagram, VariableId},
    error::SolveError,
    evidence::{self, Evidence},
};

/// How good a solution is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Optimum {
    /// No policies are better.
    Global,
    /// No change of a single policy makes it better; a change of several at once might.
    Local,
}

/// The policies of all open decisions, and what they are worth.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// What can be expected under these policies, given the evidence.
    pub expected_utility: f64,
    /// The probability of the evidence; 1 if there is none.
    pub probability: f64,
    /// Whether this is the best that there is.
    pub optimum: Optimum,
    /// A policy for each decision that was open, the first one to be made first.
    pub policies: Vec<Policy>,
    /// What was known when it was found.
    pub evidence: Evidence,
}

/// What to do at one decision.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    /// Which decision.
    pub decision: DecisionId,
    given: Vec<VariableId>,
    extents: Vec<usize>,
    alternatives: usize,
    best: Vec<usize>,
}

impl Policy {
    pub(super) fn new(diagram: &Diagram, decision: DecisionId, given: Vec<VariableId>, best: Vec<usize>) -> Self {
        let extents = given.iter().map(|variable| diagram.extent(*variable)).collect();
        Self { decision, given, extents, alternatives: diagram.extent(decision), best }
    }

    /// On which of the variables known by then it depends. Others may have been seen, but make no difference.
    #[must_use]
    pub fn given(&self) -> &[VariableId] {
        &self.given
    }

    /// The best alternative for each combination of the states of [`Policy::given`], the first variable slowest.
    #[must_use]
    pub fn best(&self) -> &[usize] {
        &self.best
    }

    /// Whether the policy is for a decision like that in this diagram.
    fn fits(&self, diagram: &Diagram) -> bool {
        diagram.is_decision(self.decision.into())
            && diagram.extent(self.decision) == self.alternatives
            && self.given.iter().zip(&self.extents).all(|(variable, extent)| diagram.extent(*variable) == *extent)
    }

    /// The policy as a table of probabilities, over what is given and the alternatives: 1 for the best one.
    fn as_probabilities(&self) -> Vec<f64> {
        let mut table = vec![0.0; self.best.len() * self.alternatives];
        for (row, best) in table.chunks_mut(self.alternatives).zip(&self.best) {
            row[*best] = 1.0;
        }
        table
    }
}

impl Solution {
    /// The policy of a decision; `None` if it was not open.
    #[must_use]
    pub fn policy(&self, decision: DecisionId) -> Option<&Policy> {
        self.policies.iter().find(|policy| policy.decision == decision)
    }

    /// The best alternative after this past. The diagram is the one that was solved.
    ///
    /// # Errors
    /// [`SolveError::MissingPast`] if it depends on something that the past does not tell; [`SolveError::UnknownVariable`] if the decision was not open; and
    /// what [`Evidence::check`] says.
    pub fn best(&self, diagram: &Diagram, decision: DecisionId, past: &Evidence) -> Result<usize, SolveError> {
        past.check(diagram)?;
        let policy = self.open(diagram, decision)?;
        let mut place = 0;
        for (variable, extent) in policy.given.iter().zip(&policy.extents) {
            place = place * extent + past.state(*variable).ok_or_else(|| missing(diagram, *variable))?;
        }
        Ok(policy.best.get(place).copied().unwrap_or_default())
    }

    /// What can be expected of each alternative, if it is known what was seen and done before the decision, and all decisions of which that is not said
    /// follow their policies. The evidence with which the diagram was solved holds besides. The diagram is the one that was solved.
    ///
    /// The past may be a part of what will be known by then; the rest is then taken to be unknown for good. Ask [`CompiledPolicy`](crate::CompiledPolicy) where
    /// it has to be fast.
    ///
    /// # Errors
    /// [`SolveError`]: a past that does not fit, is impossible or comes after the decision; a decision that was not open; a diagram too large.
    pub fn alternatives(&self, diagram: &Diagram, decision: DecisionId, past: &Evidence) -> Result<Vec<f64>, SolveError> {
        self.open(diagram, decision)?;
        let mut known = self.evidence.clone();
        past.iter().for_each(|(variable, finding)| known.insert(variable, finding.clone()));
        known.check(diagram)?;
        let now = Now::new(diagram, self, decision, &known.marks(diagram))?;
        let mut workspace = now.program.workspace();
        known.load(&now.network, &now.program, &mut workspace);
        now.program.run(&mut workspace);
        evidence::possible(workspace.block(&now.program.probability)[0])?;
        Ok(workspace.block(&now.program.utility).to_vec())
    }

    /// The diagram with these policies in place of the decisions: each is a chance node now, which depends on what its policy depends on. Nodes keep their
    /// numbers, so their ids can be used with it as [`VariableId`]s.
    ///
    /// So it can be [asked](crate::posterior) how probable anything is if one acts upon the policies.
    #[must_use]
    pub fn applied_to(&self, diagram: &Diagram) -> Diagram {
        self.applied_but_to(diagram, |_| false)
    }

    /// [`Solution::applied_to`], but some decisions stay as they are.
    pub(super) fn applied_but_to(&self, diagram: &Diagram, stays: impl Fn(DecisionId) -> bool) -> Diagram {
        let policies = self.policies.iter().filter(|policy| policy.fits(diagram) && !stays(policy.decision));
        policies.fold(diagram.clone(), |diagram, policy| {
            diagram.with_chance(policy.decision.into(), policy.given.clone(), policy.as_probabilities())
        })
    }

    /// The policy of a decision that was open.
    pub(crate) fn open(&self, diagram: &Diagram, decision: DecisionId) -> Result<&Policy, SolveError> {
        let unknown = || SolveError::UnknownVariable { index: decision.0, diagram: diagram.name().to_owned() };
        self.policy(decision).ok_or_else(unknown)
    }
}

fn missing(diagram: &Diagram, variable: VariableId) -> SolveError {
    SolveError::MissingPast { variable: diagram.name_of(variable).to_owned() }
}
