//! What is wrong with a world, and where.

use std::{fmt, path::PathBuf};

use thiserror::Error;

/// One table of a world file, as messages name it: `[[room]] 3 "lab"`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Name of the table: `room`, `wall`, …
    pub table: &'static str,
    /// Its place among the tables of this name, from 0; `None` for a table that there is only one of.
    pub index: Option<usize>,
    /// What the file calls it.
    pub name: Option<String>,
}

impl Element {
    pub(super) fn nth(table: &'static str, index: usize, name: Option<&str>) -> Self {
        Self { table, index: Some(index), name: name.map(str::to_owned) }
    }

    pub(super) fn only(table: &'static str) -> Self {
        Self { table, index: None, name: None }
    }

    /// The error that something is wrong with this element.
    pub(super) fn refuse(&self, problem: impl Into<String>) -> WorldError {
        WorldError::Element { element: self.clone(), problem: problem.into() }
    }
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.index {
            Some(index) => write!(f, "[[{}]] {}", self.table, index + 1)?,
            None => write!(f, "[{}]", self.table)?,
        }
        self.name.as_ref().map_or(Ok(()), |name| write!(f, " {name:?}"))
    }
}

/// Why a world can't be built.
#[derive(Debug, Error)]
pub enum WorldError {
    /// The text is no world file.
    #[error("{0}")]
    Syntax(#[from] toml::de::Error),
    /// The world file itself can't be read.
    #[error("can't read {}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// An element contradicts itself or the rest of the world.
    #[error("{element}: {problem}")]
    Element {
        /// Which one.
        element: Element,
        /// What is wrong with it.
        problem: String,
    },
    /// A file that the world refers to can't be read.
    #[error("{element}: can't read {}: {reason}", path.display())]
    File {
        /// Which element refers to it.
        element: Element,
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// A map or picture can't be understood.
    #[error("{element}: {}: {reason}", path.display())]
    Map {
        /// Which element refers to it.
        element: Element,
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: Box<super::map::MapError>,
    },
}

impl WorldError {
    /// The element that it is about, unless it is about the file as a whole.
    #[must_use]
    pub fn element(&self) -> Option<&Element> {
        match self {
            Self::Element { element, .. } | Self::File { element, .. } | Self::Map { element, .. } => Some(element),
            Self::Syntax(_) | Self::Unreadable { .. } => None,
        }
    }
}
