//! A TOML document in which every key and value knows where it stands.

mod deserialize;
mod plain;

use serde::de::DeserializeOwned;
use toml::{
    Spanned,
    de::{DeTable, DeValue},
    map::Map,
};

use super::{
    problem::{Problem, Problems},
    source::{SourceId, Sources, Span},
    syntax,
};

/// What a key is set to.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// A string.
    Text(String),
    /// An integer, in whatever base it was written.
    Whole(i128),
    /// A float; infinite if it was written so.
    Number(f64),
    /// `true` or `false`.
    Flag(bool),
    /// A date or a time, as written. No key takes one.
    Date(String),
    /// An array.
    List(Vec<Value>),
    /// A table.
    Table(Table),
}

impl Data {
    /// The text, if it is one.
    #[must_use]
    pub fn as_text(&self) -> Option<&str> {
        match self {
            Data::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The number, if it is one.
    #[must_use]
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Data::Whole(number) => Some(*number as f64),
            Data::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// The values of an array, if it is one.
    #[must_use]
    pub fn as_list(&self) -> Option<&[Value]> {
        match self {
            Data::List(values) => Some(values),
            _ => None,
        }
    }

    /// The table, if it is one.
    #[must_use]
    pub fn as_table(&self) -> Option<&Table> {
        match self {
            Data::Table(table) => Some(table),
            _ => None,
        }
    }
}

/// A value with its place.
pub type Value = Spanned<Data>;
/// A key with its place.
pub type Key = Spanned<String>;
/// Keys and values in the order of the file.
pub type Table = Map<Key, Value>;

/// A table of a configuration. Its keys and values may come from several files.
#[derive(Debug, Clone)]
pub struct Section {
    table: Table,
    span: Span,
}

impl Section {
    /// Parses a whole file.
    ///
    /// # Errors
    /// Syntax errors and duplicate keys, each at its place; a file that is not text.
    pub fn parse(sources: &Sources, id: SourceId) -> Result<Self, Problems> {
        let text = sources.text(id)?;
        let (document, errors) = DeTable::parse_recoverable(text);
        let start = sources.start(id);
        Problems::check(syntax::explain(sources, start, text, &document, &errors))?;
        Ok(Self { table: owned_table(document.into_inner(), start), span: start..start })
    }

    /// A table that stands at a place.
    #[must_use]
    pub fn new(table: Table, span: Span) -> Self {
        Self { table, span }
    }

    /// The table under a key, if there is one.
    #[must_use]
    pub fn section(&self, key: &str) -> Option<Self> {
        let value = self.table.get(key)?;
        Some(Self::new(value.get_ref().as_table()?.clone(), value.span()))
    }

    /// The tables under a key that has several, as `[[key]]` makes them.
    pub fn entries(&self, key: &str) -> impl Iterator<Item = Self> {
        let entries = self.table.get(key).and_then(|value| value.get_ref().as_list()).unwrap_or_default();
        entries.iter().filter_map(|entry| Some(Self::new(entry.get_ref().as_table()?.clone(), entry.span())))
    }

    /// All keys and values.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The keys and values, to be changed.
    pub fn table_mut(&mut self) -> &mut Table {
        &mut self.table
    }

    /// Where the table is: its header, or all of it if it stands in one line.
    #[must_use]
    pub fn span(&self) -> Span {
        self.span.clone()
    }

    /// Where the value of a key is; the table itself if there is no such key.
    #[must_use]
    pub fn span_of(&self, key: &str) -> Span {
        self.table.get(key).map_or_else(|| self.span(), Spanned::span)
    }

    /// Where a key is; the table itself if there is no such key.
    #[must_use]
    pub fn span_of_key(&self, key: &str) -> Span {
        self.table.get_key_value(key).map_or_else(|| self.span(), |(key, _)| key.span())
    }

    /// The text under a key, if it is text.
    #[must_use]
    pub fn text(&self, key: &str) -> Option<&str> {
        self.table.get(key).and_then(|value| value.get_ref().as_text())
    }

    /// Turns the table into a type without comparing it with a schema first.
    ///
    /// # Errors
    /// The first thing that the type refuses, at its place.
    pub fn deserialize<T: DeserializeOwned>(&self, sources: &Sources) -> Result<T, Problems> {
        deserialize::table(&self.table).map_err(|error| {
            let at = error.span.unwrap_or_else(|| self.span());
            let hint = "change this value, or remove its line to use the default";
            Problem::new(sources, &at, error.message, hint).into()
        })
    }
}

/// The table without borrows, all places moved to the address of its file. The parser limits the depth.
fn owned_table(table: DeTable<'_>, by: usize) -> Table {
    let entry = |(key, value): (Spanned<std::borrow::Cow<'_, str>>, Spanned<DeValue<'_>>)| {
        (Spanned::new(shifted(&key.span(), by), key.into_inner().into_owned()), owned(value, by))
    };
    table.into_iter().map(entry).collect()
}

fn owned(value: Spanned<DeValue<'_>>, by: usize) -> Value {
    let span = shifted(&value.span(), by);
    let data = match value.into_inner() {
        DeValue::String(text) => Data::Text(text.into_owned()),
        DeValue::Integer(number) => match i128::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => Data::Whole(number),
            // Longer than any integer type: only good as an approximation.
            Err(_) => Data::Number(number.as_str().parse().unwrap_or(f64::NAN)),
        },
        DeValue::Float(number) => Data::Number(match number.as_str().parse::<f64>() {
            // Written with digits, but beyond all numbers.
            Ok(value) if value.is_infinite() && !number.as_str().contains("inf") => f64::NAN,
            Ok(value) => value,
            Err(_) => f64::NAN,
        }),
        DeValue::Boolean(yes) => Data::Flag(yes),
        DeValue::Datetime(date) => Data::Date(date.to_string()),
        DeValue::Array(values) => Data::List(values.into_iter().map(|value| owned(value, by)).collect()),
        DeValue::Table(table) => Data::Table(owned_table(table, by)),
    };
    Spanned::new(span, data)
}

fn shifted(span: &Span, by: usize) -> Span {
    span.start + by..span.end + by
}
