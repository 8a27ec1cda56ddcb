//! Walks along the arcs.

use std::{cmp::Reverse, collections::BinaryHeap};

use super::{Diagram, VariableId};

/// Sorts nodes so that parents come first; of those that could be next, the lowest number is. Nodes on circles, and what comes
/// after them, are left out. Parents beyond the end are passed over.
pub(super) fn parents_first(parents: &[Vec<usize>]) -> Vec<usize> {
    let nodes = parents.len();
    let (mut children, mut missing) = (vec![Vec::new(); nodes], vec![0usize; nodes]);
    for (child, parents) in parents.iter().enumerate() {
        for &parent in parents.iter().filter(|parent| **parent < nodes) {
            children[parent].push(child);
            missing[child] += 1;
        }
    }
    let mut ready: BinaryHeap<_> = (0..nodes).filter(|node| missing[*node] == 0).map(Reverse).collect();
    let mut order = Vec::with_capacity(nodes);
    while let Some(Reverse(node)) = ready.pop() {
        order.push(node);
        for &child in &children[node] {
            missing[child] -= 1;
            if missing[child] == 0 {
                ready.push(Reverse(child));
            }
        }
    }
    order
}

/// A circle among the nodes that [`parents_first`] left out, if it left any: in the direction of the arcs, the first node again at the end.
pub(super) fn circle(parents: &[Vec<usize>], order: &[usize]) -> Option<Vec<usize>> {
    let mut left_out = vec![true; parents.len()];
    order.iter().for_each(|node| left_out[*node] = false);
    let mut node = left_out.iter().position(|left_out| *left_out)?;
    let (mut path, mut seen_at) = (Vec::new(), vec![None; parents.len()]);
    // Whatever was left out has a parent that was left out as well, so this way back never ends but in a circle.
    while seen_at[node].is_none() {
        seen_at[node] = Some(path.len());
        path.push(node);
        node = *parents[node].iter().find(|parent| left_out.get(**parent) == Some(&true))?;
    }
    path.drain(..seen_at[node]?);
    path.push(node);
    path.reverse();
    Some(path)
}

/// The variables of a diagram, parents first.
pub(super) fn order(diagram: &Diagram) -> Vec<VariableId> {
    let parents: Vec<Vec<usize>> =
        diagram.variables.iter().map(|node| node.parents.iter().map(|parent| parent.0).collect()).collect();
    parents_first(&parents).into_iter().map(VariableId).collect()
}

/// Who comes after whom.
pub(crate) struct Descent<'d> {
    diagram: &'d Diagram,
    children: Vec<Vec<usize>>,
}

impl<'d> Descent<'d> {
    /// All arcs of a diagram, but for those into these variables.
    pub(crate) fn new(diagram: &'d Diagram, cut: impl Fn(VariableId) -> bool) -> Self {
        let mut children = vec![Vec::new(); diagram.variables.len()];
        for variable in diagram.variables().filter(|variable| !cut(*variable)) {
            diagram.parents(variable).iter().for_each(|parent| children[parent.0].push(variable.0));
        }
        Self { diagram, children }
    }

    /// Which variables can be reached from this one along the arcs, itself included.
    pub(crate) fn from(&self, variable: VariableId) -> Vec<bool> {
        let mut reached = vec![false; self.children.len()];
        reached[variable.0] = true;
        for node in &self.diagram.order {
            if reached[node.0] {
                self.children[node.0].iter().for_each(|child| reached[*child] = true);
            }
        }
        reached
    }
}
