//! The parser's messages in plain words.

use super::line_of;
use crate::config::{
    problem::{cut, hidden},
    source::Span,
};

/// What is wrong and what to do, from the parser's message and the text at the place.
pub(super) fn describe(message: &str, text: &str, span: &Span) -> (String, String) {
    let (what, expected) = message.split_once(", expected ").unwrap_or((message, "something else"));
    let here = &text[span.clone()];
    let line = line_of(text, span.start).trim();
    let value = line.split_once('=').map_or("", |(_, value)| value.trim());
    if let Some(hidden) = here.chars().find(|c| hidden(*c) && !"\t\r\n".contains(*c)) {
        let message = format!("there is a character here that can't be seen: {}", hidden.escape_unicode());
        return (message, hidden_hint(what));
    }
    let keys = about_keys(what, line, here);
    let found = keys
        .or_else(|| about_values(what, here, value))
        .or_else(|| about_brackets(what))
        .or_else(|| about_numbers(what, text, span));
    let (message, hint) = found.unwrap_or_else(|| (what, format!("the parser expected {expected}")).into_told());
    (message, hint)
}

/// What is wrong, and a hint.
type Told = (String, String);

trait IntoTold {
    fn into_told(self) -> Told;
}

impl<A: Into<String>, B: Into<String>> IntoTold for (A, B) {
    fn into_told(self) -> Told {
        (self.0.into(), self.1.into())
    }
}

fn hidden_hint(what: &str) -> String {
    if what == "invalid basic string" || what == "invalid literal string" {
        "write it as an escape in double quotes, such as `\\t` or `\\u0001`, or remove it".to_owned()
    } else {
        "remove it; it may have come with copied text".to_owned()
    }
}

/// Errors around a key, or in place of one.
fn about_keys(what: &str, line: &str, here: &str) -> Option<Told> {
    let told = match what {
        "key with no value" | "missing value for key" => (format!("`{}` has no value", cut(line)), no_value(line)).into_told(),
        "invalid unquoted key" if !line.contains('=') => (format!("`{}` has no value", cut(line)), no_value(line)).into_told(),
        "invalid unquoted key" | "unquoted keys cannot be empty" if line.starts_with('=') => {
            ("there is no key before `=`", "write `key = value`").into_told()
        }
        "invalid unquoted key" => (
            format!("`{}` can't be in a key", cut(here)),
            "keys are made of letters without accents, digits, `-` and `_`; `#` begins a comment",
        )
            .into_told(),
        "unquoted keys cannot be empty" => ("a name is missing here", "write a name between the dots or brackets").into_told(),
        "keys cannot be multi-line basic strings" | "keys cannot be multi-line literal strings" => {
            ("a key can't span lines", "use one quote on each side").into_told()
        }
        "invalid key-value pair" | "unexpected content" | "missing table open" => (
            "this is neither `key = value` nor a table header",
            "write `key = value`, `[table]` or `[[list]]`; `#` begins a comment",
        )
            .into_told(),
        "extra `=`" | "extra assignment between key-value pairs" => {
            ("there is an `=` too many", "write `key = value` with one `=`").into_told()
        }
        "missing assignment between key-value pairs" | "invalid inline table element" => {
            ("an entry of this inline table has no `=`", "write `{ key = value, key = value }`").into_told()
        }
        what if what.starts_with("cannot extend value of type") => (
            format!("`{}` already has a value, so nothing can be put under it", cut(here)),
            "write all its keys in one place: between `{ }`, or as a table with a header of its own",
        )
            .into_told(),
        "carriage return must be followed by newline" => {
            ("there is a carriage return within the line", "remove it, or end the line here").into_told()
        }
        "recursion limit" | "cannot recurse further; max recursion depth met" => {
            ("this is nested too deeply", "no configuration needs more than 80 levels").into_told()
        }
        _ => return None,
    };
    Some(told)
}

/// Errors in text, flags and bare words.
fn about_values(what: &str, here: &str, value: &str) -> Option<Told> {
    let told = match what {
        "string values must be quoted" | "missing value" | "invalid value" if value.is_empty() || value.starts_with('#') => {
            ("there is no value behind the `=`", "write one, or remove the line").into_told()
        }
        "string values must be quoted" | "invalid value" => unquoted(here),
        "invalid boolean" => {
            (format!("`{}` is not a value", cut(value)), "write `true` or `false`, or put text in quotes").into_told()
        }
        "unexpected key or value" => behind_value(value),
        "missing opening quote" => ("this text has no opening quote", "put a `\"` before it").into_told(),
        "invalid basic string" => ("this text is not closed", "put a `\"` at its end").into_told(),
        "invalid literal string" => ("this text is not closed", "put a `'` at its end").into_told(),
        "missing escaped value" | "too few unicode value digits" => (
            "a backslash in a text begins an escape, and this is none",
            "write `\\\\` for a backslash, or put the text in single quotes, where nothing is escaped",
        )
            .into_told(),
        what if what.starts_with("invalid") && ["date", "time", "month", "hour"].iter().any(|word| what.contains(word)) => {
            ("this is not a valid date or time", "no key takes one; put text in quotes").into_told()
        }
        _ => return None,
    };
    Some(told)
}

