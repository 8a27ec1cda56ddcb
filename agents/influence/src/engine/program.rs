//! What is to be done, in which order, and where everything lies.

use super::{
    MAX_CELLS,
    nest::Nest,
    order::Graph,
    symbolic::{Block, Elimination, Potential, cells},
};
use crate::{
    diagram::{Diagram, NodeId, VariableId},
    error::SolveError,
};

/// What will be known of a variable.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Mark {
    /// Nothing.
    #[default]
    Hidden,
    /// Its state: it is cut out of all tables when they are loaded.
    Fixed,
    /// A weight for each of its states, all of them 1 until told otherwise.
    Weighed,
}

/// Variables that are eliminated together, or one decision.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Round {
    /// Chance nodes, to be summed out in the order that suits best.
    Sum(Vec<VariableId>),
    /// A decision, to be maximised out.
    Maximise(VariableId),
}

/// What is asked of a diagram.
#[derive(Debug)]
pub(crate) struct Task<'t> {
    /// The structure; its numbers do not matter.
    pub(crate) diagram: &'t Diagram,
    /// What will be known of each variable.
    pub(crate) marks: &'t [Mark],
    /// Which variables the answer is about, in this order. None of them is fixed.
    pub(crate) keep: &'t [VariableId],
    /// All others that matter, first to be eliminated first. Those that do not matter are passed over.
    pub(crate) rounds: &'t [Round],
    /// Whether utilities are asked for.
    pub(crate) utilities: bool,
}

/// How a step combines tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Op {
    /// `out = a · b`
    Multiply,
    /// `out = a + b`
    Add,
    /// `out = Σ a · b`
    Contract,
    /// `out = Σ a`
    Sum,
    /// `out = out / a`, and 0 where `a` is 0: there nothing can happen, so nothing is lost.
    DivideBy,
    /// `out = out · a`
    MultiplyBy,
    /// `out = out + a`
    AddTo,
    /// All cells of `out` are this.
    Fill(f64),
    /// `out = a` for the first state.
    First,
    /// `out = max a`; of equals the first one. Records which.
    Maximise {
        /// Where the choices go.
        choices: usize,
        /// Among how many.
        alternatives: usize,
        /// From one alternative to the next.
        stride: usize,
    },
}

#[derive(Debug, Clone)]
pub(super) struct Step {
    pub(super) op: Op,
    pub(super) nest: Nest,
    pub(super) a: usize,
    pub(super) b: usize,
    pub(super) out: std::ops::Range<usize>,
}

impl Step {
    pub(super) fn new(op: Op, nest: Nest, [a, b, out]: [&Block; 3]) -> Self {
        Self { op, nest, a: a.start, b: b.start, out: out.start..out.start.saturating_add(out.len) }
    }
}

/// A table that comes from outside.
#[derive(Debug, Clone)]
pub(super) struct Input {
    pub(super) source: Source,
    pub(super) block: Block,
    /// Loops over what remains of the source when fixed variables are cut out.
    pub(super) nest: Nest,
    /// The variables that are cut out, and how far their states lie apart in the source.
    pub(super) cut: Vec<(VariableId, usize)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    Node(NodeId),
    Weights(VariableId),
}

/// How one decision was taken.
#[derive(Debug, Clone)]
pub(crate) struct Stage {
    /// Which decision.
    pub(crate) decision: VariableId,
    /// Where the choices are recorded. `None` if the decision changes nothing.
    pub(crate) choice: Option<Block>,
}

/// An elimination, ready to run.
#[derive(Debug, Clone)]
pub(crate) struct Program {
    pub(super) inputs: Vec<Input>,
    pub(super) steps: Vec<Step>,
    pub(super) size: usize,
    pub(super) choices: usize,
    /// How the decisions were taken, the last one first.
    pub(crate) stages: Vec<Stage>,
    /// The joint probability of the evidence and of what is kept.
    pub(crate) probability: Block,
    /// The expected utility given the evidence and what is kept; 0 where that is impossible.
    pub(crate) utility: Block,
}

