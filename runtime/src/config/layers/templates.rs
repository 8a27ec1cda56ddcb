//! Named tables that others are based on.

use std::collections::{BTreeMap, BTreeSet};

use super::merge;
use crate::config::{
    document::{Section, Table, Value},
    problem::Problem,
    source::{Sources, Span},
    suggest,
};

/// The key by which a table names what it is based on.
const BASED_ON: &str = "template";

/// Says whether two tables of one key are different things, which do not merge. See [`merge`].
pub type Other<'a> = &'a dyn Fn(&str, &Table, &Table) -> bool;

/// All templates, each with everything that it is based on already below it.
#[derive(Debug, Default)]
pub struct Templates {
    whole: BTreeMap<String, Section>,
    broken: BTreeSet<String>,
}

impl Templates {
    /// Resolves the tables under `[template]`. Reports cycles and unknown templates.
    #[must_use]
    pub fn resolve(table: &Table, sources: &Sources, other: Other<'_>, problems: &mut Vec<Problem>) -> Self {
        let mut templates = Self::default();
        let raw: BTreeMap<&str, (Span, &Value)> =
            table.iter().map(|(key, value)| (key.get_ref().as_str(), (key.span(), value))).collect();
        for key in table.keys() {
            templates.visit(key.get_ref(), &raw, &mut Vec::new(), sources, other, problems);
        }
        templates
    }

    /// The names of all templates, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.whole.keys().chain(&self.broken).map(String::as_str)
    }

    /// A template with everything that it is based on.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Section> {
        self.whole.get(name)
    }

    /// A table laid over the template that it names, without that name. `None` if the template is unknown (which is then
    /// reported) or broken (which already was).
    #[must_use]
    pub fn under(&self, section: &Section, sources: &Sources, other: Other<'_>, problems: &mut Vec<Problem>) -> Option<Section> {
        let mut over = section.clone();
        over.table_mut().remove(BASED_ON);
        let Some(name) = section.text(BASED_ON) else { return Some(over) };
        if let Some(base) = self.whole.get(name) {
            return Some(Section::new(merge(base.table().clone(), over.table().clone(), &other), section.span()));
        }
        if !self.broken.contains(name) {
            problems.push(unknown(name, &section.span_of(BASED_ON), self.names(), sources));
        }
        None
    }

    fn visit<'a>(
        &mut self,
        name: &'a str,
        raw: &BTreeMap<&'a str, (Span, &'a Value)>,
        path: &mut Vec<&'a str>,
        sources: &Sources,
        other: Other<'_>,
        problems: &mut Vec<Problem>,
    ) {
        let Some((_, value)) = raw.get(name) else { return };
        if self.whole.contains_key(name) || self.broken.contains(name) {
            return;
        }
        if let Some(start) = path.iter().position(|visited| *visited == name) {
            self.broken.extend(path[start..].iter().map(|name| (*name).to_owned()));
            problems.push(cycle(&path[start..], raw, sources));
            return;
        }
        let Some(table) = value.get_ref().as_table() else {
            self.broken.insert(name.to_owned());
            return;
        };
        let section = Section::new(table.clone(), value.span());
        if let Some(base) = table.get(BASED_ON).and_then(|base| base.get_ref().as_text()) {
            if !raw.contains_key(base) {
                problems.push(unknown(
                    base,
                    &section.span_of(BASED_ON),
                    raw.keys().copied().filter(|known| *known != name),
                    sources,
                ));
            }
            path.push(name);
            self.visit(base, raw, path, sources, other, problems);
            path.pop();
            if !self.whole.contains_key(base) {
                self.broken.insert(name.to_owned());
                return;
            }
        }
        if let Some(whole) = self.under(&section, sources, other, problems) {
            self.whole.insert(name.to_owned(), whole);
        }
    }
}

fn unknown<'a>(name: &str, at: &Span, known: impl Iterator<Item = &'a str> + Clone, sources: &Sources) -> Problem {
    let hint = match suggest::did_you_mean(name, known.clone()) {
        Some(question) => question,
        None if known.clone().next().is_none() => format!("define it: `[template.{name}]`"),
        None => format!("the templates are: {}", suggest::list(known)),
    };
    Problem::new(sources, at, format!("there is no template `{name}`"), hint)
}

fn cycle(path: &[&str], raw: &BTreeMap<&str, (Span, &Value)>, sources: &Sources) -> Problem {
    let place = |name: &str| {
        let link = raw.get(name).and_then(|(_, value)| value.get_ref().as_table()?.get(BASED_ON));
        link.map_or(0..0, toml::Spanned::span)
    };
    let (first, rest) = path.split_first().unwrap_or((&"", &[]));
    let round = path.iter().chain([first]).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" → ");
    let message = match rest {
        [] => format!("the template {} is based on itself", format_args!("`{first}`")),
        _ => format!("these templates are based on each other: {round}"),
    };
    let mut problem = Problem::new(sources, &place(first), message, "remove one of the `template` keys on the way round");
    for name in rest {
        problem = problem.note(sources, &place(name), format!("`{name}` goes on here"));
    }
    problem
}
