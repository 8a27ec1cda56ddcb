//! What can be wrong with a diagram, in words.

use std::fmt;

use thiserror::Error;

use super::NodeId;

/// One thing that is wrong with a diagram.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Fault {
    /// Arcs lead back to where they began.
    #[error("the arcs go round in a circle: {}; take one of them out", path.join(" -> "))]
    Cycle {
        /// The nodes along the circle; the first one again at the end.
        path: Vec<String>,
    },
    /// A chance node or utility without numbers.
    #[error("{node:?} has no table; it needs {shape}")]
    MissingTable {
        /// Which node.
        node: String,
        /// What the table would have to look like.
        shape: String,
    },
    /// A table with too many numbers, or too few.
    #[error("the table of {node:?} has {found} numbers, but needs {shape}")]
    TableSize {
        /// Which node.
        node: String,
        /// How many numbers there should be.
        expected: usize,
        /// How many there are.
        found: usize,
        /// What the table would have to look like.
        shape: String,
    },
    /// A table that nobody could write down: more numbers than can be counted.
    #[error("the table of {node:?} would be too large to be counted; it has {parents} parents: split it into several nodes")]
    TableTooLarge {
        /// Which node.
        node: String,
        /// How many parents it has.
        parents: usize,
    },
    /// Probabilities that do not sum to 1.
    #[error("{node:?}, {row}: the probabilities sum to {sum}, not to 1")]
    RowSum {
        /// Which node.
        node: String,
        /// Which row of its table.
        row: String,
        /// Its sum.
        sum: f64,
    },
    /// A number that is no probability.
    #[error("{node:?}, {row}: {value} for {state:?} is no probability; they are finite and at least 0")]
    Probability {
        /// Which node.
        node: String,
        /// Which row of its table.
        row: String,
        /// Which state.
        state: String,
        /// What stands there.
        value: f64,
    },
    /// A utility that is infinite or no number.
    #[error("{node:?}, {row}: {value} is no utility; they are finite, so use a large number for what must never happen")]
    Utility {
        /// Which node.
        node: String,
        /// Where in its table.
        row: String,
        /// What stands there.
        value: f64,
    },
    /// Two nodes of one name.
    #[error("there are two nodes named {name:?}; call one of them something else")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// Two states of one name.
    #[error("{node:?} has two states named {state:?}; call one of them something else")]
    DuplicateState {
        /// Which node.
        node: String,
        /// The name.
        state: String,
    },
    /// Two arcs from one node to another.
    #[error("{node:?} has {parent:?} as a parent twice; take one arc out")]
    DuplicateParent {
        /// Which node.
        node: String,
        /// Its parent.
        parent: String,
    },
    /// A parent that is no node of the diagram.
    #[error("{node:?} has a parent that is not in the diagram: {parent}; nodes of other diagrams can't be used")]
    UnknownParent {
        /// Which node.
        node: String,
        /// The parent.
        parent: String,
    },
    /// An arc that leaves a utility.
    #[error("{child:?} has the utility {utility:?} as a parent, but utilities have no children; they add up by themselves")]
    UtilityWithChildren {
        /// The utility.
        utility: String,
        /// Where the arc leads.
        child: String,
    },
    /// A variable without states.
    #[error("{node:?} has no states; a variable has at least one")]
    NoStates {
        /// Which node.
        node: String,
    },
    /// A name that a file could not hold.
    #[error("{name:?} can't be a name: it is empty, begins or ends with a space, or has control characters")]
    BadName {
        /// The name.
        name: String,
    },
    /// Numbers for something that is not in the diagram, or has none.
    #[error("there is no table to be replaced: the node is not in this diagram, or is a decision")]
    NoSuchNode,
}

/// Everything that is wrong with a diagram; at least one thing.
#[derive(Debug, Clone, PartialEq)]
pub struct BuildError {
    faults: Vec<(Option<NodeId>, Fault)>,
}

impl BuildError {
    pub(super) const fn new(faults: Vec<(Option<NodeId>, Fault)>) -> Self {
        Self { faults }
    }

    /// The faults, each with the node at which it was found, in the order of the nodes. `None` is the diagram itself.
    #[must_use]
    pub fn faults(&self) -> &[(Option<NodeId>, Fault)] {
        &self.faults
    }
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (_, fault)) in self.faults.iter().enumerate() {
            write!(f, "{}{fault}", if i == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl std::error::Error for BuildError {}
