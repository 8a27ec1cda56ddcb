//! Single mistakes, made by a machine: does reading a configuration ever panic, hide a problem, or ignore a key?
//!
//! [`mutations`] makes the slips of a hurried person out of a good file: a character, a key, a value, a table header or a line
//! changed, lost or doubled. [`check_mutation`] then has it read. Either it is refused, with a place and a hint for each
//! problem, or it is valid; and then every key in it must be known. That is tested from outside: each key whose meaning the
//! change may have touched is renamed in turn, and reading must now refuse the file, or understand something else.

mod slips;

use std::panic::{AssertUnwindSafe, catch_unwind};

pub use slips::{Mutation, Slip, mutations};

use super::{
    document::{Data, Section, Table},
    problem::Problems,
    source::{Sources, Span},
};

/// Reads a configuration and tells all that was understood, in a form that two readings can be compared by.
pub type Load<'a> = &'a dyn Fn(&str) -> Result<String, Problems>;

/// What became of a mutation.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// It is a valid configuration in which every key means something.
    Valid,
    /// It was refused, as it should be: with places and hints.
    Refused(Problems),
    /// Bad: a problem lacks file, line, column, text or hint.
    Vague(Problems),
    /// Bad: this key (path, line) has no effect, yet nobody is told.
    Ignored(String, usize),
    /// Bad: reading panicked.
    Panicked(String),
}

impl Verdict {
    /// True for what may happen to a person's mistake.
    #[must_use]
    pub fn good(&self) -> bool {
        matches!(self, Verdict::Valid | Verdict::Refused(_))
    }
}

/// Reads a mutated configuration and judges what happened. `text` is the good one.
#[must_use]
pub fn check_mutation(text: &str, mutated: &str, load: Load<'_>) -> Verdict {
    let understood = match guarded(mutated, load) {
        Err(panic) => return Verdict::Panicked(panic),
        Ok(Err(problems)) => return if vague(&problems) { Verdict::Vague(problems) } else { Verdict::Refused(problems) },
        Ok(Ok(understood)) => understood,
    };
    let changed = changed_region(text, mutated);
    for (path, span) in keys(mutated) {
        if span.start < changed.start || span.start >= changed.end {
            continue;
        }
        match guarded(&renamed(mutated, &span), load) {
            Err(panic) => return Verdict::Panicked(panic),
            Ok(Ok(other)) if other == understood => {
                let line = 1 + mutated[..span.start].matches('\n').count();
                return Verdict::Ignored(path, line);
            }
            Ok(_) => {}
        }
    }
    Verdict::Valid
}

fn guarded(text: &str, load: Load<'_>) -> Result<Result<String, Problems>, String> {
    catch_unwind(AssertUnwindSafe(|| load(text))).map_err(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_else(|| "a panic".to_owned())
    })
}

/// True if a problem does not tell all it should.
fn vague(problems: &Problems) -> bool {
    problems.list().is_empty()
        || problems.list().iter().any(|problem| {
            let placed = problem.location().is_some_and(|at| {
                // Only an empty file has nothing to show.
                !at.file.is_empty() && at.line > 0 && at.column > 0
            });
            !placed || problem.hint().trim().is_empty() || problem.message().trim().is_empty()
        })
}

/// The bytes whose meaning a change may have touched: from the first changed line to the header behind the last one.
fn changed_region(text: &str, mutated: &str) -> Span {
    let same_start = text.bytes().zip(mutated.bytes()).take_while(|(a, b)| a == b).count();
    let rest = text.len().min(mutated.len()) - same_start;
    let same_end = text.bytes().rev().zip(mutated.bytes().rev()).take(rest).take_while(|(a, b)| a == b).count();
    let bytes = mutated.as_bytes();
    let start = bytes[..same_start].iter().rposition(|byte| *byte == b'\n').unwrap_or(0);
    let mut end = mutated.len() - same_end;
    while end < mutated.len() && !(bytes[end] == b'[' && bytes[..end].ends_with(b"\n")) {
        end += 1;
    }
    // The header line itself too: what stands above decides to whom `[robot.…]` belongs.
    end = bytes[end..].iter().position(|byte| *byte == b'\n').map_or(mutated.len(), |line| end + line);
    start..end
}

