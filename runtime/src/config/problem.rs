//! What is wrong, where, and what to do about it.
//!
//! A [`Problem`] stands alone: it holds the line it speaks of, so that it can be shown, sent or stored without the files. It
//! always has a hint. [`Problems`] is a list of at least one.

mod render;

use std::{fmt, ops::Range};

use serde::Serialize;

use super::source::{Sources, Span};

/// Longer offending texts are cut, characters.
const MAX_TEXT: usize = 80;
/// Longer lines are not shown, bytes.
const MAX_LINE: usize = 400;

/// A place in a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Location {
    /// The file, as a person would name it.
    pub file: String,
    /// Counts from 1.
    pub line: usize,
    /// In characters, from 1.
    pub column: usize,
    /// The offending text; the rest of the line if the problem is that something is missing. One line, cut if long.
    pub text: String,
    #[serde(skip)]
    source_line: String,
    #[serde(skip)]
    marked: Range<usize>,
    #[serde(skip)]
    position: usize,
}

impl Location {
    /// The place of the bytes `at` in a file; `position` orders places of several files.
    pub(super) fn new(file: String, bytes: &[u8], at: Range<usize>, position: usize) -> Self {
        let line_start = bytes[..at.start].iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let line_end = bytes[at.start..].iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |end| at.start + end);
        let line = 1 + bytes[..line_start].iter().filter(|byte| **byte == b'\n').count();
        // A byte order mark is not a character that a person counts.
        let line_start = if bytes[line_start..at.start].starts_with(b"\xef\xbb\xbf") { line_start + 3 } else { line_start };
        let before = String::from_utf8_lossy(&bytes[line_start..at.start]);
        let marked = String::from_utf8_lossy(&bytes[at.start..at.end.min(line_end)]);
        let after = String::from_utf8_lossy(&bytes[at.end.min(line_end)..line_end]);
        let after = after.trim_end_matches('\r');
        let text = if !marked.trim().is_empty() {
            marked.trim()
        } else if !after.trim().is_empty() {
            after.trim()
        } else {
            before.trim()
        };
        let column = before.chars().count() + 1;
        let marks = before.len()..before.len() + marked.trim_end().len();
        let source_line = if line_end - line_start <= MAX_LINE { format!("{before}{marked}{after}") } else { String::new() };
        Self { file, line, column, text: cut(text), source_line, marked: marks, position }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Something to know besides: often another place that takes part in the problem.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Note {
    /// What to know.
    pub message: String,
    /// Where to look, if anywhere.
    #[serde(flatten)]
    pub location: Option<Location>,
}

/// One thing that is wrong with a configuration.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Problem(Box<Told>);

/// All that a problem says. Boxed, since every result carries room for it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Told {
    #[serde(flatten)]
    location: Option<Location>,
    message: String,
    hint: String,
    #[serde(skip)]
    label: Option<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<Note>,
}

impl Problem {
    /// A problem at a place: what is wrong, and what to do about it.
    #[must_use]
    pub fn new(sources: &Sources, at: &Span, message: impl Into<String>, hint: impl Into<String>) -> Self {
        let mut problem = Self::nowhere(message, hint);
        problem.0.location = sources.locate(at);
        problem
    }

    /// A problem that stands in no file, such as a file that is not there.
    #[must_use]
    pub fn nowhere(message: impl Into<String>, hint: impl Into<String>) -> Self {
        let (message, hint) = (visible(&message.into()), visible(&hint.into()));
        Self(Box::new(Told { location: None, message, hint, label: None, notes: Vec::new() }))
    }

    /// Adds a few words to stand beside the mark.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.0.label = Some(visible(&label.into()));
        self
    }

    /// Adds another place to look at.
    #[must_use]
    pub fn note(mut self, sources: &Sources, at: &Span, message: impl Into<String>) -> Self {
        self.0.notes.push(Note { message: visible(&message.into()), location: sources.locate(at) });
        self
    }

    /// Where it is, unless it is in no file.
    #[must_use]
    pub fn location(&self) -> Option<&Location> {
        self.0.location.as_ref()
    }

    /// What is wrong, in one line.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// What to do about it, in one line.
    #[must_use]
    pub fn hint(&self) -> &str {
        &self.0.hint
    }

    /// Further places and remarks.
    #[must_use]
    pub fn notes(&self) -> &[Note] {
        &self.0.notes
    }

    /// Several lines, with the line of the file and a mark under it.
    #[must_use]
    pub fn render(&self, colour: bool) -> String {
        render::render(self, colour)
    }
}

