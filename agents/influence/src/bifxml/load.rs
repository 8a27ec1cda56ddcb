//! Reading.

use std::collections::BTreeMap;

use roxmltree::{Document, Node, ParsingOptions, TextPos};

use super::error::{LoadError, LoadFault, Problem};
use crate::diagram::{Diagram, DiagramBuilder, Fault, Memory, NodeId, SUM_TOLERANCE};

/// How far the sum of a row of probabilities may be from 1 in a file. Most programs write few digits.
pub const ROUNDING: f64 = 1e-3;

/// The most problems that are told of one file.
const MOST_PROBLEMS: usize = 20;

/// Reads a diagram from the bytes of a file.
///
/// ```
/// use orienteer_influence::bifxml;
///
/// let text = b"<BIF>\n<NETWORK>\n<VARIABLE TYPE='nature'><NAME>coin</NAME></VARIABLE>\n</NETWORK></BIF>";
/// assert_eq!(bifxml::load(text).unwrap_err().to_string(), r#"line 3, column 1: "coin" has no states; a variable has at least one"#);
/// ```
///
/// # Errors
/// [`LoadError`]: what is wrong and where.
pub fn load(bytes: &[u8]) -> Result<Diagram, LoadError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let read = bytes.get(..error.valid_up_to()).and_then(|valid| std::str::from_utf8(valid).ok());
        at_end_of(read.unwrap_or_default(), LoadFault::NotUtf8)
    })?;
    if let Some((before, _)) = text.split_once("<!ENTITY") {
        return Err(at_end_of(before, LoadFault::Entity));
    }
    // The tree of a file is a few times as large as the file, and no larger: entities, which could change that, are out.
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let TextPos { row, col } = error.pos();
        LoadError { problems: vec![Problem { line: row, column: col, fault: LoadFault::Xml(error.to_string()) }] }
    })?;
    Reader { document: &document, text, places: BTreeMap::new(), problems: Vec::new() }.read()
}

