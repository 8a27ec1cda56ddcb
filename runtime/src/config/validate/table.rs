//! Tables: known, unknown and missing keys.

use serde_json::Value as Json;

use super::{At, Validator, view::View, words};
use crate::config::{
    document::{Data, Key, Table, Value},
    problem::cut,
    suggest,
};

/// How deep to look for the table in which a lost key belongs.
const SEARCH_DEPTH: usize = 5;
/// A schema that branches more than this is not searched further.
const MOST_SEARCHED: usize = 2000;

impl<'a> Validator<'a> {
    pub(super) fn table(&mut self, at: &At, table: &Table, view: &View<'a>) {
        let known = view.properties();
        let others = others(view);
        for (key, value) in table {
            let name = key.get_ref().as_str();
            let inner = at.below(name, value.span());
            match (known.iter().find(|(known, ..)| *known == name), &others) {
                (Some((_, root, schema)), _) => self.value(&inner, value, root, schema),
                (None, Others::Fit(root, schema)) => self.value(&inner, value, root, schema),
                (None, Others::Free) => {}
                (None, Others::None) => self.unknown_key(at, key, value.get_ref(), view),
            }
        }
        for (name, root, schema) in known {
            if let Some((key, value)) = table.get_key_value(name) {
                self.beside(key, value, table, &View::of(root, schema));
            }
        }
        if !self.rules.partial {
            self.missing(at, table, view);
        }
    }

    /// Compares a value with others of its table.
    fn beside(&mut self, key: &Key, value: &Value, table: &Table, view: &View<'a>) {
        let name = key.get_ref();
        let other = |keyword: &str| table.get_key_value(view.keyword(keyword)?.as_str()?);
        if let Some((other, _)) = other("x-instead-of") {
            let other = other.get_ref();
            let message = format!("`{name}` stands beside `{other}`, but takes its place");
            self.report_at(&key.span(), message, format!("remove `{name}` or `{other}`"), None);
        }
        if let Some((other, least)) = other("x-above")
            && let (Some(number), Some(least)) = (value.get_ref().as_number(), least.get_ref().as_number())
            && number <= least
        {
            let other = other.get_ref();
            let message = format!("`{name}` = {number} is not above `{other}` = {least}");
            self.report_at(&value.span(), message, format!("give a number above `{other}`, or exchange the two"), None);
        }
    }

    fn missing(&mut self, at: &At, table: &Table, view: &View<'a>) {
        let required = view.all("required").flat_map(|(_, list)| list.as_array().into_iter().flatten()).filter_map(Json::as_str);
        for key in required.collect::<Vec<_>>() {
            if table.contains_key(key) {
                continue;
            }
            let schema = view.properties().into_iter().find(|(known, ..)| *known == key);
            let inner = schema.map(|(_, root, schema)| View::of(root, schema)).unwrap_or_default();
            let add = match inner.keyword("type").and_then(Json::as_str) {
                Some("string") => format!("add `{key} = \"…\"`"),
                Some("object") => format!("add a table `{key}`"),
                Some("array") => format!("add `{key} = […]`"),
                _ => format!("add `{key} = …`"),
            };
            self.report(at, format!("{} lacks the key `{key}`", at.title()), words::hint(add, &inner), None);
        }
    }

    fn unknown_key(&mut self, at: &At, key: &Key, value: &Data, view: &View<'a>) {
        let name = key.get_ref().as_str();
        let known = view.properties();
        let names = || known.iter().map(|(known, ..)| *known);
        let what = if value.as_table().is_some() { "table" } else { "key" };
        let message = format!("unknown {what} `{}` in {}", cut(name), at.title());
        let near = suggest::nearest(name, names());
        let elsewhere = self.belongs(name, at, view).map(|home| self.way_home(name, at, &home));
        let elsewhere = elsewhere.or_else(|| {
            (self.rules.elsewhere)(name).map(|home| format!("`{name}` is a key of {home}: move it there, or remove it"))
        });
        let hint = match (near, elsewhere) {
            // The very same word in another table is a better guess than a like one here.
            (_, Some(home)) => home,
            (Some(near), None) => {
                let schema = known.iter().find(|(known, ..)| *known == near);
                let about = schema.and_then(|(_, root, schema)| words::about(&View::of(root, schema)));
                let about = about.map_or_else(String::new, |about| format!(" ({about})"));
                format!("did you mean `{near}`?{about}")
            }
            (None, None) if known.is_empty() => "remove it: no key is known here".to_owned(),
            (None, None) => format!("remove it, or use one of the keys known here: {}", suggest::list(names())),
        };
        self.report_at(&key.span(), message, hint, None);
    }

