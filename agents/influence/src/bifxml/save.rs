//! Writing.

use std::fmt::Write;

use crate::diagram::{Diagram, Memory, NodeId};

/// A diagram as the text of a file.
///
/// ```
/// use orienteer_influence::{bifxml, samples};
///
/// let diagram = samples::oil_wildcatter()?;
/// assert_eq!(bifxml::load(bifxml::save(&diagram).as_bytes())?, diagram);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn save(diagram: &Diagram) -> String {
    let mut text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<BIF VERSION=\"0.3\">\n<NETWORK>\n".to_owned();
    if !diagram.name().is_empty() {
        element(&mut text, "", "NAME", diagram.name());
    }
    if diagram.memory() == Memory::Limited {
        element(&mut text, "", "PROPERTY", "memory = limited");
    }
    for node in diagram.variables() {
        variable(&mut text, diagram, node.into());
    }
    for node in diagram.utilities() {
        variable(&mut text, diagram, node.into());
    }
    for node in diagram.variables() {
        definition(&mut text, diagram, node.into());
    }
    for node in diagram.utilities() {
        definition(&mut text, diagram, node.into());
    }
    text.push_str("</NETWORK>\n</BIF>\n");
    text
}

fn variable(text: &mut String, diagram: &Diagram, node: NodeId) {
    let kind = match node {
        NodeId::Utility(_) => "utility",
        NodeId::Variable(variable) if diagram.is_decision(variable) => "decision",
        NodeId::Variable(_) => "nature",
    };
    text.push_str("<VARIABLE TYPE=\"");
    text.push_str(kind);
    text.push_str("\">\n");
    element(text, "\t", "NAME", diagram.name_of(node));
    match node.variable() {
        Some(variable) => diagram.states(variable).iter().for_each(|state| element(text, "\t", "OUTCOME", state)),
        // pyAgrum wants a utility to have one.
        None => element(text, "\t", "OUTCOME", "0"),
    }
    text.push_str("</VARIABLE>\n");
}

fn definition(text: &mut String, diagram: &Diagram, node: NodeId) {
    text.push_str("<DEFINITION>\n");
    element(text, "\t", "FOR", diagram.name_of(node));
    diagram.parents(node).iter().for_each(|parent| element(text, "\t", "GIVEN", diagram.name_of(*parent)));
    let table = diagram.table(node);
    if !table.is_empty() {
        text.push_str("\t<TABLE>");
        for (i, value) in table.iter().enumerate() {
            // The shortest text that is read as exactly this number. Writing into a string can't fail.
            let _ = write!(text, "{}{value:?}", if i == 0 { "" } else { " " });
        }
        text.push_str("</TABLE>\n");
    }
    text.push_str("</DEFINITION>\n");
}

fn element(text: &mut String, indent: &str, name: &str, content: &str) {
    let content = content.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let _ = writeln!(text, "{indent}<{name}>{content}</{name}>");
}
