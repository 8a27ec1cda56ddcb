//! Why a file is refused, and where.

use std::fmt;

use thiserror::Error;

use crate::diagram::Fault;

/// One thing that is wrong with a file.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LoadFault {
    /// Bytes that are no text.
    #[error("this is not UTF-8")]
    NotUtf8,
    /// Text that is no XML.
    #[error("{0}")]
    Xml(String),
    /// The declaration of an entity, by which a small file can become a large one, or read others.
    #[error("entities can't be declared here; write what they stand for")]
    Entity,
    /// XML of another kind.
    #[error("the file begins with <{found}>, but a diagram begins with <BIF>")]
    NotBif {
        /// What it begins with.
        found: String,
    },
    /// Not one network.
    #[error("there are {count} <NETWORK>s; there has to be one")]
    Networks {
        /// How many there are.
        count: usize,
    },
    /// An element without another one that it must have.
    #[error("this <{element}> has no <{missing}>")]
    Missing {
        /// The element.
        element: &'static str,
        /// What is not there.
        missing: &'static str,
    },
    /// A kind of node that is unknown.
    #[error("{found:?} is no type of a variable; there are nature, decision and utility")]
    UnknownType {
        /// What stands there.
        found: String,
    },
    /// A rule of remembering that is unknown.
    #[error("{found:?} is no kind of memory; there are perfect and limited")]
    UnknownMemory {
        /// What stands there.
        found: String,
    },
    /// A name that no variable has.
    #[error("no <VARIABLE> is named {name:?}")]
    UnknownVariable {
        /// The name.
        name: String,
    },
    /// A second definition.
    #[error("{name:?} is defined a second time; take one <DEFINITION> out")]
    DefinedTwice {
        /// Of which node.
        name: String,
    },
    /// A table where none belongs.
    #[error("{name:?} is a decision, so it has no <TABLE>")]
    TableOfDecision {
        /// Which decision.
        name: String,
    },
    /// A utility with states.
    #[error("{name:?} is a utility, but has {count} outcomes; it has one at most, which means nothing")]
    OutcomesOfUtility {
        /// Which utility.
        name: String,
        /// How many there are.
        count: usize,
    },
    /// A number that can't be read.
    #[error("{text:?} is no number")]
    Number {
        /// What stands there.
        text: String,
    },
    /// The file can be read, but the diagram is not sound.
    #[error(transparent)]
    Diagram(#[from] Fault),
}

/// A fault and its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The line, from 1.
    pub line: u32,
    /// The character within the line, from 1.
    pub column: u32,
    /// What is wrong there.
    pub fault: LoadFault,
}

/// Why a file was refused: at least one problem.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadError {
    /// What is wrong, at most the first twenty of it.
    pub problems: Vec<Problem>,
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, Problem { line, column, fault }) in self.problems.iter().enumerate() {
            write!(f, "{}line {line}, column {column}: {fault}", if i == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl std::error::Error for LoadError {}
