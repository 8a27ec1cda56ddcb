//! Putting a diagram together, node by node.

use super::{
    BuildError, ChanceId, DecisionId, Diagram, Memory, NodeId, Utility, UtilityId, Variable, VariableId, graph, validate,
};

/// A diagram in the making: anything may be missing or wrong until [`build`](DiagramBuilder::build).
///
/// ```
/// use orienteer_influence::Diagram;
///
/// let mut build = Diagram::builder("alarm");
/// let fire = build.chance("fire", ["no", "yes"]).table([0.99, 0.01]);
/// build.chance("smoke", ["no", "yes"]).given(fire).table([0.98, 0.02, 0.1, 0.9]);
/// assert_eq!(build.build()?.extent(fire), 2);
///
/// let mut build = Diagram::builder("careless");
/// build.chance("fire", ["no", "yes"]).table([0.99, 0.1]);
/// assert_eq!(build.build().unwrap_err().to_string(), r#""fire", its only row: the probabilities sum to 1.09, not to 1"#);
/// # Ok::<(), orienteer_influence::BuildError>(())
/// ```
#[derive(Debug, Clone)]
pub struct DiagramBuilder {
    pub(super) name: String,
    pub(super) memory: Memory,
    pub(super) variables: Vec<RawVariable>,
    pub(super) utilities: Vec<RawUtility>,
}

#[derive(Debug, Clone)]
pub(super) struct RawVariable {
    pub name: String,
    pub states: Vec<String>,
    pub parents: Vec<NodeId>,
    pub decision: bool,
    pub table: Option<Vec<f64>>,
}

#[derive(Debug, Clone)]
pub(super) struct RawUtility {
    pub name: String,
    pub parents: Vec<NodeId>,
    pub table: Option<Vec<f64>>,
}

impl DiagramBuilder {
    /// An empty diagram of this name.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), memory: Memory::default(), variables: Vec::new(), utilities: Vec::new() }
    }

    /// Says what is remembered from one decision to the next; [`Memory::Perfect`] unless told.
    pub const fn memory(&mut self, memory: Memory) -> &mut Self {
        self.memory = memory;
        self
    }

    /// Adds a chance node with these states.
    pub fn chance<S: Into<String>>(
        &mut self,
        name: impl Into<String>,
        states: impl IntoIterator<Item = S>,
    ) -> Draft<'_, ChanceId> {
        let id = ChanceId(self.add(name.into(), states.into_iter().map(Into::into).collect(), false));
        Draft { builder: self, id }
    }

    /// Adds a decision between these alternatives.
    pub fn decision<S: Into<String>>(
        &mut self,
        name: impl Into<String>,
        alternatives: impl IntoIterator<Item = S>,
    ) -> Draft<'_, DecisionId> {
        let id = DecisionId(self.add(name.into(), alternatives.into_iter().map(Into::into).collect(), true));
        Draft { builder: self, id }
    }

    /// Adds a utility.
    pub fn utility(&mut self, name: impl Into<String>) -> Draft<'_, UtilityId> {
        let id = UtilityId(self.utilities.len());
        self.utilities.push(RawUtility { name: name.into(), parents: Vec::new(), table: None });
        Draft { builder: self, id }
    }

    /// Draws an arc; the parent becomes the last one of the child. [`Draft::given`] is shorter where the parent is there first.
    pub fn arc(&mut self, parent: impl Into<NodeId>, child: impl Into<NodeId>) -> &mut Self {
        let parent = parent.into();
        match child.into() {
            NodeId::Variable(VariableId(child)) => self.variables.get_mut(child).map(|node| node.parents.push(parent)),
            NodeId::Utility(UtilityId(child)) => self.utilities.get_mut(child).map(|node| node.parents.push(parent)),
        };
        self
    }

    /// Gives a chance node or a utility its table, in place of any that it had. A decision has none: there it does nothing.
    pub fn table(&mut self, node: impl Into<NodeId>, table: impl Into<Vec<f64>>) -> &mut Self {
        let place = match node.into() {
            NodeId::Variable(VariableId(i)) => {
                self.variables.get_mut(i).filter(|node| !node.decision).map(|node| &mut node.table)
            }
            NodeId::Utility(UtilityId(i)) => self.utilities.get_mut(i).map(|node| &mut node.table),
        };
        if let Some(place) = place {
            *place = Some(table.into());
        }
        self
    }

    /// The states of a variable as they are so far.
    #[must_use]
    pub fn states(&self, variable: impl Into<VariableId>) -> &[String] {
        self.variables.get(variable.into().0).map_or(&[], |node| &node.states)
    }

    /// How many variables there are so far.
    #[must_use]
    pub fn variables(&self) -> usize {
        self.variables.len()
    }

    /// Checks everything and makes the diagram.
    ///
    /// # Errors
    /// All [`Fault`](super::Fault)s at once.
    pub fn build(self) -> Result<Diagram, BuildError> {
        let faults = validate::faults(&self);
        if !faults.is_empty() {
            return Err(BuildError::new(faults));
        }
        let variables = |parents: Vec<NodeId>| parents.into_iter().filter_map(NodeId::variable).collect();
        let variable = |raw: RawVariable| Variable {
            name: raw.name,
            states: raw.states,
            parents: variables(raw.parents),
            table: if raw.decision { None } else { raw.table },
        };
        let utility =
            |raw: RawUtility| Utility { name: raw.name, parents: variables(raw.parents), table: raw.table.unwrap_or_default() };
        let mut diagram = Diagram {
            name: self.name,
            memory: self.memory,
            variables: self.variables.into_iter().map(variable).collect(),
            utilities: self.utilities.into_iter().map(utility).collect(),
            order: Vec::new(),
        };
        diagram.order = graph::order(&diagram);
        Ok(diagram)
    }

    fn add(&mut self, name: String, states: Vec<String>, decision: bool) -> usize {
        self.variables.push(RawVariable { name, states, parents: Vec::new(), decision, table: None });
        self.variables.len() - 1
    }
}

/// A node that was just added, for its arcs and its table to be said in the same breath.
#[derive(Debug)]
pub struct Draft<'b, Id> {
    builder: &'b mut DiagramBuilder,
    id: Id,
}

impl<Id: Copy + Into<NodeId>> Draft<'_, Id> {
    /// Draws an arc from this variable. Into a decision it means that the variable is seen before.
    pub fn given(self, parent: impl Into<VariableId>) -> Self {
        self.builder.arc(parent.into(), self.id);
        self
    }

    /// Draws arcs from all these variables, in this order.
    pub fn given_all<V: Into<VariableId>>(self, parents: impl IntoIterator<Item = V>) -> Self {
        parents.into_iter().fold(self, Self::given)
    }

    /// The node as it stands. Without a table it still wants one: [`DiagramBuilder::table`].
    pub const fn id(self) -> Id {
        self.id
    }
}

impl Draft<'_, ChanceId> {
    /// The probabilities: for each combination of the parents' states, the first parent slowest, one row with a number per state.
    pub fn table(self, table: impl Into<Vec<f64>>) -> ChanceId {
        self.builder.table(self.id, table);
        self.id
    }
}

impl Draft<'_, UtilityId> {
    /// The utilities: a number for each combination of the parents' states, the first parent slowest.
    pub fn table(self, table: impl Into<Vec<f64>>) -> UtilityId {
        self.builder.table(self.id, table);
        self.id
    }
}
