//! The same question again and again, with other evidence each time.
//!
//! Everything that does not depend on what is known is worked out beforehand: the order of elimination, the place of every table, the numbers themselves. What is
//! left is arithmetic, and allocates nothing.

use crate::{
    diagram::{ChanceId, DecisionId, Diagram, VariableId},
    engine::{Mark, Program, Round, Task, Workspace},
    error::SolveError,
    evidence::{self, Finding, weigh},
    infer::check_targets,
    solve::{Now, Solution, marks},
};

/// Takes findings for those variables of which they were announced.
#[derive(Debug, Clone)]
struct Listener {
    /// What the numbers are from.
    network: Diagram,
    /// What may be told.
    observable: Vec<VariableId>,
    program: Program,
    workspace: Workspace,
}

impl Listener {
    fn new(network: Diagram, observable: &[VariableId], program: Program) -> Self {
        let mut workspace = program.workspace();
        program.load(&network, |_| 0, &mut workspace);
        Self { network, observable: observable.to_vec(), program, workspace }
    }

    fn weights(&mut self, variable: VariableId) -> Result<&mut [f64], SolveError> {
        evidence::known(&self.network, variable)?;
        let unprepared = || SolveError::Unprepared { variable: self.network.name_of(variable).to_owned(), told: true };
        if !self.observable.contains(&variable) {
            return Err(unprepared());
        }
        self.program.weights(variable, &mut self.workspace).ok_or_else(unprepared)
    }

    fn observe(&mut self, variable: VariableId, state: usize) -> Result<(), SolveError> {
        evidence::known(&self.network, variable)?;
        evidence::check_state(&self.network, variable, state)?;
        weigh(self.weights(variable)?, Some(&Finding::State(state)));
        Ok(())
    }

    fn likelihood(&mut self, chance: ChanceId, likelihoods: &[f64]) -> Result<(), SolveError> {
        let variable = chance.into();
        evidence::known(&self.network, variable)?;
        evidence::check_likelihoods(&self.network, variable, likelihoods)?;
        self.weights(variable)?.copy_from_slice(likelihoods);
        Ok(())
    }

    fn forget(&mut self) {
        for variable in &self.observable {
            self.program.weights(*variable, &mut self.workspace).into_iter().for_each(|weights| weigh(weights, None));
        }
    }
}

/// The joint probability of some variables, for any evidence on others.
///
/// ```
/// use orienteer_influence::{CompiledQuery, Diagram};
///
/// let mut build = Diagram::builder("alarm");
/// let fire = build.chance("fire", ["no", "yes"]).table([0.9, 0.1]);
/// let alarm = build.chance("alarm", ["silent", "rings"]).given(fire).table([0.9, 0.1, 0.1, 0.9]);
/// let mut query = CompiledQuery::new(&build.build()?, &[fire.into()], &[alarm.into()])?;
/// query.observe(alarm, 1)?;
/// assert_eq!(query.posterior()?, [0.5, 0.5]);
/// query.forget();
/// assert_eq!(query.posterior()?, [0.9, 0.1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct CompiledQuery {
    listener: Listener,
    answer: Vec<f64>,
}

impl CompiledQuery {
    /// Prepares to answer about these variables when something is told about any of the chance nodes that are `observable`.
    ///
    /// # Errors
    /// [`SolveError`]: nodes that do not fit or are named twice, an open decision on which the answer depends, a diagram too large.
    pub fn new(diagram: &Diagram, variables: &[VariableId], observable: &[VariableId]) -> Result<Self, SolveError> {
        check_targets(diagram, variables)?;
        if let Some(decision) = variables.iter().find(|variable| diagram.is_decision(**variable)) {
            return Err(SolveError::Undecided { decision: diagram.name_of(*decision).to_owned() });
        }
        let marks = marks(diagram, &[], observable)?;
        let rounds = [Round::Sum(diagram.variables().collect())];
        let program = Program::compile(&Task { diagram, marks: &marks, keep: variables, rounds: &rounds, utilities: false })?;
        let listener = Listener::new(diagram.clone(), observable, program);
        let answer = vec![0.0; listener.workspace.block(&listener.program.probability).len()];
        Ok(Self { listener, answer })
    }

    /// Tells the state of a variable, in place of whatever was told of it.
    ///
    /// # Errors
    /// [`SolveError`]: no such variable or state, or one that is not observable.
    pub fn observe(&mut self, variable: impl Into<VariableId>, state: usize) -> Result<(), SolveError> {
        self.listener.observe(variable.into(), state)
    }

    /// Tells how well each state of a chance node agrees with what was observed, in place of whatever was told of it.
    ///
    /// # Errors
    /// [`SolveError`]: likelihoods that do not fit, or a variable that is not observable.
    pub fn likelihood(&mut self, chance: ChanceId, likelihoods: &[f64]) -> Result<(), SolveError> {
        self.listener.likelihood(chance, likelihoods)
    }

    /// Forgets everything that was told.
    pub fn forget(&mut self) {
        self.listener.forget();
    }

