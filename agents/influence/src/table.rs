//! Tables of numbers over variables.

use crate::diagram::{Diagram, VariableId};

/// A dense table: a number for each combination of the states of some variables, the first variable slowest.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    scope: Vec<VariableId>,
    extents: Vec<usize>,
    values: Vec<f64>,
}

impl Table {
    /// The caller knows that there are as many values as combinations.
    pub(crate) fn new(diagram: &Diagram, scope: Vec<VariableId>, values: Vec<f64>) -> Self {
        let extents = scope.iter().map(|variable| diagram.extent(*variable)).collect();
        Self { scope, extents, values }
    }

    /// The variables, slowest first.
    #[must_use]
    pub fn scope(&self) -> &[VariableId] {
        &self.scope
    }

    /// How many states each of them has.
    #[must_use]
    pub fn extents(&self) -> &[usize] {
        &self.extents
    }

    /// All numbers, row-major.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The number for one combination of states, in the order of [`Table::scope`]; `None` if there is no such combination.
    #[must_use]
    pub fn get(&self, states: &[usize]) -> Option<f64> {
        if states.len() != self.extents.len() {
            return None;
        }
        let mut place = 0;
        for (state, extent) in states.iter().zip(&self.extents) {
            place = place * extent + (state < extent).then_some(state)?;
        }
        self.values.get(place).copied()
    }
}
