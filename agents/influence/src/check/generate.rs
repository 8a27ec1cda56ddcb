//! Random diagrams.

use rand::{Rng, RngExt};

use crate::{
    diagram::{Diagram, DiagramBuilder, Memory, VariableId},
    evidence::{Evidence, Finding},
    solve::check_evidence_comes_first,
};

/// What random diagrams look like.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// How many chance nodes.
    pub chances: usize,
    /// How many decisions.
    pub decisions: usize,
    /// How many utilities.
    pub utilities: usize,
    /// The most states that a variable has; each has at least one.
    pub states: usize,
    /// The most parents that a node has, not counting the arc from each decision to the next.
    pub parents: usize,
    /// How often a probability is 0, from 0 to 1.
    pub zeros: f64,
    /// What is remembered. With perfect memory, an arc leads from each decision to the next.
    pub memory: Memory,
}

impl Default for Shape {
    /// Seven variables, two of which are decisions.
    fn default() -> Self {
        Self { chances: 5, decisions: 2, utilities: 2, states: 3, parents: 3, zeros: 0.1, memory: Memory::Perfect }
    }
}

/// A random diagram. The order in which it has its variables is not always parents first.
pub fn random_diagram(random: &mut impl Rng, shape: &Shape) -> Diagram {
    let count = shape.chances + shape.decisions;
    let mut is_decision: Vec<bool> = (0..count).map(|i| i < shape.decisions).collect();
    shuffle(random, &mut is_decision);
    let mut build = Diagram::builder("random");
    build.memory(shape.memory);
    let variables: Vec<VariableId> = is_decision.iter().map(|decision| variable(random, &mut build, shape, *decision)).collect();
    // Arcs go forward in an order of their own.
    let mut order = variables.clone();
    shuffle(random, &mut order);
    let mut last = None;
    for at in 0..order.len() {
        let node = order[at];
        let mut parents = sample(random, &order[..at], shape.parents);
        if is_decision[node.0] {
            if shape.memory == Memory::Perfect {
                parents.extend(last.filter(|last| !parents.contains(last)));
            }
            last = Some(node);
        }
        parents.iter().for_each(|parent| _ = build.arc(*parent, node));
        let rows = rows(&build, &parents);
        let table: Vec<f64> = (0..rows).flat_map(|_| distribution(random, extent(&build, node), shape.zeros)).collect();
        build.table(node, table);
    }
    for i in 0..shape.utilities {
        let parents = sample(random, &order, shape.parents);
        let table: Vec<f64> = (0..rows(&build, &parents)).map(|_| random.random_range(-10.0..10.0)).collect();
        build.utility(format!("u{i}")).given_all(parents).table(table);
    }
    // What is made here is sound by construction; an empty diagram would show in every test.
    build.build().unwrap_or_default()
}

/// Random findings, hard and soft, for about a third of the variables: such as can be known before the open decisions. They may be impossible.
pub fn random_evidence(random: &mut impl Rng, diagram: &Diagram) -> Evidence {
    let mut evidence = Evidence::none();
    for variable in diagram.topological() {
        let extent = diagram.extent(*variable);
        if !random.random_bool(0.3) || extent == 0 {
            continue;
        }
        let finding = if diagram.is_decision(*variable) || random.random_bool(0.6) {
            Finding::State(random.random_range(0..extent))
        } else {
            Finding::Likelihood((0..extent).map(|_| random.random()).collect())
        };
        evidence.insert(*variable, finding);
        if check_evidence_comes_first(diagram, &evidence.marks(diagram)).is_err() {
            evidence.remove(*variable);
        }
    }
    evidence
}

fn variable(random: &mut impl Rng, build: &mut DiagramBuilder, shape: &Shape, decision: bool) -> VariableId {
    let states: Vec<String> = (0..random.random_range(1..=shape.states.max(1))).map(|i| format!("s{i}")).collect();
    let name = format!("{}{}", if decision { "d" } else { "c" }, build.variables());
    if decision { build.decision(name, states).id().into() } else { build.chance(name, states).id().into() }
}

/// A row of probabilities, some of them 0.
fn distribution(random: &mut impl Rng, states: usize, zeros: f64) -> Vec<f64> {
    let weight = |random: &mut _| {
        if RngExt::random_bool(random, zeros.clamp(0.0, 1.0)) { 0.0 } else { RngExt::random_range(random, 0.05..1.0) }
    };
    let mut row: Vec<f64> = (0..states).map(|_| weight(random)).collect();
    if row.iter().all(|weight| *weight == 0.0) {
        row.fill(1.0);
    }
    let sum: f64 = row.iter().sum();
    row.iter_mut().for_each(|weight| *weight /= sum);
    row
}

fn extent(build: &DiagramBuilder, variable: VariableId) -> usize {
    build.states(variable).len()
}

fn rows(build: &DiagramBuilder, parents: &[VariableId]) -> usize {
    parents.iter().map(|parent| extent(build, *parent)).product()
}

/// Up to so many of these, in random order.
fn sample(random: &mut impl Rng, from: &[VariableId], most: usize) -> Vec<VariableId> {
    let mut all = from.to_vec();
    shuffle(random, &mut all);
    all.truncate(random.random_range(0..=most));
    all
}

/// Fisher and Yates' shuffle.
fn shuffle<T>(random: &mut impl Rng, items: &mut [T]) {
    for i in (1..items.len()).rev() {
        items.swap(i, random.random_range(0..=i));
    }
}