/// One line: `file:line:column: error: message (hint: …)`.
impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(location) = &self.0.location {
            write!(f, "{location}: ")?;
        }
        write!(f, "error: {} (hint: {})", self.0.message, self.0.hint)
    }
}

impl std::error::Error for Problem {}

/// Everything that is wrong: at least one problem, in the order of the files, none twice.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Problems(Vec<Problem>);

impl Problems {
    /// `Ok` if there are none.
    ///
    /// # Errors
    /// The problems, sorted by place; of those that say the same about the same place only the first.
    pub fn check(mut found: Vec<Problem>) -> Result<(), Self> {
        let place = |problem: &Problem| problem.location().map_or(0, |location| location.position);
        let mut seen = std::collections::BTreeSet::new();
        found.retain(|problem| seen.insert((place(problem), problem.message().to_owned())));
        found.sort_by_key(place);
        if found.is_empty() { Ok(()) } else { Err(Self(found)) }
    }

    /// The problems; at least one.
    #[must_use]
    pub fn list(&self) -> &[Problem] {
        &self.0
    }

    /// The problems themselves, to go with others.
    #[must_use]
    pub fn into_list(self) -> Vec<Problem> {
        self.0
    }

    /// Everything for a person at a terminal: each problem with its line, and how many there are.
    #[must_use]
    pub fn render(&self, colour: bool) -> String {
        let each: Vec<String> = self.0.iter().map(|problem| problem.render(colour)).collect();
        let count = match self.0.len() {
            1 => "1 problem".to_owned(),
            many => format!("{many} problems"),
        };
        format!("{}\n\n{count}", each.join("\n\n"))
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Self {
        Self(vec![problem])
    }
}

/// One line for each problem.
impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().enumerate() {
            let end = if index == 0 { "" } else { "\n" };
            write!(f, "{end}{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// True for characters that a terminal does not show, or that move what it shows.
pub(super) fn hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{a0}' | '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202f}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// The text with whatever would break a line or a terminal spelled out.
fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if hidden(c) { shown.extend(c.escape_default()) } else { shown.push(c) }
    }
    shown
}

/// The text, cut if it is long.
pub(super) fn cut(text: &str) -> String {
    let text = visible(text);
    match text.char_indices().nth(MAX_TEXT) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn place(text: &str, at: Range<usize>) -> Location {
        let mut sources = Sources::embedded([("f".to_owned(), text.into())]);
        sources.read("f").unwrap();
        sources.locate(&(at.start + 1..at.end + 1)).unwrap()
    }

    #[test]
    fn columns_count_characters_from_one() {
        let text = "a = 1\r\nbé = \"ü\" # x\n\nlast";
        let found = place(text, text.find('ü').unwrap()..text.find('ü').unwrap() + 2);
        assert_eq!((found.line, found.column, found.text.as_str()), (2, 7, "ü"));
        let end = place(text, text.len()..text.len());
        assert_eq!((end.line, end.column, end.text.as_str()), (4, 5, "last"));
        let empty = place("", 0..0);
        assert_eq!((empty.line, empty.column, empty.text.as_str()), (1, 1, ""));
        let mark = place("\u{feff}a = 1", 3..4);
        assert_eq!((mark.line, mark.column, mark.text.as_str()), (1, 1, "a"));
        let beyond = place("a", 7..90);
        assert_eq!((beyond.line, beyond.column), (1, 2));
    }

    #[test]
    fn one_problem_is_one_line_whatever_it_quotes() {
        let problem = Problem::nowhere("key `a\nb\u{202e}`", "x\ty");
        assert_eq!(problem.to_string(), "error: key `a\\nb\\u{202e}` (hint: x\\ty)");
    }

    #[test]
    fn problems_are_sorted_and_none_is_told_twice() {
        let mut sources = Sources::embedded([("f".to_owned(), b"one\ntwo\n".to_vec())]);
        sources.read("f").unwrap();
        let at = |at: Span, message: &str| Problem::new(&sources, &at, message, "h");
        let problems = Problems::check(vec![at(5..8, "b"), at(1..4, "a"), at(5..8, "b"), at(5..8, "c")]).unwrap_err();
        let messages: Vec<&str> = problems.list().iter().map(Problem::message).collect();
        assert_eq!(messages, ["a", "b", "c"]);
        assert_eq!(Problems::check(Vec::new()), Ok(()));
    }
}
