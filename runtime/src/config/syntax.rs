//! Syntax errors, told to people who do not know the grammar of TOML.

use toml::{Spanned, de::DeTable, de::DeValue, de::Error};

use super::{
    problem::{Problem, cut},
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
        let span = place(text, error.span());
        let line = text.as_bytes()[..span.start].iter().filter(|byte| **byte == b'\n').count();
        if lines.contains(&line) || lines.len() >= MOST {
            continue;
        }
        lines.push(line);
        let at = start + span.start..start + span.end;
        let problem = match error.message() {
            "duplicate key" => duplicate(sources, start, text, &span, document.get_ref()),
            message => {
                let (what, hint) = describe(message, text, &span);
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

/// The span of an error within the text; an error at the end of a line stays in that line.
fn place(text: &str, span: Option<Span>) -> Span {
    let span = span.unwrap_or(0..0);
    let start = text.floor_char_boundary(span.start.min(text.len()));
    let end = text.ceil_char_boundary(span.end.clamp(start, text.len()));
    start..end
}

/// Where a list or an inline table that goes wrong on a later line begins.
fn opening(message: &str, text: &str, before: usize) -> Option<usize> {
    let bracket = match message {
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

/// What is wrong and what to do, from the parser's message and the text at the place.
fn describe(message: &str, text: &str, span: &Span) -> (String, String) {
    let what = message.split(", expected").next().unwrap_or(message);
    let here = &text[span.clone()];
    let line = line_of(text, span.start).trim();
    let value = line.split_once('=').map_or("", |(_, value)| value.trim());
    let key = line.split('=').next().unwrap_or("").trim();
    match what {
        "string values must be quoted" if value.is_empty() => {
            (format!("`{}` has no value", cut(key)), format!("write a value after the `=`, such as `{} = 1`", cut(key)))
        }
        "string values must be quoted" => unquoted(here),
        "key with no value" => (format!("`{}` has no value", cut(line)), no_value(line)),
        "invalid unquoted key" if !line.contains('=') => (format!("`{}` has no value", cut(line)), no_value(line)),
        "invalid unquoted key" | "unquoted keys cannot be empty" if line.starts_with('=') => {
            ("there is no key before `=`".to_owned(), "write `key = value`".to_owned())
        }
        "invalid unquoted key" => (
            format!("`{}` can't be in a key", cut(here)),
            "keys are made of letters without accents, digits, `-` and `_`; `#` begins a comment".to_owned(),
        ),
        "invalid boolean" => {
            (format!("`{}` is not a value", cut(value)), "write `true` or `false`, or put text in quotes".to_owned())
        }
        "extra `=`" => ("there are two `=`".to_owned(), "write `key = value` with one `=`".to_owned()),
        "unexpected key or value" => behind_value(value),
        "invalid basic string" | "invalid literal string" if here.is_empty() => {
            ("this text is not closed".to_owned(), format!("put a {} at its end", quote_of(what)))
        }
        "unclosed table" => ("this table header is not closed".to_owned(), "put a `]` at its end".to_owned()),
        "unclosed array table" => ("this table header is not closed".to_owned(), "put `]]` at its end".to_owned()),
        "unclosed array" => ("this list is not closed".to_owned(), "put a `]` at its end".to_owned()),
        "unclosed inline table" | "missing key for inline table element" => {
            ("this inline table is not closed".to_owned(), "put a `}` at its end".to_owned())
        }
        "missing comma between array elements" => (
            "a comma or a closing `]` is missing".to_owned(),
            "separate the values of a list by commas, and close it with `]`".to_owned(),
        ),
        "missing comma between key-value pairs" => (
            "a comma or a closing `}` is missing".to_owned(),
            "separate the entries by commas, and close the table with `}`".to_owned(),
        ),
        "missing escaped value" => {
            let hint = "write `\\\\` for a backslash, or put the text in single quotes, where nothing is escaped";
            ("a backslash in a text begins an escape, and this is none".to_owned(), hint.to_owned())
        }
        "invalid date" => ("this is not a valid date".to_owned(), "no key takes a date; put text in quotes".to_owned()),
        "recursion limit" | "cannot recurse further; max recursion depth met" => {
            ("this is nested too deeply".to_owned(), "no configuration needs more than 80 levels".to_owned())
        }
        "unexpected leading zero" => ("a number can't begin with 0".to_owned(), "remove the leading zeros".to_owned()),
        what if what.contains("mantissa") || what.contains("fraction") => (
            "this number lacks digits at its point".to_owned(),
            "write digits on both sides of the point, such as `0.5` or `5.0`".to_owned(),
        ),
        what if ["float", "integer", "exponent", "numeric", "underscore", "digit"].iter().any(|word| what.contains(word)) => (
            format!("`{}` is not a number", cut(value)),
            "write a number such as `12` or `0.35`, or put text in quotes".to_owned(),
        ),
        what => (
            what.to_owned(),
            format!("the parser expected {}", message.split_once("expected ").map_or("something else", |(_, rest)| rest)),
        ),
    }
}

/// A value that is neither number nor quoted.
fn unquoted(here: &str) -> (String, String) {
    let message = format!("`{}` is not a value", cut(here));
    let number = here.trim_start_matches(['+', '-']).starts_with(|c: char| c.is_ascii_digit());
    let hint = match here.to_lowercase().as_str() {
        "true" | "yes" | "on" => "write `true`".to_owned(),
        "false" | "no" | "off" => "write `false`".to_owned(),
        "none" | "null" | "nil" => "remove the line to leave the key unset".to_owned(),
        _ if here.contains(['\u{201c}', '\u{201d}', '\u{201e}']) => "use straight quotes: `\"`".to_owned(),
        _ if number => bare_number(here),
        _ => format!("put text in quotes: `\"{}\"`", cut(here).replace('"', "")),
    };
    (message, hint)
}

/// What to write instead of a number with its unit.
fn bare_number(here: &str) -> String {
    let number: String = here.chars().take_while(|c| c.is_ascii_digit() || "+-._".contains(*c)).collect();
    format!(
        "write the number without its unit, `{}`; which unit is meant, the key's description says",
        number.trim_end_matches('.')
    )
}

fn no_value(line: &str) -> String {
    if line.starts_with("//") || line.starts_with("--") || line.starts_with(';') {
        return "a comment begins with `#`".to_owned();
    }
    match line.split_once(':') {
        Some((key, value)) => format!("write `{} = {}`", cut(key.trim()), cut(value.trim())),
        None => "write `key = value`, or `[table]` for a table".to_owned(),
    }
}

/// Something stands behind a complete value.
fn behind_value(value: &str) -> (String, String) {
    let decimal_comma = value.split_once(',').is_some_and(|(whole, rest)| {
        let digits = |text: &str| !text.trim().is_empty() && text.trim().chars().all(|c| c.is_ascii_digit());
        digits(whole.trim_start_matches(['-', '+'])) && digits(rest)
    });
    let hint = if decimal_comma {
        format!("write the decimal point as a point: `{}`", cut(&value.replace(',', ".")))
    } else {
        "put one `key = value` on a line, and `#` before a comment".to_owned()
    };
    ("there is something behind the value".to_owned(), hint)
}

fn quote_of(what: &str) -> &'static str {
    if what.contains("literal") { "`'`" } else { "`\"`" }
}

/// The whole line around a position.
fn line_of(text: &str, at: usize) -> &str {
    let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
    let end = text[at..].find('\n').map_or(text.len(), |end| at + end);
    &text[start..end]
}
