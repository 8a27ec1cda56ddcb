//! Solving the same structure again and again.

use super::{
    outcome::Outcome,
    sequence::{check_evidence_comes_first, strong_rounds},
};
use crate::{
    diagram::{Diagram, Memory, VariableId},
    engine::{Mark, Program, Task, Workspace},
    error::SolveError,
    evidence::{self, Evidence, Finding, weigh},
};

/// Everything about solving a diagram that does not depend on its numbers: the order of elimination and the place of every table. It has its own
/// memory, so that [`Plan::solve`] allocates nothing.
///
/// ```
/// use orienteer_influence::{Diagram, Evidence, Plan};
///
/// let mut build = Diagram::builder("bet");
/// let coin = build.chance("coin", ["heads", "tails"]).table([0.6, 0.4]);
/// let bet = build.decision("bet", ["heads", "tails"]).id();
/// build.utility("win").given(coin).given(bet).table([1.0, -1.0, -1.0, 1.0]);
/// let mut diagram = build.build()?;
/// let mut plan = Plan::new(&diagram, &[], &[])?;
/// for (heads, best) in [(0.6, 0), (0.3, 1)] {
///     diagram.set_probabilities(coin, vec![heads, 1.0 - heads])?;
///     let outcome = plan.solve(&diagram, &Evidence::none())?;
///     assert_eq!(outcome.choice(bet).map(|choice| choice.best[0]), Some(best));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Plan {
    /// The diagram as it was; only its structure matters.
    structure: Diagram,
    marks: Vec<Mark>,
    pub(super) program: Program,
    pub(super) workspace: Workspace,
    /// What the policy of each stage of the program depends on.
    pub(super) given: Vec<Vec<VariableId>>,
}

impl Plan {
    /// Plans for a diagram with perfect memory.
    ///
    /// The state of each variable in `fixed` will be told each time; this makes tables smaller. Of those in `weighed` a state, likelihoods or nothing will be told. Of
    /// all others nothing will be known.
    ///
    /// # Errors
    /// [`SolveError`]: nodes that do not fit, evidence that would come after an open decision, decisions without an order, limited memory, or a
    /// diagram too large.
    pub fn new(diagram: &Diagram, fixed: &[VariableId], weighed: &[VariableId]) -> Result<Self, SolveError> {
        if diagram.memory() == Memory::Limited {
            return Err(SolveError::LimitedMemory { diagram: diagram.name().to_owned() });
        }
        let marks = marks(diagram, fixed, weighed)?;
        check_evidence_comes_first(diagram, &marks)?;
        let rounds = strong_rounds(diagram, &marks)?;
        let program = Program::compile(&Task { diagram, marks: &marks, keep: &[], rounds: &rounds, utilities: true })?;
        let given = program.stages.iter().map(|stage| {
            let scope = stage.choice.iter().flat_map(|record| record.scope.iter());
            scope.map(|variable| VariableId(*variable)).collect()
        });
        Ok(Self { structure: diagram.clone(), marks, given: given.collect(), workspace: program.workspace(), program })
    }

    /// Solves a diagram of the planned structure.
    ///
    /// # Errors
    /// [`SolveError`]: another structure, evidence that was not planned for, does not fit or is impossible.
    pub fn solve(&mut self, diagram: &Diagram, evidence: &Evidence) -> Result<Outcome<'_>, SolveError> {
        if !self.structure.same_structure(diagram) {
            return Err(SolveError::OtherStructure { diagram: diagram.name().to_owned() });
        }
        evidence.check(diagram)?;
        for variable in diagram.variables() {
            let finding = evidence.get(variable);
            match (self.marks[variable.0], finding) {
                (Mark::Weighed, _) => {
                    self.program.weights(variable, &mut self.workspace).into_iter().for_each(|weights| weigh(weights, finding));
                }
                (Mark::Hidden, None) | (Mark::Fixed, Some(Finding::State(_))) => {}
                (Mark::Hidden, Some(_)) | (Mark::Fixed, _) => {
                    let variable = diagram.name_of(variable).to_owned();
                    return Err(SolveError::Unprepared { variable, told: finding.is_some() });
                }
            }
        }
        self.program.load(diagram, |variable| evidence.state(variable).unwrap_or_default(), &mut self.workspace);
        self.program.run(&mut self.workspace);
        let probability = evidence::possible(self.workspace.block(&self.program.probability)[0])?;
        Ok(Outcome { plan: self, expected_utility: self.workspace.block(&self.program.utility)[0], probability })
    }
}

/// What to expect of each variable.
pub(crate) fn marks(diagram: &Diagram, fixed: &[VariableId], weighed: &[VariableId]) -> Result<Vec<Mark>, SolveError> {
    let mut marks = vec![Mark::Hidden; diagram.variables().len()];
    let expected = fixed.iter().map(|v| (*v, Mark::Fixed)).chain(weighed.iter().map(|v| (*v, Mark::Weighed)));
    for (variable, mark) in expected {
        evidence::known(diagram, variable)?;
        let name = || diagram.name_of(variable).to_owned();
        if mark == Mark::Weighed && diagram.is_decision(variable) {
            return Err(SolveError::LikelihoodOfDecision { decision: name() });
        }
        if marks[variable.0] != Mark::Hidden {
            return Err(SolveError::Repeated { variable: name() });
        }
        marks[variable.0] = mark;
    }
    Ok(marks)
}
