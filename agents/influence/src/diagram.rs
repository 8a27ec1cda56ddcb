//! The model: nodes, arcs and tables.
//!
//! A [`Diagram`] has *variables*, each with its named states, and *utilities*. A variable is either a **chance** node, with a
//! table of probabilities, or a **decision**, whose states are the alternatives. Arcs into chance nodes and utilities say what
//! the numbers depend on; arcs into a decision say what is known when it is made. The utilities add up.
//!
//! Diagrams come out of a [`DiagramBuilder`], or out of a file, and have been checked by then: the rest of the library
//! never meets a cycle or a table of the wrong size. Tables are dense and row-major: the parents in the order of their arcs, the first one slowest,
//! and the states of the node itself fastest.

mod builder;
mod fault;
mod graph;
mod ids;
#[cfg(test)]
mod tests;
mod validate;

pub use builder::{DiagramBuilder, Draft};
pub use fault::{BuildError, Fault};
pub(crate) use graph::Descent;
pub use ids::{ChanceId, DecisionId, NodeId, UtilityId, VariableId};
pub use validate::SUM_TOLERANCE;

/// What a decision maker remembers at each decision.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Memory {
    /// Everything that was seen and done before: *no-forgetting* (Howard & Matheson 1981). The decisions must follow each other on one path.
    #[default]
    Perfect,
    /// What the arcs into the decision say, and nothing else: a *limited-memory influence diagram* (Lauritzen & Nilsson 2001).
    Limited,
}

/// A checked influence diagram. Without decisions and utilities it is a Bayesian network.
///
/// Questions about a node of another diagram are answered as if it had no name, no states and no table.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Diagram {
    name: String,
    memory: Memory,
    variables: Vec<Variable>,
    utilities: Vec<Utility>,
    /// The variables, parents first.
    order: Vec<VariableId>,
}

#[derive(Debug, Clone, PartialEq)]
struct Variable {
    name: String,
    states: Vec<String>,
    parents: Vec<VariableId>,
    /// `None` for a decision.
    table: Option<Vec<f64>>,
}

#[derive(Debug, Clone, PartialEq)]
struct Utility {
    name: String,
    parents: Vec<VariableId>,
    table: Vec<f64>,
}

impl Diagram {
    /// Begins a diagram of this name.
    #[must_use]
    pub fn builder(name: impl Into<String>) -> DiagramBuilder {
        DiagramBuilder::new(name)
    }

    /// What the diagram is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What is remembered from one decision to the next.
    #[must_use]
    pub const fn memory(&self) -> Memory {
        self.memory
    }

    /// The same diagram under the other rule of remembering.
    #[must_use]
    pub fn with_memory(self, memory: Memory) -> Self {
        Self { memory, ..self }
    }

    /// All variables, in the order in which they were added.
    pub fn variables(&self) -> impl ExactSizeIterator<Item = VariableId> + use<> {
        (0..self.variables.len()).map(VariableId)
    }

    /// All variables, parents before children; otherwise in the order in which they were added.
    #[must_use]
    pub fn topological(&self) -> &[VariableId] {
        &self.order
    }

    /// The chance nodes, in the order in which they were added.
    pub fn chances(&self) -> impl Iterator<Item = ChanceId> {
        self.variables().filter_map(|variable| self.as_chance(variable))
    }

    /// The decisions, in the order in which they were added. When they are made is another matter.
    pub fn decisions(&self) -> impl Iterator<Item = DecisionId> {
        self.variables().filter_map(|variable| self.as_decision(variable))
    }

    /// The utilities, in the order in which they were added.
    pub fn utilities(&self) -> impl ExactSizeIterator<Item = UtilityId> + use<> {
        (0..self.utilities.len()).map(UtilityId)
    }

    /// This variable as a chance node, if it is one.
    #[must_use]
    pub fn as_chance(&self, variable: VariableId) -> Option<ChanceId> {
        self.variables.get(variable.0)?.table.as_ref().map(|_| ChanceId(variable.0))
    }

    /// This variable as a decision, if it is one.
    #[must_use]
    pub fn as_decision(&self, variable: VariableId) -> Option<DecisionId> {
        self.variables.get(variable.0)?.table.is_none().then_some(DecisionId(variable.0))
    }

    /// The node of this name.
    #[must_use]
    pub fn node(&self, name: &str) -> Option<NodeId> {
        let variable = self.variables.iter().position(|node| node.name == name);
        let utility = || self.utilities.iter().position(|node| node.name == name);
        variable.map(|i| VariableId(i).into()).or_else(|| utility().map(|i| UtilityId(i).into()))
    }