    /// How a key gets to the table in which it is known.
    fn way_home(&self, name: &str, at: &At, home: &Home<'_>) -> String {
        let Home { path, list, view } = home;
        let about = words::about(view).map_or_else(String::new, |about| format!(" ({about})"));
        match (self.rules.common.is_some(), at.root) {
            // Where a part of a file has its header, nobody knows here; a key with a dot is right anywhere.
            (true, true) if !list => format!("`{name}` belongs in its table `{path}`{about}: write `{path}.{name}`"),
            (true, _) => format!("`{name}` belongs in `{path}`{about}: move it there"),
            (false, _) => {
                let header = if *list { format!("[[{path}]]") } else { format!("[{path}]") };
                format!("`{name}` belongs in `{header}`: move it there, or put the missing header above it")
            }
        }
    }

    /// The table in which a key of this name is known: below this one, or anywhere.
    fn belongs(&self, name: &str, at: &At, view: &View<'a>) -> Option<Home<'a>> {
        let root = self.rules.schema.as_value();
        home_of(name, view, &at.path, SEARCH_DEPTH).or_else(|| home_of(name, &View::of(root, root), "", SEARCH_DEPTH))
    }
}

/// A table in which a key is known.
struct Home<'a> {
    /// All keys that lead to it; `…` stands for a name that people choose.
    path: String,
    /// It is one of a list.
    list: bool,
    view: View<'a>,
}

/// The nearest table below a schema that knows the key.
fn home_of<'a>(name: &str, view: &View<'a>, path: &str, depth: usize) -> Option<Home<'a>> {
    let mut level: Vec<Home<'a>> = below(view, path);
    for _ in 0..depth {
        if level.len() > MOST_SEARCHED {
            break;
        }
        let knows = |home: &Home<'_>| home.view.properties().iter().any(|(key, ..)| *key == name);
        if let Some(place) = level.iter().position(knows) {
            return Some(level.swap_remove(place));
        }
        level = level.iter().flat_map(|home| below(&home.view, &home.path)).collect();
    }
    None
}

/// The values that a table holds by its schema.
fn below<'a>(view: &View<'a>, path: &str) -> Vec<Home<'a>> {
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    let mut found: Vec<(String, View<'a>)> =
        view.properties().into_iter().map(|(key, root, schema)| (join(key), View::of(root, schema))).collect();
    if let Others::Fit(root, schema) = others(view) {
        found.push((join("…"), View::of(root, schema)));
    }
    let unlisted = |(path, view): (String, View<'a>)| match view.rooted("items") {
        Some((root, schema)) => Home { path, list: true, view: View::of(root, schema) },
        None => Home { path, list: false, view },
    };
    found.into_iter().map(unlisted).collect()
}

/// What a schema says of keys that it does not name.
enum Others<'a> {
    /// They are unknown.
    None,
    /// They may be anything.
    Free,
    /// They are all alike.
    Fit(&'a Json, &'a Json),
}

fn others<'a>(view: &View<'a>) -> Others<'a> {
    if let Some((root, patterns)) = view.rooted("patternProperties") {
        // Only maps by number have patterns; that the key is a number shows when it is read.
        if let Some(schema) = patterns.as_object().and_then(|patterns| patterns.values().next()) {
            return Others::Fit(root, schema);
        }
    }
    match view.rooted("additionalProperties") {
        Some((_, Json::Bool(true))) => Others::Free,
        Some((root, schema @ Json::Object(_))) => Others::Fit(root, schema),
        _ => Others::None,
    }
}