impl Program {
    /// Prepares an elimination.
    ///
    /// # Errors
    /// [`SolveError::TooLarge`] if it would take more than [`MAX_CELLS`], and [`SolveError::Undecided`] if a decision matters that is neither kept nor fixed
    /// nor maximised.
    pub(crate) fn compile(task: &Task<'_>) -> Result<Self, SolveError> {
        let extents: Vec<usize> = task.diagram.variables().map(|variable| task.diagram.extent(variable)).collect();
        let relevant = relevant(task);
        undecided(task, &relevant)?;
        let sources = sources(task, &relevant);
        let order = order(task, &relevant, &sources, &extents);
        let mut rank = vec![usize::MAX; extents.len()];
        order.iter().enumerate().for_each(|(at, (variable, _))| rank[variable.0] = at);
        let mut elimination = Elimination {
            extents: &extents,
            rank,
            probabilities: Vec::new(),
            utilities: Vec::new(),
            steps: Vec::new(),
            size: 0,
            choices: 0,
        };
        let inputs = inputs(task, &sources, &mut elimination);
        let mut stages = Vec::new();
        for (variable, maximise) in order {
            if !maximise {
                elimination.sum(variable.0);
                continue;
            }
            stages.push(Stage { decision: variable, choice: elimination.maximise(variable.0) });
        }
        Self::finish(task, elimination, inputs, stages)
    }

    fn finish(
        task: &Task<'_>,
        mut elimination: Elimination<'_>,
        inputs: Vec<Input>,
        stages: Vec<Stage>,
    ) -> Result<Self, SolveError> {
        let keep: Vec<usize> = task.keep.iter().map(|variable| variable.0).collect();
        let probabilities: Vec<Block> = elimination.probabilities.iter().map(|potential| potential.block.clone()).collect();
        let utilities = std::mem::take(&mut elimination.utilities);
        let probability = elimination.gather(Op::MultiplyBy, &keep, &probabilities);
        let utility = elimination.gather(Op::AddTo, &keep, &utilities);
        let size = elimination.size.saturating_add(elimination.choices);
        if size > MAX_CELLS {
            return Err(SolveError::TooLarge { cells: size, limit: MAX_CELLS });
        }
        let Elimination { steps, size, choices, .. } = elimination;
        Ok(Self { inputs, steps, size, choices, stages, probability, utility })
    }
}

/// Which variables can make a difference: those that are asked for, known, seen or decided, those that utilities depend on, and their
/// ancestors. All others sum to 1.
fn relevant(task: &Task<'_>) -> Vec<bool> {
    let diagram = task.diagram;
    let mut relevant: Vec<bool> = task.marks.iter().map(|mark| *mark != Mark::Hidden).collect();
    task.keep.iter().for_each(|variable| relevant[variable.0] = true);
    for round in task.rounds {
        if let Round::Maximise(decision) = round {
            relevant[decision.0] = true;
            diagram.parents(*decision).iter().for_each(|seen| relevant[seen.0] = true);
        }
    }
    if task.utilities {
        diagram.utilities().flat_map(|utility| diagram.parents(utility)).for_each(|parent| relevant[parent.0] = true);
    }
    for variable in diagram.topological().iter().rev() {
        if relevant[variable.0] && !diagram.is_decision(*variable) {
            diagram.parents(*variable).iter().for_each(|parent| relevant[parent.0] = true);
        }
    }
    relevant
}

fn undecided(task: &Task<'_>, relevant: &[bool]) -> Result<(), SolveError> {
    let taken = |variable: VariableId| {
        task.keep.contains(&variable) || task.marks[variable.0] == Mark::Fixed || task.rounds.contains(&Round::Maximise(variable))
    };
    let open = task.diagram.decisions().find(|decision| relevant[decision.0] && !taken((*decision).into()));
    open.map_or(Ok(()), |decision| Err(SolveError::Undecided { decision: task.diagram.name_of(decision).to_owned() }))
}