    /// The probability of each combination of states, given what was told; the first variable slowest.
    ///
    /// # Errors
    /// [`SolveError::Impossible`] if what was told can't be.
    pub fn posterior(&mut self) -> Result<&[f64], SolveError> {
        let Listener { program, workspace, .. } = &mut self.listener;
        program.run(workspace);
        let joint = workspace.block(&program.probability);
        let total = evidence::possible(joint.iter().sum())?;
        self.answer.iter_mut().zip(joint).for_each(|(answer, joint)| *answer = joint / total);
        Ok(&self.answer)
    }
}

/// One decision, to be made now on whatever is known: other decisions follow the policies of a solution.
///
/// What is observable but was not told is unknown, also to the decision. So it is asked "what if I decided already?", which a policy, a table over everything that
/// will have been seen, can't answer.
///
/// ```
/// use orienteer_influence::{CompiledPolicy, Diagram, Evidence, solve};
///
/// let mut build = Diagram::builder("umbrella");
/// let weather = build.chance("weather", ["sun", "rain"]).table([0.7, 0.3]);
/// let forecast = build.chance("forecast", ["fine", "mixed", "wet"]).given(weather).table([0.7, 0.2, 0.1, 0.15, 0.25, 0.6]);
/// let umbrella = build.decision("umbrella", ["take", "leave"]).given(forecast).id();
/// build.utility("comfort").given(weather).given(umbrella).table([20.0, 100.0, 70.0, 0.0]);
/// let diagram = build.build()?;
/// let solution = solve(&diagram, &Evidence::none())?;
/// let mut policy = CompiledPolicy::new(&diagram, &solution, umbrella, &[forecast.into()])?;
/// assert_eq!(policy.advise()?.best, 1);
/// policy.observe(forecast, 2)?;
/// assert_eq!(policy.advise()?.best, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct CompiledPolicy {
    listener: Listener,
}

/// What to do now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advice<'p> {
    /// The best alternative; of equals the first one.
    pub best: usize,
    /// What can be expected of each alternative, given what was told.
    pub alternatives: &'p [f64],
    /// How probable it is, what was told.
    pub probability: f64,
}

impl CompiledPolicy {
    /// Prepares to advise on a decision when something is told about any of the chance nodes that are `observable`. The solution is one of this diagram; hard evidence
    /// with which it was found goes on to hold.
    ///
    /// # Errors
    /// [`SolveError`]: nodes that do not fit, a decision that was not open, something observable on which the decision has an influence, a diagram too large.
    pub fn new(
        diagram: &Diagram,
        solution: &Solution,
        decision: DecisionId,
        observable: &[VariableId],
    ) -> Result<Self, SolveError> {
        solution.evidence.check(diagram)?;
        solution.open(diagram, decision)?;
        let hard = |(variable, finding): (VariableId, &Finding)| matches!(finding, Finding::State(_)).then_some(variable);
        let fixed: Vec<VariableId> = solution.evidence.iter().filter_map(hard).collect();
        let mut weighed = observable.to_vec();
        let soft =
            solution.evidence.iter().map(|(variable, _)| variable).filter(|v| !fixed.contains(v) && !observable.contains(v));
        weighed.extend(soft);
        let marks: Vec<Mark> = marks(diagram, &fixed, &weighed)?;
        let Now { network, program } = Now::new(diagram, solution, decision, &marks)?;
        let mut listener = Listener::new(network, observable, program);
        solution.evidence.load(&listener.network, &listener.program, &mut listener.workspace);
        Ok(Self { listener })
    }

    /// Tells the state of a variable, in place of whatever was told of it.
    ///
    /// # Errors
    /// [`SolveError`]: no such variable or state, or one that is not observable.
    pub fn observe(&mut self, variable: impl Into<VariableId>, state: usize) -> Result<(), SolveError> {
        self.listener.observe(variable.into(), state)
    }

    /// Tells how well each state of a chance node agrees with what was observed, in place of whatever was told of it.
    ///
    /// # Errors
    /// [`SolveError`]: likelihoods that do not fit, or a variable that is not observable.
    pub fn likelihood(&mut self, chance: ChanceId, likelihoods: &[f64]) -> Result<(), SolveError> {
        self.listener.likelihood(chance, likelihoods)
    }

    /// Forgets everything that was told.
    pub fn forget(&mut self) {
        self.listener.forget();
    }

    /// What is best, given what was told.
    ///
    /// # Errors
    /// [`SolveError::Impossible`] if what was told can't be.
    pub fn advise(&mut self) -> Result<Advice<'_>, SolveError> {
        let Listener { program, workspace, .. } = &mut self.listener;
        program.run(workspace);
        let probability = evidence::possible(workspace.block(&program.probability)[0])?;
        let alternatives = workspace.block(&program.utility);
        Ok(Advice { best: first_largest(alternatives), alternatives, probability })
    }
}

/// The place of the largest number; of equals the first one.
pub(crate) fn first_largest(values: &[f64]) -> usize {
    (0..values.len()).reduce(|best, i| if values[i] > values[best] { i } else { best }).unwrap_or_default()
}
