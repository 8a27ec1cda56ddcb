//! Which variables tell nothing about which, whatever the numbers: d-separation (Pearl 1988, §3.3), by the ball of Shachter (1998).

use crate::diagram::{Diagram, UtilityId, VariableId};

/// The arcs of a diagram with its utilities, which come after the variables.
pub(super) struct Arcs {
    parents: Vec<Vec<usize>>,
    children: Vec<Vec<usize>>,
    variables: usize,
}

impl Arcs {
    /// All arcs but those into variables that are `cut`. A variable that is `weighed` has another child, which will always count as known: that
    /// is what likelihoods are.
    pub(super) fn new(diagram: &Diagram, cut: impl Fn(VariableId) -> bool, weighed: impl Fn(VariableId) -> bool) -> Self {
        let numbers = |parents: &[VariableId]| parents.iter().map(|parent| parent.0).collect();
        let of_variable = |v| if cut(v) { Vec::new() } else { numbers(diagram.parents(v)) };
        let mut parents: Vec<Vec<usize>> = diagram.variables().map(of_variable).collect();
        parents.extend(diagram.utilities().map(|utility| numbers(diagram.parents(utility))));
        parents.extend(diagram.variables().filter(|variable| weighed(*variable)).map(|variable| vec![variable.0]));
        let mut children = vec![Vec::new(); parents.len()];
        for (child, parents) in parents.iter().enumerate() {
            parents.iter().for_each(|parent| children[*parent].push(child));
        }
        Self { parents, children, variables: diagram.variables().len() }
    }

    /// The number of a utility among the nodes.
    pub(super) const fn utility(&self, utility: UtilityId) -> usize {
        self.variables + utility.0
    }

    /// The first nodes, which are variables and utilities; those after them are likelihoods.
    pub(super) fn is_likelihood(&self, node: usize, diagram: &Diagram) -> bool {
        node >= self.variables + diagram.utilities().len()
    }

    /// How many nodes there are.
    pub(super) const fn len(&self) -> usize {
        self.parents.len()
    }

    /// About which nodes something can be learnt from this one, if others are known.
    pub(super) fn reached(&self, from: usize, known: &[bool]) -> Vec<bool> {
        // Each node may be entered from a child, or from a parent.
        let mut entered = vec![[false; 2]; self.len()];
        let mut balls = vec![(from, 0)];
        while let Some((node, way)) = balls.pop() {
            if std::mem::replace(&mut entered[node][way], true) {
                continue;
            }
            let (from_child, from_parent) = (way == 0, way == 1);
            if (from_child && !known[node]) || (from_parent && known[node]) {
                balls.extend(self.parents[node].iter().map(|parent| (*parent, 0)));
            }
            if !known[node] {
                balls.extend(self.children[node].iter().map(|child| (*child, 1)));
            }
        }
        entered.iter().zip(known).map(|(ways, known)| !known && (ways[0] || ways[1])).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// a → b → c ← d, c → e
    fn chain_and_collider() -> Diagram {
        let mut build = Diagram::builder("chain and collider");
        let a = build.chance("a", ["x"]).table([1.0]);
        let b = build.chance("b", ["x"]).given(a).table([1.0]);
        let d = build.chance("d", ["x"]).table([1.0]);
        let c = build.chance("c", ["x"]).given(b).given(d).table([1.0]);
        build.chance("e", ["x"]).given(c).table([1.0]);
        build.build().unwrap()
    }

    fn tells(diagram: &Diagram, weighed: &str, from: &str, known: &str) -> String {
        let number = |name: char| diagram.variable(&name.to_string()).unwrap();
        let arcs = Arcs::new(diagram, |_| false, |v| weighed.contains(diagram.name_of(v)));
        let mut are_known: Vec<bool> = (0..arcs.len()).map(|node| arcs.is_likelihood(node, diagram)).collect();
        known.chars().for_each(|name| are_known[number(name).0] = true);
        let reached = arcs.reached(number(from.chars().next().unwrap()).0, &are_known);
        let mut names: Vec<_> = diagram.variables().filter(|v| reached[v.0]).map(|v| diagram.name_of(v)).collect();
        names.sort_unstable();
        names.concat()
    }

    #[test]
    fn knowledge_blocks_chains_and_opens_colliders() {
        let diagram = chain_and_collider();
        assert_eq!(tells(&diagram, "", "a", ""), "abce");
        assert_eq!(tells(&diagram, "", "a", "b"), "a");
        assert_eq!(tells(&diagram, "", "a", "c"), "abd");
        assert_eq!(tells(&diagram, "", "a", "e"), "abcd");
        assert_eq!(tells(&diagram, "", "a", "be"), "a");
        assert_eq!(tells(&diagram, "", "d", ""), "cde");
        assert_eq!(tells(&diagram, "e", "a", ""), "abcde", "a likelihood opens the collider above it");
    }
}
