//! What is known.

use std::collections::BTreeMap;

use crate::{
    diagram::{ChanceId, Diagram, VariableId},
    engine::{Mark, Program, Workspace},
    error::SolveError,
};

/// What is known of one variable.
#[derive(Debug, Clone, PartialEq)]
pub enum Finding {
    /// Its state, or the alternative that was taken: *hard* evidence.
    State(usize),
    /// For each state, how probable what was observed would be in it: *soft* or likelihood evidence (Pearl 1988, §2.2.2). Only the ratios matter to posteriors.
    Likelihood(Vec<f64>),
}

/// What is known of some variables. It is known from the beginning, before any open decision.
///
/// ```
/// use orienteer_influence::{Diagram, Evidence, posterior};
///
/// let mut build = Diagram::builder("alarm");
/// let fire = build.chance("fire", ["no", "yes"]).table([0.9, 0.1]);
/// let alarm = build.chance("alarm", ["silent", "rings"]).given(fire).table([0.9, 0.1, 0.1, 0.9]);
/// let diagram = build.build()?;
/// let heard = Evidence::none().observe(alarm, 1);
/// assert_eq!(posterior(&diagram, fire, &heard)?, [0.5, 0.5]);
/// let heard_something = Evidence::none().likelihood(alarm, [0.5, 1.0]);
/// assert!(posterior(&diagram, fire, &heard_something)?[1] < 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Evidence {
    findings: BTreeMap<VariableId, Finding>,
}

impl Evidence {
    /// Nothing is known.
    #[must_use]
    pub fn none() -> Self {
        Self::default()
    }

    /// Adds that this variable is in this state, or that this alternative was taken; in place of whatever was known of it.
    #[must_use]
    pub fn observe(mut self, variable: impl Into<VariableId>, state: usize) -> Self {
        self.insert(variable, Finding::State(state));
        self
    }

    /// Adds how well each state of a chance node agrees with what was observed; in place of whatever was known of it.
    #[must_use]
    pub fn likelihood(mut self, chance: ChanceId, likelihoods: impl Into<Vec<f64>>) -> Self {
        self.insert(chance, Finding::Likelihood(likelihoods.into()));
        self
    }

    /// Adds a finding, in place of whatever was known of the variable.
    pub fn insert(&mut self, variable: impl Into<VariableId>, finding: Finding) {
        self.findings.insert(variable.into(), finding);
    }

    /// Forgets what was known of a variable.
    pub fn remove(&mut self, variable: impl Into<VariableId>) -> Option<Finding> {
        self.findings.remove(&variable.into())
    }

    /// What is known of a variable.
    #[must_use]
    pub fn get(&self, variable: impl Into<VariableId>) -> Option<&Finding> {
        self.findings.get(&variable.into())
    }

    /// The state of a variable, if that is what is known.
    #[must_use]
    pub fn state(&self, variable: impl Into<VariableId>) -> Option<usize> {
        match self.get(variable)? {
            Finding::State(state) => Some(*state),
            Finding::Likelihood(_) => None,
        }
    }

    /// All that is known, in the order of the variables.
    pub fn iter(&self) -> impl Iterator<Item = (VariableId, &Finding)> {
        self.findings.iter().map(|(variable, finding)| (*variable, finding))
    }

    /// Checks that all this can be said of a diagram.
    ///
    /// # Errors
    /// The first finding that can't.
    pub fn check(&self, diagram: &Diagram) -> Result<(), SolveError> {
        for (variable, finding) in self.iter() {
            known(diagram, variable)?;
            match finding {
                Finding::State(state) => check_state(diagram, variable, *state)?,
                Finding::Likelihood(likelihoods) => check_likelihoods(diagram, variable, likelihoods)?,
            }
        }
        Ok(())
    }

    /// What a program has to expect.
    pub(crate) fn marks(&self, diagram: &Diagram) -> Vec<Mark> {
        let mark = |variable| match self.get(variable) {
            None => Mark::Hidden,
            Some(Finding::State(_)) => Mark::Fixed,
            Some(Finding::Likelihood(_)) => Mark::Weighed,
        };
        diagram.variables().map(mark).collect()
    }

    /// Fills numbers and evidence into the memory of a program. Both have been checked.
    pub(crate) fn load(&self, diagram: &Diagram, program: &Program, workspace: &mut Workspace) {
        program.load(diagram, |variable| self.state(variable).unwrap_or_default(), workspace);
        for (variable, finding) in self.iter() {
            if let Some(weights) = program.weights(variable, workspace) {
                weigh(weights, Some(finding));
            }
        }
    }
}

/// Writes down what is known as a weight for each state.
pub(crate) fn weigh(weights: &mut [f64], finding: Option<&Finding>) {
    match finding {
        None => weights.fill(1.0),
        Some(Finding::Likelihood(likelihoods)) => weights.iter_mut().zip(likelihoods).for_each(|(weight, l)| *weight = *l),
        Some(Finding::State(state)) => {
            weights.fill(0.0);
            weights.get_mut(*state).into_iter().for_each(|weight| *weight = 1.0);
        }
    }
}

/// Checks that a diagram has this variable.
pub(crate) fn known(diagram: &Diagram, variable: VariableId) -> Result<(), SolveError> {
    if variable.0 < diagram.variables().len() {
        return Ok(());
    }
    Err(SolveError::UnknownVariable { index: variable.0, diagram: diagram.name().to_owned() })
}

pub(crate) fn check_state(diagram: &Diagram, variable: VariableId, state: usize) -> Result<(), SolveError> {
    let states = diagram.extent(variable);
    if state < states {
        return Ok(());
    }
    Err(SolveError::UnknownState { variable: diagram.name_of(variable).to_owned(), states, state })
}

pub(crate) fn check_likelihoods(diagram: &Diagram, variable: VariableId, likelihoods: &[f64]) -> Result<(), SolveError> {
    let name = || diagram.name_of(variable).to_owned();
    let (states, found) = (diagram.extent(variable), likelihoods.len());
    if diagram.is_decision(variable) {
        return Err(SolveError::LikelihoodOfDecision { decision: name() });
    }
    if found != states {
        return Err(SolveError::LikelihoodSize { variable: name(), states, found });
    }
    match likelihoods.iter().find(|likelihood| !(0.0..=1.0).contains(*likelihood)) {
        Some(&value) => Err(SolveError::Likelihood { variable: name(), value }),
        None => Ok(()),
    }
}

/// Passes on the probability of what is known, unless it is 0 or too small to be divided by.
pub(crate) fn possible(probability: f64) -> Result<f64, SolveError> {
    if probability.is_normal() { Ok(probability) } else { Err(SolveError::Impossible) }
}