    /// The variable of this name.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<VariableId> {
        self.node(name)?.variable()
    }

    /// What a node is called.
    #[must_use]
    pub fn name_of(&self, node: impl Into<NodeId>) -> &str {
        match node.into() {
            NodeId::Variable(variable) => self.variables.get(variable.0).map_or("", |node| &node.name),
            NodeId::Utility(utility) => self.utilities.get(utility.0).map_or("", |node| &node.name),
        }
    }

    /// The states of a chance node, the alternatives of a decision.
    #[must_use]
    pub fn states(&self, variable: impl Into<VariableId>) -> &[String] {
        self.variables.get(variable.into().0).map_or(&[], |node| &node.states)
    }

    /// How many states a variable has.
    #[must_use]
    pub fn extent(&self, variable: impl Into<VariableId>) -> usize {
        self.states(variable).len()
    }

    /// The number of the state of this name.
    #[must_use]
    pub fn state(&self, variable: impl Into<VariableId>, name: &str) -> Option<usize> {
        self.states(variable).iter().position(|state| state == name)
    }

    /// Where the arcs into a node come from, in the order of its table. For a decision: what is seen.
    #[must_use]
    pub fn parents(&self, node: impl Into<NodeId>) -> &[VariableId] {
        match node.into() {
            NodeId::Variable(variable) => self.variables.get(variable.0).map_or(&[], |node| &node.parents),
            NodeId::Utility(utility) => self.utilities.get(utility.0).map_or(&[], |node| &node.parents),
        }
    }

    /// The table of a chance node, rows that sum to 1, or of a utility.
    #[must_use]
    pub fn table(&self, node: impl Into<NodeId>) -> &[f64] {
        match node.into() {
            NodeId::Variable(variable) => self.variables.get(variable.0).and_then(|node| node.table.as_deref()).unwrap_or(&[]),
            NodeId::Utility(utility) => self.utilities.get(utility.0).map_or(&[], |node| &node.table),
        }
    }

    /// New numbers for a chance node; the structure stays, so whatever was [planned](crate::Plan) for it goes on to hold.
    ///
    /// # Errors
    /// A [`Fault`] as for a table in a builder. The diagram is then as it was.
    pub fn set_probabilities(&mut self, chance: ChanceId, table: Vec<f64>) -> Result<(), Fault> {
        self.replace(chance.into(), table)
    }

    /// New numbers for a utility; see [`Diagram::set_probabilities`].
    ///
    /// # Errors
    /// A [`Fault`] as for a table in a builder. The diagram is then as it was.
    pub fn set_utilities(&mut self, utility: UtilityId, table: Vec<f64>) -> Result<(), Fault> {
        self.replace(utility.into(), table)
    }

    /// Whether both have the same nodes, states and arcs, in the same order; the numbers may differ.
    #[must_use]
    pub fn same_structure(&self, other: &Self) -> bool {
        let shape = |v: &Variable, w: &Variable| {
            v.states.len() == w.states.len() && v.parents == w.parents && v.table.is_some() == w.table.is_some()
        };
        self.variables.len() == other.variables.len()
            && self.variables.iter().zip(&other.variables).all(|(v, w)| shape(v, w))
            && self.utilities.len() == other.utilities.len()
            && self.utilities.iter().zip(&other.utilities).all(|(u, w)| u.parents == w.parents)
    }

    pub(crate) fn is_decision(&self, variable: VariableId) -> bool {
        self.as_decision(variable).is_some()
    }

    /// The same diagram, in which this variable is a chance node with these parents and this table.
    ///
    /// The caller knows that the table fits and that no cycle comes of it.
    pub(crate) fn with_chance(mut self, variable: VariableId, parents: Vec<VariableId>, table: Vec<f64>) -> Self {
        let node = &mut self.variables[variable.0];
        (node.parents, node.table) = (parents, Some(table));
        self.order = graph::order(&self);
        self
    }

    /// The same diagram, in which this variable is a decision that sees its parents.
    pub(crate) fn with_decision(mut self, variable: VariableId) -> Self {
        self.variables[variable.0].table = None;
        self
    }

    /// The same diagram, in which this decision sees these variables as well. The caller knows that no cycle comes of it.
    pub(crate) fn with_sight(mut self, decision: DecisionId, seen: &[VariableId]) -> Self {
        let parents = &mut self.variables[decision.0].parents;
        parents.extend(seen.iter().filter(|variable| variable.0 != decision.0));
        let mut met = std::collections::BTreeSet::new();
        parents.retain(|parent| met.insert(*parent));
        self.order = graph::order(&self);
        self
    }

    fn replace(&mut self, node: NodeId, table: Vec<f64>) -> Result<(), Fault> {
        let faulty = validate::table(&validate::Shape::of(self, node), &table).into_iter().next();
        let place = match node {
            NodeId::Variable(variable) => self.variables.get_mut(variable.0).and_then(|node| node.table.as_mut()),
            NodeId::Utility(utility) => self.utilities.get_mut(utility.0).map(|node| &mut node.table),
        };
        match (faulty, place) {
            (Some(fault), _) => Err(fault),
            (None, None) => Err(Fault::NoSuchNode),
            (None, Some(place)) => {
                *place = table;
                Ok(())
            }
        }
    }
}