/// All keys of a valid text with their paths and places, each place once.
fn keys(text: &str) -> Vec<(String, Span)> {
    let mut sources = Sources::embedded([("text".to_owned(), text.into())]);
    let Ok(id) = sources.read("text") else { return Vec::new() };
    let Ok(section) = Section::parse(&sources, id) else { return Vec::new() };
    let mut found = Vec::new();
    gather(section.table(), "", sources.start(id), &mut found);
    found.sort_by_key(|(_, span): &(String, Span)| span.start);
    found.dedup_by_key(|(_, span)| span.start);
    found
}

fn gather(table: &Table, path: &str, start: usize, found: &mut Vec<(String, Span)>) {
    for (key, value) in table {
        let path = if path.is_empty() { key.get_ref().clone() } else { format!("{path}.{}", key.get_ref()) };
        let span = key.span();
        found.push((path.clone(), span.start - start..span.end - start));
        match value.get_ref() {
            Data::Table(table) => gather(table, &path, start, found),
            Data::List(values) => {
                for table in values.iter().filter_map(|value| value.get_ref().as_table()) {
                    gather(table, &path, start, found);
                }
            }
            _ => {}
        }
    }
}

/// The text with another name for the key at a place.
fn renamed(text: &str, key: &Span) -> String {
    let name = &text[key.clone()];
    let name = match name.chars().next_back() {
        Some(quote @ ('"' | '\'')) => format!("{}zq{quote}", &name[..name.len() - 1]),
        _ => format!("{name}zq"),
    };
    format!("{}{name}{}", &text[..key.start], &text[key.end..])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_changed_region_reaches_to_the_next_header() {
        let text = "[a]\nx = 1\ny = 2\n[b]\nz = 3\n[c]\n";
        let region = changed_region(text, &text.replace("x = 1", "w = 1"));
        assert_eq!(&text[region], "\nx = 1\ny = 2\n[b]");
        let all = changed_region(text, text);
        assert!(all.end <= text.len());
    }

    #[test]
    fn keys_are_found_in_place() {
        let text = "a.b = 1\n[c]\n\"d e\" = { f = 2 }\n[[g]]\nh = 1\n[[g]]\nh = 2\n";
        let names: Vec<&str> = keys(text).into_iter().map(|(_, span)| &text[span]).collect();
        assert_eq!(names, ["a", "b", "c", "\"d e\"", "f", "g", "h", "h"]);
        let quoted = text.find("\"d e\"").unwrap();
        assert_eq!(renamed(text, &(quoted..quoted + 5)), text.replace("d e", "d ezq"));
    }

    /// A careless reader: it knows one key, and never looks at others.
    fn careless(text: &str) -> Result<String, Problems> {
        let mut sources = Sources::embedded([("f".to_owned(), text.into())]);
        let id = sources.read("f").unwrap();
        let section = Section::parse(&sources, id)?;
        let speed = section.table().get("speed").map(|value| match value.get_ref() {
            Data::Whole(number) => *number,
            _ => panic!("not a number"),
        });
        Ok(format!("{speed:?}"))
    }

    #[test]
    fn bad_readers_are_found_out() {
        let text = "speed = 1\n";
        assert_eq!(check_mutation(text, "speed = 2\n", &careless), Verdict::Valid);
        assert_eq!(check_mutation(text, "sped = 1\n", &careless), Verdict::Ignored("sped".into(), 1));
        assert_eq!(check_mutation(text, "speed = 'x'\n", &careless), Verdict::Panicked("not a number".into()));
        assert!(matches!(check_mutation(text, "speed = \n", &careless), Verdict::Refused(_)));
        let vague = |_: &str| Err(super::super::Problem::nowhere("no", "do").into());
        assert!(matches!(check_mutation(text, "speed = 2\n", &vague), Verdict::Vague(_)));
    }
}