fn about_brackets(what: &str) -> Option<Told> {
    let told = match what {
        "unclosed table" => ("this table header is not closed", "put a `]` at its end").into_told(),
        "unclosed array table" => ("this table header is not closed", "put `]]` at its end").into_told(),
        "unclosed array" => ("this list is not closed", "put a `]` at its end").into_told(),
        "unclosed inline table" | "missing key for inline table element" => {
            ("this inline table is not closed", "put a `}` at its end").into_told()
        }
        "missing comma between array elements" | "unexpected `=` in array" => {
            ("a comma or a closing `]` is missing", "separate the values of a list by commas, and close it with `]`").into_told()
        }
        "missing comma between key-value pairs" => {
            ("a comma or a closing `}` is missing", "separate the entries by commas, and close the table with `}`").into_told()
        }
        "extra comma in array" | "extra comma in inline table" => ("there is a comma too many", "remove it").into_told(),
        "missing array opening" => ("this `]` closes nothing", "remove it, or put a `[` before the list").into_told(),
        "missing inline table opening" => ("this `}` closes nothing", "remove it, or put a `{` before the table").into_told(),
        _ => return None,
    };
    Some(told)
}

fn about_numbers(what: &str, text: &str, span: &Span) -> Option<Told> {
    let word = word_at(text, span);
    if what == "unexpected leading zero" {
        return Some(("a number can't begin with 0", "remove the leading zeros").into_told());
    }
    if what.contains("mantissa") || what.contains("fraction") {
        return Some(
            (
                format!("`{}` lacks digits at its point", cut(word)),
                "write digits on both sides of the point, such as `0.5` or `5.0`",
            )
                .into_told(),
        );
    }
    let numeric = ["float", "integer", "exponent", "numeric", "number", "digit", "sign", "radix"];
    numeric.iter().any(|part| what.contains(part)).then(|| {
        (format!("`{}` is not a number", cut(word)), "write a number such as `12` or `0.35`, or put text in quotes").into_told()
    })
}

/// A value that is neither number nor quoted.
fn unquoted(here: &str) -> Told {
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

/// What to write instead of a line without a value.
fn no_value(line: &str) -> String {
    if line.starts_with("//") || line.starts_with("--") || line.starts_with(';') {
        return "a comment begins with `#`".to_owned();
    }
    if line.find('#').is_some_and(|comment| line.find('=').is_some_and(|equals| comment < equals)) {
        return "`#` begins a comment, so the rest of the line does not count: remove it".to_owned();
    }
    match line.split_once(':').map(|(key, value)| (key.trim(), value.trim())) {
        Some((key, value)) if !key.is_empty() && !value.is_empty() => format!("write `{} = {}`", cut(key), cut(value)),
        _ => "write `key = value`, or `[table]` for a table".to_owned(),
    }
}

/// Something stands behind a complete value.
fn behind_value(value: &str) -> Told {
    let digits = |text: &str| !text.trim().is_empty() && text.trim().chars().all(|c| c.is_ascii_digit());
    let whole_and_rest = value.split_once(',');
    let decimal_comma = whole_and_rest.is_some_and(|(whole, rest)| digits(whole.trim_start_matches(['-', '+'])) && digits(rest));
    let hint = if decimal_comma {
        format!("write the decimal point as a point: `{}`", cut(&value.replace(',', ".")))
    } else {
        "put one `key = value` on a line, and `#` before a comment".to_owned()
    };
    ("there is something behind the value", hint).into_told()
}

/// What stands around a place, up to blanks, commas and brackets.
fn word_at<'a>(text: &'a str, span: &Span) -> &'a str {
    let ends = |c: char| c.is_whitespace() || "=,[]{}".contains(c);
    let start = text[..span.start].rfind(ends).map_or(0, |at| at + text[at..].chars().next().map_or(1, char::len_utf8));
    let end = text[span.start..].find(ends).map_or(text.len(), |at| span.start + at);
    &text[start..end.max(start)]
}
