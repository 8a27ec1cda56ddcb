//! How schema and values are told to people.

use serde_json::Value as Json;

use super::view::View;
use crate::config::{document::Data, problem::cut};

/// What sort of thing a TOML value is.
pub(super) fn sort_of(value: &Data) -> &'static str {
    match value {
        Data::Text(_) => "text",
        Data::Whole(_) => "a whole number",
        Data::Number(_) => "a decimal number",
        Data::Flag(_) => "true or false",
        Data::Date(_) => "a date",
        Data::List(_) => "a list",
        Data::Table(_) => "a table",
    }
}

/// What sorts of thing a schema allows.
pub(super) fn wanted(types: &[&str]) -> String {
    let words: Vec<&str> = types
        .iter()
        .map(|name| match *name {
            "string" => "text in quotes",
            "integer" => "a whole number",
            "number" => "a number",
            "boolean" => "`true` or `false`",
            "array" => "a list",
            "object" => "a table",
            other => other,
        })
        .collect();
    words.join(" or ")
}

/// The value as a person would write it, cut if long.
pub(super) fn shown(value: &Data) -> String {
    let text = match value {
        Data::Text(text) => format!("{text:?}"),
        Data::Whole(number) => number.to_string(),
        Data::Number(number) => number_shown(*number),
        Data::Flag(yes) => yes.to_string(),
        Data::Date(date) => date.to_string(),
        Data::List(values) => {
            let each: Vec<String> = values.iter().take(8).map(|value| shown(value.get_ref())).collect();
            format!("[{}]", each.join(", "))
        }
        Data::Table(_) => "{…}".to_owned(),
    };
    cut(&text)
}

/// A JSON value as TOML would write it; `None` if it is not worth showing.
pub(super) fn example(value: &Json) -> Option<String> {
    match value {
        Json::Null => None,
        Json::Number(number) => Some(number_shown(number.as_f64()?)),
        Json::Array(values) => {
            let each: Option<Vec<String>> = values.iter().map(example).collect();
            each.map(|each| cut(&format!("[{}]", each.join(", "))))
        }
        Json::Object(_) => None,
        other => Some(other.to_string()),
    }
}

/// A number without a needless `.0`, and without rows of zeros.
pub(super) fn number_shown(number: f64) -> String {
    let size = number.abs();
    if size >= 1e15 || (size < 1e-5 && size > 0.0) { format!("{number:e}") } else { number.to_string() }
}

/// The first sentence of a schema's description, to follow a colon; links become their text.
pub(super) fn about(view: &View<'_>) -> Option<String> {
    let text = view.keyword("description")?.as_str()?;
    let paragraph = text.split("\n\n").next()?.split_whitespace().collect::<Vec<_>>().join(" ");
    let sentence = paragraph.split_once(". ").map_or(paragraph.as_str(), |(first, _)| first);
    let plain = sentence.trim_end_matches('.').replace(['[', ']'], "");
    let mut rest = plain.chars();
    let first = rest.next()?;
    // "SI units" and "X" stay as they are; an ordinary word loses its capital behind the colon.
    let ordinary = rest.as_str().starts_with(|c: char| c.is_lowercase() || c == ' ');
    Some(if ordinary { first.to_lowercase().chain(rest).collect() } else { plain })
}

/// A hint, followed by what the key means and what it is by default.
pub(super) fn hint(what: String, view: &View<'_>) -> String {
    let about = about(view).map_or_else(String::new, |about| format!(": {about}"));
    match view.keyword("default").and_then(example) {
        Some(default) => format!("{what}{about}; the default is {default}"),
        None => format!("{what}{about}"),
    }
}

/// `1 value`, `3 values`.
pub(super) fn counted(count: u64, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

/// How many there should be.
pub(super) fn count(least: u64, most: u64) -> String {
    match (least, most) {
        (least, most) if least == most => format!("exactly {least}"),
        (0, most) => format!("at most {most}"),
        (least, u64::MAX) => format!("at least {least}"),
        (least, most) => format!("{least} to {most}"),
    }
}