fn at_end_of(before: &str, fault: LoadFault) -> LoadError {
    let line = before.bytes().filter(|byte| *byte == b'\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    let number = |n| u32::try_from(n).unwrap_or(u32::MAX);
    LoadError { problems: vec![Problem { line: number(line), column: number(column), fault }] }
}

/// Where in the text a node begins and where its numbers are.
#[derive(Debug, Clone, Copy)]
struct Place {
    variable: usize,
    definition: Option<usize>,
}

struct Reader<'r, 'i> {
    document: &'r Document<'i>,
    text: &'i str,
    places: BTreeMap<NodeId, Place>,
    problems: Vec<(usize, LoadFault)>,
}

impl<'r, 'i: 'r> Reader<'r, 'i> {
    fn read(mut self) -> Result<Diagram, LoadError> {
        let root = self.document.root_element();
        if root.tag_name().name() != "BIF" {
            self.report(root, LoadFault::NotBif { found: root.tag_name().name().to_owned() });
            return Err(self.error());
        }
        let networks: Vec<_> = elements(root, "NETWORK").collect();
        let [network] = networks[..] else {
            self.report(networks.get(1).copied().unwrap_or(root), LoadFault::Networks { count: networks.len() });
            return Err(self.error());
        };
        let mut build = Diagram::builder(elements(network, "NAME").next().map(content).unwrap_or_default());
        self.memory(network, &mut build);
        let mut names = BTreeMap::new();
        for variable in elements(network, "VARIABLE") {
            self.variable(variable, &mut build, &mut names);
        }
        for definition in elements(network, "DEFINITION") {
            self.definition(definition, &mut build, &names);
        }
        if !self.problems.is_empty() {
            return Err(self.error());
        }
        build.build().map_err(|error| {
            for (node, fault) in error.faults() {
                let place = node.and_then(|node| self.places.get(&node)).map(|place| place.of(fault));
                self.problems.push((place.unwrap_or(network.range().start), fault.clone().into()));
            }
            self.error()
        })
    }

    fn memory(&mut self, network: Node<'r, 'i>, build: &mut DiagramBuilder) {
        for property in elements(network, "PROPERTY") {
            let text = content(property);
            let Some(("memory", value)) = text.split_once('=').map(|(key, value)| (key.trim(), value.trim())) else { continue };
            match value {
                "perfect" => _ = build.memory(Memory::Perfect),
                "limited" => _ = build.memory(Memory::Limited),
                other => self.report(property, LoadFault::UnknownMemory { found: other.to_owned() }),
            }
        }
    }

    fn variable(&mut self, variable: Node<'r, 'i>, build: &mut DiagramBuilder, names: &mut BTreeMap<String, (NodeId, Kind)>) {
        let Some(name) = elements(variable, "NAME").next().map(content) else {
            return self.report(variable, LoadFault::Missing { element: "VARIABLE", missing: "NAME" });
        };
        let outcomes: Vec<String> = elements(variable, "OUTCOME").map(content).collect();
        let (node, kind): (NodeId, _) = match variable.attribute("TYPE").unwrap_or("nature") {
            "nature" => (build.chance(&name, outcomes).id().into(), Kind::Chance),
            "decision" => (build.decision(&name, outcomes).id().into(), Kind::Decision),
            "utility" if outcomes.len() > 1 => {
                return self.report(variable, LoadFault::OutcomesOfUtility { name, count: outcomes.len() });
            }
            "utility" => (build.utility(&name).id().into(), Kind::Utility),
            other => return self.report(variable, LoadFault::UnknownType { found: other.to_owned() }),
        };
        self.places.insert(node, Place { variable: variable.range().start, definition: None });
        // A second node of this name is found out when the diagram is built.
        names.entry(name).or_insert((node, kind));
    }

    fn definition(&mut self, definition: Node<'r, 'i>, build: &mut DiagramBuilder, names: &BTreeMap<String, (NodeId, Kind)>) {
        let Some(target) = elements(definition, "FOR").next() else {
            return self.report(definition, LoadFault::Missing { element: "DEFINITION", missing: "FOR" });
        };
        let name = content(target);
        let Some(&(node, kind)) = names.get(&name) else {
            return self.report(target, LoadFault::UnknownVariable { name });
        };
        let Some(place) = self.places.get_mut(&node) else { return };
        if place.definition.replace(definition.range().start).is_some() {
            return self.report(definition, LoadFault::DefinedTwice { name });
        }
        for given in elements(definition, "GIVEN") {
            let name = content(given);
            match names.get(&name) {
                Some((parent, _)) => _ = build.arc(*parent, node),
                None => self.report(given, LoadFault::UnknownVariable { name }),
            }
        }
        let Some(table) = elements(definition, "TABLE").next() else { return };
        if kind == Kind::Decision {
            return self.report(table, LoadFault::TableOfDecision { name });
        }
        let Some(mut values) = self.numbers(table) else { return };
        if let (Kind::Chance, Some(variable)) = (kind, node.variable()) {
            smooth(&mut values, build.states(variable).len());
        }
        build.table(node, values);
    }

    /// The numbers of a table; `None` if one can't be read.
    fn numbers(&mut self, table: Node<'r, 'i>) -> Option<Vec<f64>> {
        let mut values = Vec::new();
        for piece in table.children().filter(Node::is_text) {
            let text = piece.text().unwrap_or_default();
            for word in text.split_ascii_whitespace() {
                if let Ok(value) = word.parse() {
                    values.push(value);
                    continue;
                }
                // Within the piece, unless something in it was written as an entity.
                let begin = piece.range().start;
                let within = self.text.get(begin..).and_then(|rest| rest.find(word)).filter(|at| *at < piece.range().len());
                self.problems.push((begin + within.unwrap_or(0), LoadFault::Number { text: word.to_owned() }));
                return None;
            }
        }
        Some(values)
    }

    fn report(&mut self, node: Node<'_, '_>, fault: LoadFault) {
        self.problems.push((node.range().start, fault));
    }

    fn error(&self) -> LoadError {
        let mut problems: Vec<_> = self.problems.iter().collect();
        problems.sort_by_key(|(at, _)| *at);
        let located = problems.into_iter().take(MOST_PROBLEMS).map(|(at, fault)| {
            let TextPos { row, col } = self.document.text_pos_at(*at);
            Problem { line: row, column: col, fault: fault.clone() }
        });
        LoadError { problems: located.collect() }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Chance,
    Decision,
    Utility,
}

impl Place {
    /// Names and states are wrong where the variable is, arcs and numbers where it is defined.
    fn of(self, fault: &Fault) -> usize {
        match fault {
            Fault::DuplicateName { .. } | Fault::DuplicateState { .. } | Fault::NoStates { .. } | Fault::BadName { .. } => {
                self.variable
            }
            _ => self.definition.unwrap_or(self.variable),
        }
    }
}

/// The children of this name.
fn elements<'r, 'i: 'r>(node: Node<'r, 'i>, name: &'static str) -> impl Iterator<Item = Node<'r, 'i>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// The text of an element, without the comments in it and the space around it.
fn content(node: Node<'_, '_>) -> String {
    let text: String = node.children().filter_map(|piece| if piece.is_text() { piece.text() } else { None }).collect();
    text.trim().to_owned()
}

/// Scales rows that were rounded. Those that sum to 1 as well as it is asked for stay as they are, and so do those that are wrong.
fn smooth(values: &mut [f64], states: usize) {
    for row in values.chunks_mut(states.max(1)) {
        let sum: f64 = row.iter().sum();
        let off = (sum - 1.0).abs();
        if off > SUM_TOLERANCE && off <= ROUNDING + SUM_TOLERANCE {
            row.iter_mut().for_each(|value| *value /= sum);
        }
    }
}
