//! Everything that is checked before a diagram is one.

use std::collections::BTreeSet;

use super::{
    Diagram, Fault, NodeId, UtilityId, VariableId,
    builder::{DiagramBuilder, RawUtility, RawVariable},
    graph,
};

/// How far the sum of a row of probabilities may be from 1.
pub const SUM_TOLERANCE: f64 = 1e-9;

/// Everything that is wrong, in the order of the nodes.
pub(super) fn faults(raw: &DiagramBuilder) -> Vec<(Option<NodeId>, Fault)> {
    let mut found = Vec::new();
    if !raw.name.is_empty() && !is_name(&raw.name) {
        found.push((None, Fault::BadName { name: raw.name.clone() }));
    }
    let mut names = BTreeSet::new();
    for (i, node) in raw.variables.iter().enumerate() {
        let mut report = |fault| found.push((Some(VariableId(i).into()), fault));
        name(&node.name, &mut names, &mut report);
        states(node, &mut report);
        let sound = parents(raw, &node.name, &node.parents, &mut report);
        if sound && !node.decision {
            numbers(&Shape::of_chance(raw, node), node.table.as_deref(), &mut report);
        }
    }
    for (i, node) in raw.utilities.iter().enumerate() {
        let mut report = |fault| found.push((Some(UtilityId(i).into()), fault));
        name(&node.name, &mut names, &mut report);
        if parents(raw, &node.name, &node.parents, &mut report) {
            numbers(&Shape::of_utility(raw, node), node.table.as_deref(), &mut report);
        }
    }
    found.extend(cycle(raw));
    found
}

fn name<'r>(name: &'r str, met: &mut BTreeSet<&'r str>, report: &mut impl FnMut(Fault)) {
    if !is_name(name) {
        report(Fault::BadName { name: name.to_owned() });
    }
    if !met.insert(name) {
        report(Fault::DuplicateName { name: name.to_owned() });
    }
}

/// Whether a file can hold this name and give it back as it was. XML knows no control characters and none of the last two.
fn is_name(name: &str) -> bool {
    let odd = |c: char| c.is_control() || c == '\u{fffe}' || c == '\u{ffff}';
    !name.is_empty() && name.trim() == name && !name.contains(odd)
}

fn states(node: &RawVariable, report: &mut impl FnMut(Fault)) {
    if node.states.is_empty() {
        report(Fault::NoStates { node: node.name.clone() });
    }
    let mut met = BTreeSet::new();
    for state in &node.states {
        if !is_name(state) {
            report(Fault::BadName { name: state.clone() });
        }
        if !met.insert(state) {
            report(Fault::DuplicateState { node: node.name.clone(), state: state.clone() });
        }
    }
}

/// Checks the arcs into one node; returns whether the shape of its table is known.
fn parents(raw: &DiagramBuilder, node: &str, parents: &[NodeId], report: &mut impl FnMut(Fault)) -> bool {
    let mut met = BTreeSet::new();
    let mut sound = true;
    for &parent in parents {
        let fault = match parent {
            NodeId::Utility(utility) => Some(raw.utilities.get(utility.0).map_or_else(
                || Fault::UnknownParent { node: node.to_owned(), parent: format!("utility {}", utility.0) },
                |utility| Fault::UtilityWithChildren { utility: utility.name.clone(), child: node.to_owned() },
            )),
            NodeId::Variable(variable) => match raw.variables.get(variable.0) {
                None => Some(Fault::UnknownParent { node: node.to_owned(), parent: format!("variable {}", variable.0) }),
                Some(parent) if !met.insert(variable) => {
                    Some(Fault::DuplicateParent { node: node.to_owned(), parent: parent.name.clone() })
                }
                Some(_) => None,
            },
        };
        sound &= fault.is_none();
        fault.into_iter().for_each(&mut *report);
    }
    sound
}

fn numbers(shape: &Shape<'_>, values: Option<&[f64]>, report: &mut impl FnMut(Fault)) {
    match (shape.cells(), values) {
        // A variable without states has been reported.
        (Some(0), _) => {}
        (None, _) => report(Fault::TableTooLarge { node: shape.node.to_owned(), parents: shape.parents.len() }),
        (_, None) => report(Fault::MissingTable { node: shape.node.to_owned(), shape: shape.in_words() }),
        (_, Some(values)) => table(shape, values).into_iter().for_each(report),
    }
}

