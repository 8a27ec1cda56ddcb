//! Names for nodes that can't be mixed up.

/// A chance node or a decision: whatever has states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VariableId(pub(crate) usize);

/// A chance node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChanceId(pub(crate) usize);

/// A decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DecisionId(pub(crate) usize);

/// A utility.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UtilityId(pub(crate) usize);

/// Any node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NodeId {
    /// A chance node or a decision.
    Variable(VariableId),
    /// A utility.
    Utility(UtilityId),
}

impl NodeId {
    /// This node as a variable, if it is one.
    #[must_use]
    pub const fn variable(self) -> Option<VariableId> {
        match self {
            Self::Variable(variable) => Some(variable),
            Self::Utility(_) => None,
        }
    }
}

impl From<ChanceId> for VariableId {
    fn from(ChanceId(index): ChanceId) -> Self {
        Self(index)
    }
}

impl From<DecisionId> for VariableId {
    fn from(DecisionId(index): DecisionId) -> Self {
        Self(index)
    }
}

impl From<VariableId> for NodeId {
    fn from(variable: VariableId) -> Self {
        Self::Variable(variable)
    }
}

impl From<ChanceId> for NodeId {
    fn from(chance: ChanceId) -> Self {
        Self::Variable(chance.into())
    }
}

impl From<DecisionId> for NodeId {
    fn from(decision: DecisionId) -> Self {
        Self::Variable(decision.into())
    }
}

impl From<UtilityId> for NodeId {
    fn from(utility: UtilityId) -> Self {
        Self::Utility(utility)
    }
}
