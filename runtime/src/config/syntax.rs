//! Syntax errors, told to people who do not know the grammar of TOML.

mod words;

use toml::{Spanned, de::DeTable, de::DeValue, de::Error};

use super::{
    problem::Problem,
    source::{Sources, Span},
};

/// Errors after the first few are mostly echoes of them.
const MOST: usize = 5;

/// One problem for each line that has one.
pub(super) fn explain(
    sources: &Sources,
    start: usize,
    text: &str,
    document: &Spanned<DeTable<'_>>,
    errors: &[Error],
) -> Vec<Problem> {
    let mut lines: Vec<usize> = Vec::new();
    let mut problems = Vec::new();
    let mut errors: Vec<&Error> = errors.iter().collect();
    errors.sort_by_key(|error| error.span().map_or(0, |span| span.start));
    for error in errors {
        let span = place(text, error);
        let line = text.as_bytes()[..span.start].iter().filter(|byte| **byte == b'\n').count();
        if lines.contains(&line) || lines.len() >= MOST {
            continue;
        }
        lines.push(line);
        let at = start + span.start..start + span.end;
        let problem = match error.message() {
            "duplicate key" => duplicate(sources, start, text, &span, document.get_ref()),
            message => {
                let (what, hint) = words::describe(message, text, &span);
                let problem = Problem::new(sources, &at, what, hint);
                match opening(message, text, span.start) {
                    Some(open) => problem.note(sources, &(start + open..start + open + 1), "it begins here"),
                    None => problem,
                }
            }
        };
        problems.push(problem);
        // A bracket that is never closed swallows the lines after it.
        if ["unclosed", "missing comma", "missing key for inline"].iter().any(|start| error.message().starts_with(start)) {
            break;
        }
    }
    problems
}

/// The span of an error within the text.
fn place(text: &str, error: &Error) -> Span {
    let Some(span) = error.span() else {
        // Only a key of too many parts comes without a place.
        let deepest = text.lines().max_by_key(|line| line.matches('.').count()).unwrap_or("");
        let start = text.find(deepest).unwrap_or(0);
        return start..start + deepest.len();
    };
    let start = text.floor_char_boundary(span.start.min(text.len()));
    start..text.ceil_char_boundary(span.end.clamp(start, text.len()))
}

/// Where a list or an inline table that goes wrong on a later line begins.
fn opening(message: &str, text: &str, before: usize) -> Option<usize> {
    let bracket = match message {
        message if message.starts_with("cannot extend") => return None,
        message if message.contains("array") => '[',
        message if message.contains("inline") || message.contains("key-value pairs") => '{',
        _ => return None,
    };
    let is_value = |at: &usize| text[..*at].trim_end().ends_with('=');
    let open = text[..before].rmatch_indices(bracket).map(|(at, _)| at).find(is_value)?;
    text[open..before].contains('\n').then_some(open)
}

fn duplicate(sources: &Sources, start: usize, text: &str, span: &Span, document: &DeTable<'_>) -> Problem {
    let name = &text[span.clone()];
    let at = start + span.start..start + span.end;
    let line = line_of(text, span.start);
    let header = line.trim_start().starts_with('[');
    let message = if header {
        format!("the table `{}` is defined twice", line.trim().trim_matches(['[', ']']).trim())
    } else {
        format!("the key `{name}` is given twice")
    };
    let hint = if line.trim_start().starts_with("[[") {
        "write the other one as `[[…]]` too, or rename one of them".to_owned()
    } else if header {
        "join the two tables under one header, or rename one of them".to_owned()
    } else {
        "remove one of the two".to_owned()
    };
    let problem = Problem::new(sources, &at, message, hint);
    let first = match header {
        true => same_line_before(text, line, span.start),
        false => None,
    };
    match first.or_else(|| first_of(document, name.trim_matches(['"', '\'']), span.start)) {
        Some(first) => problem.note(sources, &(start + first.start..start + first.end), "it is first given here"),
        None => problem,
    }
}

/// The last line before a position that reads the same.
fn same_line_before(text: &str, line: &str, before: usize) -> Option<Span> {
    let mut start = 0;
    let mut found = None;
    for other in text[..before].split_inclusive('\n') {
        // The line of the position itself is cut, and its header not complete.
        if other.ends_with('\n') && other.trim() == line.trim() {
            let indent = other.len() - other.trim_start().len();
            found = Some(start + indent..start + other.trim_end().len());
        }
        start += other.len();
    }
    found
}

/// The last key of this name before a position.
fn first_of(table: &DeTable<'_>, name: &str, before: usize) -> Option<Span> {
    let mut found: Option<Span> = None;
    for (key, value) in table {
        let here = (key.get_ref() == name && key.span().start < before).then(|| key.span());
        let below = match value.get_ref() {
            DeValue::Table(inner) => first_of(inner, name, before),
            DeValue::Array(values) => {
                let tables = values.iter().filter_map(|value| value.get_ref().as_table());
                tables.filter_map(|inner| first_of(inner, name, before)).max_by_key(|span| span.start)
            }
            _ => None,
        };
        found = [found, here, below].into_iter().flatten().max_by_key(|span| span.start);
    }
    found
}

/// The whole line around a position.
fn line_of(text: &str, at: usize) -> &str {
    let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
    let end = text[at..].find('\n').map_or(text.len(), |end| at + end);
    &text[start..end]
}