fn cycle(raw: &DiagramBuilder) -> Option<(Option<NodeId>, Fault)> {
    let variables = |parents: &[NodeId]| parents.iter().filter_map(|parent| parent.variable()).map(|parent| parent.0).collect();
    let parents: Vec<Vec<usize>> = raw.variables.iter().map(|node| variables(&node.parents)).collect();
    let path = graph::circle(&parents, &graph::parents_first(&parents))?;
    let first = VariableId(*path.first()?);
    Some((Some(first.into()), Fault::Cycle { path: path.into_iter().map(|i| raw.variables[i].name.clone()).collect() }))
}

/// What a table has to look like: a name and its states for each parent, and the states of the node itself.
pub(super) struct Shape<'d> {
    node: &'d str,
    parents: Vec<(&'d str, &'d [String])>,
    /// `None` for a utility.
    states: Option<&'d [String]>,
}

impl<'d> Shape<'d> {
    fn of_chance(raw: &'d DiagramBuilder, node: &'d RawVariable) -> Self {
        Self { node: &node.name, parents: Self::raw_parents(raw, &node.parents), states: Some(&node.states) }
    }

    fn of_utility(raw: &'d DiagramBuilder, node: &'d RawUtility) -> Self {
        Self { node: &node.name, parents: Self::raw_parents(raw, &node.parents), states: None }
    }

    fn raw_parents(raw: &'d DiagramBuilder, parents: &[NodeId]) -> Vec<(&'d str, &'d [String])> {
        let parents = parents.iter().filter_map(|parent| raw.variables.get(parent.variable()?.0));
        parents.map(|parent| (parent.name.as_str(), parent.states.as_slice())).collect()
    }

    /// The shape of the table that a diagram has.
    pub(super) fn of(diagram: &'d Diagram, node: NodeId) -> Self {
        let parents = diagram.parents(node).iter().map(|parent| (diagram.name_of(*parent), diagram.states(*parent)));
        let states = node.variable().map(|variable| diagram.states(variable));
        Self { node: diagram.name_of(node), parents: parents.collect(), states }
    }

    /// How many numbers it has, if that can be counted.
    fn cells(&self) -> Option<usize> {
        let own = self.states.map_or(1, <[String]>::len);
        // A parent without states comes to nothing, however large the rest.
        if own == 0 || self.parents.iter().any(|(_, states)| states.is_empty()) {
            return Some(0);
        }
        self.parents.iter().try_fold(own, |cells, (_, states)| cells.checked_mul(states.len()))
    }

    fn in_words(&self) -> String {
        let cells = self.cells().unwrap_or(usize::MAX);
        let factor = |(name, states): &(&str, &[String])| format!("{} ({name})", states.len());
        let mut factors: Vec<String> = self.parents.iter().map(factor).collect();
        factors.extend(self.states.map(|states| format!("{} ({})", states.len(), self.node)));
        match factors.len() {
            0 => "1 number".to_owned(),
            1 => format!("{cells}: one for each state of {}", self.parents.first().map_or(self.node, |(name, _)| name)),
            _ => format!("{cells} = {}", factors.join(" x ")),
        }
    }

    /// Names one row by the states of the parents.
    fn row(&self, row: usize) -> String {
        if self.parents.is_empty() {
            return "its only row".to_owned();
        }
        let mut rest = row;
        let mut names = Vec::new();
        for (name, states) in self.parents.iter().rev() {
            names.push(format!("{name} = {}", states[rest % states.len()]));
            rest /= states.len();
        }
        names.reverse();
        format!("row {} ({})", row + 1, names.join(", "))
    }
}

/// Everything that is wrong with the numbers of one table.
pub(super) fn table(shape: &Shape<'_>, values: &[f64]) -> Vec<Fault> {
    let node = || shape.node.to_owned();
    let expected = shape.cells().unwrap_or(usize::MAX);
    if values.len() != expected {
        return vec![Fault::TableSize { node: node(), expected, found: values.len(), shape: shape.in_words() }];
    }
    let Some(states) = shape.states else {
        let odd = values.iter().enumerate().filter(|(_, value)| !value.is_finite());
        return odd.map(|(row, &value)| Fault::Utility { node: node(), row: shape.row(row), value }).collect();
    };
    let mut faults = Vec::new();
    for (row, values) in values.chunks(states.len().max(1)).enumerate() {
        // An infinity is no probability, and neither is what is no number.
        let odd = values.iter().zip(states).find(|(value, _)| !(0.0..=f64::MAX).contains(*value));
        let sum: f64 = values.iter().sum();
        if let Some((&value, state)) = odd {
            faults.push(Fault::Probability { node: node(), row: shape.row(row), state: state.clone(), value });
        } else if (sum - 1.0).abs() > SUM_TOLERANCE {
            faults.push(Fault::RowSum { node: node(), row: shape.row(row), sum });
        }
    }
    faults
}
