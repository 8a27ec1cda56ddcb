//! Values of which there are several sorts: enums in all their shapes.

use serde_json::Value as Json;

use super::{At, Validator, scalar::constants, view::View, words};
use crate::config::{
    document::{Data, Table},
    suggest,
};

impl<'a> Validator<'a> {
    /// If the schema offers several alternatives, picks the one that is meant, checks the value against it, and says true.
    pub(super) fn choice(&mut self, at: &At, value: &Data, view: &View<'a>) -> bool {
        let alternatives = view.alternatives();
        if alternatives.is_empty() {
            return false;
        }
        let names: Vec<&str> = alternatives.iter().flat_map(constants).collect();
        let tables: Vec<View<'a>> = alternatives.iter().filter(|one| one.keyword("properties").is_some()).cloned().collect();
        let texts = alternatives.iter().filter(|one| !constants(one).is_empty()).count();
        match value {
            Data::Text(text) if names.contains(&text.as_str()) => {}
            Data::Text(text) if !names.is_empty() => {
                let outer: Vec<&str> = names.into_iter().chain(tables.iter().filter_map(|one| outer_tag(one))).collect();
                self.unknown_name(at, text, &outer);
            }
            Data::Table(table) if tables.len() + texts == alternatives.len() => self.tagged(at, table, view, &tables),
            // Only names are allowed, and this is no text.
            _ if texts == alternatives.len() => {
                let message = format!("{} must be text in quotes, not {}", at.quoted(), words::sort_of(value));
                let hint = words::hint(format!("choose one of {}", suggest::list(names.into_iter())), view);
                self.report(at, message, hint, Some(format!("this is {}", words::sort_of(value))));
            }
            _ => self.any(at, value, &alternatives),
        }
        true
    }

    fn tagged(&mut self, at: &At, table: &Table, view: &View<'a>, tables: &[View<'a>]) {
        if let Some(tag) = inner_tag(tables) {
            return self.inner(at, table, view, tables, tag);
        }
        let outer: Vec<&str> = tables.iter().filter_map(outer_tag).collect();
        if outer.len() == tables.len() {
            return self.outer(at, table, tables, &outer);
        }
        self.any(at, &Data::Table(table.clone()), tables);
    }

    /// `{ kind = "…", … }`
    fn inner(&mut self, at: &At, table: &Table, view: &View<'a>, tables: &[View<'a>], tag: &str) {
        let names: Vec<&str> = tables.iter().filter_map(|one| tag_of(one, tag)).collect();
        let Some(value) = table.get(tag) else {
            if !self.rules.partial {
                let message = format!("{} lacks the key `{tag}`", at.title());
                let hint = format!("add `{tag} = \"…\"`, one of {}", suggest::list(names.iter().copied()));
                self.report(at, message, hint, None);
            }
            return;
        };
        let here = at.below(tag, value.span());
        match value.get_ref().as_text() {
            Some(name) => match tables.iter().find(|one| tag_of(one, tag) == Some(name)) {
                Some(chosen) => {
                    // What the enum as a whole says comes after what the variant says.
                    let mut whole = chosen.clone();
                    whole.add(view.clone());
                    self.table(at, table, &whole);
                }
                None => self.unknown_name(&here, name, &names),
            },
            None => {
                let found = words::sort_of(value.get_ref());
                let hint = format!("choose one of {}", suggest::list(names.iter().copied()));
                self.report(&here, format!("`{tag}` must be text in quotes, not {found}"), hint, None);
            }
        }
    }

    /// `{ name = { … } }`
    fn outer(&mut self, at: &At, table: &Table, tables: &[View<'a>], names: &[&str]) {
        let chosen = table.keys().find_map(|key| names.iter().position(|name| name == key.get_ref()));
        match chosen.and_then(|index| tables.get(index)) {
            Some(chosen) => self.table(at, table, chosen),
            None => {
                let hint = format!("give one of {}", suggest::list(names.iter().copied()));
                let span = table.keys().next().map_or_else(|| at.span.clone(), toml::Spanned::span);
                self.report_at(&span, format!("{} must have exactly one known key", at.quoted()), hint, None);
            }
        }
    }

    /// Nothing tells which is meant: fine if one fits; otherwise tells what is wrong with the one that fits best.
    fn any(&mut self, at: &At, value: &Data, alternatives: &[View<'a>]) {
        let mut best: Option<Vec<_>> = None;
        for view in alternatives {
            let mut trial = Validator { sources: self.sources, rules: self.rules, problems: Vec::new() };
            trial.against(at, value, view);
            if best.as_ref().is_none_or(|best| trial.problems.len() < best.len()) {
                best = Some(trial.problems);
            }
        }
        self.problems.extend(best.unwrap_or_default());
    }
}

/// The key whose value tells all alternatives apart.
fn inner_tag<'a>(tables: &[View<'a>]) -> Option<&'a str> {
    let first = tables.first()?;
    let keys = first.properties();
    keys.into_iter().map(|(key, ..)| key).find(|key| tables.iter().all(|one| tag_of(one, key).is_some()))
}

/// What the key must be in this alternative.
fn tag_of<'a>(view: &View<'a>, key: &str) -> Option<&'a str> {
    let mut required = view.all("required").filter_map(|(_, list)| list.as_array()).flatten();
    required.find(|required| required.as_str() == Some(key))?;
    let (_, root, schema) = view.properties().into_iter().find(|(known, ..)| *known == key)?;
    View::of(root, schema).keyword("const").and_then(Json::as_str)
}

/// The only and required key of this alternative.
fn outer_tag<'a>(view: &View<'a>) -> Option<&'a str> {
    let properties = view.properties();
    let required = view.keyword("required")?.as_array()?;
    match properties.as_slice() {
        [(key, ..)] if required.len() == 1 => Some(key),
        _ => None,
    }
}