/// The tables that take part, each with the variables that it knows once fixed ones are cut out.
fn sources(task: &Task<'_>, relevant: &[bool]) -> Vec<(Source, Vec<usize>)> {
    let diagram = task.diagram;
    let scope = |node: NodeId| {
        let all = diagram.parents(node).iter().copied().chain(node.variable());
        all.filter(|variable| task.marks[variable.0] != Mark::Fixed).map(|variable| variable.0).collect()
    };
    let matters = || diagram.variables().filter(|variable| relevant[variable.0]);
    let chances = matters().filter(|variable| !diagram.is_decision(*variable));
    let mut sources: Vec<_> = chances.map(|variable| (Source::Node(variable.into()), scope(variable.into()))).collect();
    let weighed = matters().filter(|variable| task.marks[variable.0] == Mark::Weighed);
    sources.extend(weighed.map(|variable| (Source::Weights(variable), vec![variable.0])));
    if task.utilities {
        sources.extend(diagram.utilities().map(|utility| (Source::Node(utility.into()), scope(utility.into()))));
    }
    sources
}

/// The variables in the order in which they are eliminated, and whether each is maximised.
fn order(task: &Task<'_>, relevant: &[bool], sources: &[(Source, Vec<usize>)], extents: &[usize]) -> Vec<(VariableId, bool)> {
    let mut graph = Graph::new(extents.len());
    sources.iter().for_each(|(_, scope)| graph.join(scope));
    let kept: Vec<usize> = task.keep.iter().map(|variable| variable.0).collect();
    graph.join(&kept);
    let matters =
        |variable: &VariableId| relevant[variable.0] && task.marks[variable.0] != Mark::Fixed && !task.keep.contains(variable);
    let mut order = Vec::new();
    for round in task.rounds {
        let (variables, maximise) = match round {
            Round::Sum(variables) => (variables.as_slice(), false),
            Round::Maximise(variable) => (std::slice::from_ref(variable), true),
        };
        let mut left: Vec<usize> = variables.iter().filter(|variable| matters(variable)).map(|variable| variable.0).collect();
        while let Some(next) = graph.next(&left, extents) {
            graph.eliminate(next);
            left.retain(|variable| *variable != next);
            order.push((VariableId(next), maximise));
        }
    }
    order
}

/// Lays the tables out in memory as they come.
fn inputs(task: &Task<'_>, sources: &[(Source, Vec<usize>)], elimination: &mut Elimination<'_>) -> Vec<Input> {
    let extents = elimination.extents;
    let mut inputs = Vec::new();
    for (source, scope) in sources {
        let block = elimination.allocate(scope.clone());
        let whole: Vec<usize> = match *source {
            Source::Node(node) => {
                task.diagram.parents(node).iter().copied().chain(node.variable()).map(|known| known.0).collect()
            }
            Source::Weights(variable) => vec![variable.0],
        };
        let from = Block { start: 0, len: cells(&whole, extents), scope: whole };
        let cut = from.scope.iter().filter(|known| task.marks[**known] == Mark::Fixed);
        let cut = cut.map(|known| (VariableId(*known), from.stride(*known, extents))).collect();
        let nest = Nest::new(scope, extents, [&from, &from, &block]);
        match *source {
            Source::Node(NodeId::Utility(_)) => elimination.utilities.push(block.clone()),
            Source::Node(NodeId::Variable(variable)) => {
                let fixed = task.marks[variable.0] == Mark::Fixed;
                let heads = if fixed { Vec::new() } else { vec![variable.0] };
                elimination.probabilities.push(Potential { block: block.clone(), heads, evidence: fixed });
            }
            Source::Weights(_) => {
                elimination.probabilities.push(Potential { block: block.clone(), heads: Vec::new(), evidence: true });
            }
        }
        inputs.push(Input { source: *source, block, nest, cut });
    }
    inputs
}
