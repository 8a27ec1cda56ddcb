//! Compares a table with a JSON schema, and tells everything that is wrong at once.
//!
//! The schema comes from the same Rust types that the table is then read into (draft 2020-12, made by `schemars`), so what
//! is documented, what is checked and what is read cannot differ. Understood are `$ref`, `properties`, `required`,
//! `additionalProperties`, `patternProperties` (all keys), `type`, `enum`, `const`, `oneOf`/`anyOf` (options, enums with documented variants,
//! internally and externally tagged enums), `allOf`, `minimum`, `maximum`, their exclusive forms, `minLength`, `maxLength`,
//! `minItems`, `maxItems`, `items`, `prefixItems`, `uniqueItems`, the number formats, and these keywords of our own:
//!
//! * `x-names = "ring"`: the text must be one of the catalogue's names of that sort;
//! * `x-non-finite = true`: infinite numbers are allowed. NaN never is;
//! * `x-instead-of = "ring"`: the table may not hold that other key as well;
//! * `x-above = "from"`: the number must be above that of the other key.
//!
//! A table is closed unless its schema says otherwise, whether or not its type says `deny_unknown_fields`.

mod choice;
mod scalar;
mod table;
mod view;
mod words;

use schemars::{JsonSchema, Schema};
use serde::de::DeserializeOwned;
use serde_json::Value as Json;

use super::{
    document::{Data, Section, Value},
    problem::{Problem, Problems},
    source::{Sources, Span},
};
use view::View;

/// Says which names of a sort (`"ring"`, `"platform"`) there are. Asked where a schema has `x-names`.
pub type Names<'a> = &'a dyn Fn(&str) -> Vec<String>;

/// No names of any sort.
#[must_use]
pub fn no_names(_: &str) -> Vec<String> {
    Vec::new()
}

/// What a table is compared with.
#[derive(Clone, Copy)]
pub struct Rules<'a> {
    /// The table's own keys.
    pub schema: &'a Schema,
    /// Keys that all tables of the sort share (`kind`, `priority`): allowed besides. May not use `$ref`. Without them, the table is a whole
    /// file.
    pub common: Option<&'a Schema>,
    /// True for a template: keys may be missing, for whoever is based on it gives them.
    pub partial: bool,
    /// The table's name for people, such as `[mission]`.
    pub name: &'a str,
    /// Names of things that only the catalogue knows.
    pub names: Names<'a>,
    /// Where else a key of this name is known, to help somebody who lost a table header.
    pub elsewhere: &'a dyn Fn(&str) -> Option<String>,
}

/// Everything in a table that its rules refuse.
#[must_use]
pub fn check(section: &Section, rules: &Rules<'_>, sources: &Sources) -> Vec<Problem> {
    let mut validator = Validator { sources, rules, problems: Vec::new() };
    let root = rules.schema.as_value();
    let mut view = View::of(root, root);
    if let Some(common) = rules.common {
        view.add(View::of(common.as_value(), common.as_value()));
    }
    let at = At { name: rules.name.to_owned(), path: String::new(), span: section.span(), root: true };
    if view.alternatives().is_empty() {
        validator.table(&at, section.table(), &view);
    } else {
        validator.choice(&at, &Data::Table(section.table().clone()), &view);
    }
    validator.problems
}

/// Checks a table against the schema of a type and reads it.
///
/// ```
/// use orienteer_runtime::config::{Section, Sources, validate};
/// use schemars::JsonSchema;
/// use serde::Deserialize;
///
/// /// How fast to go.
/// #[derive(Debug, Deserialize, JsonSchema)]
/// #[serde(deny_unknown_fields)]
/// struct Pace {
///     /// Top speed, m/s.
///     #[schemars(range(min = 0.0, max = 3.0))]
///     speed: f64,
/// }
///
/// let mut sources = Sources::embedded([("pace.toml".into(), b"speed = 40".to_vec())]);
/// let id = sources.read("pace.toml")?;
/// let problems = validate::read::<Pace>(&Section::parse(&sources, id)?, &sources).unwrap_err();
/// assert_eq!(
///     problems.to_string(),
///     "pace.toml:1:9: error: `speed` = 40 is above the maximum of 3 (hint: allowed is 0 to 3: top speed, m/s)"
/// );
/// # Ok::<(), orienteer_runtime::config::Problems>(())
/// ```
///
/// # Errors
/// All problems, each at its place.
pub fn read<T: DeserializeOwned + JsonSchema>(section: &Section, sources: &Sources) -> Result<T, Problems> {
    let schema = schema_of::<T>();
    let rules =
        Rules { schema: &schema, common: None, partial: false, name: "this table", names: &no_names, elsewhere: &|_| None };
    Problems::check(check(section, &rules, sources))?;
    section.deserialize(sources)
}

/// The schema by which a type is read.
#[must_use]
pub fn schema_of<T: JsonSchema>() -> Schema {
    schemars::generate::SchemaSettings::draft2020_12().for_deserialize().into_generator().into_root_schema_for::<T>()
}

/// The value being looked at.
struct At {
    /// What to call it: the key, `points[2]`, or the table's header.
    name: String,
    /// All keys that lead to it.
    path: String,
    span: Span,
    root: bool,
}

impl At {
    /// The value under a key.
    fn below(&self, key: &str, span: Span) -> Self {
        let path = if self.root { key.to_owned() } else { format!("{}.{key}", self.path) };
        Self { name: key.to_owned(), path, span, root: false }
    }

    /// The name as a message quotes it.
    fn quoted(&self) -> String {
        if self.root { self.name.clone() } else { format!("`{}`", self.name) }
    }

    /// A table's name: all keys that lead to it.
    fn title(&self) -> String {
        if self.root { self.name.clone() } else { format!("`{}`", self.path) }
    }
}

struct Validator<'a> {
    sources: &'a Sources,
    rules: &'a Rules<'a>,
    problems: Vec<Problem>,
}

impl<'a> Validator<'a> {
    fn value(&mut self, at: &At, value: &Value, root: &'a Json, schema: &'a Json) {
        let view = View::of(root, schema);
        self.against(at, value.get_ref(), &view);
    }

    fn against(&mut self, at: &At, value: &Data, view: &View<'a>) {
        if view.refuses_all() {
            return self.report(at, format!("{} can't be set", at.quoted()), "remove the line", None);
        }
        if self.choice(at, value, view) {
            return;
        }
        if !self.fits_type(at, value, view) {
            return;
        }
        match value {
            Data::Table(table) => self.table(at, table, view),
            Data::List(values) => self.array(at, values, view),
            Data::Text(text) => self.text(at, text, view),
            Data::Whole(_) | Data::Number(_) => self.number(at, value, view),
            Data::Flag(_) | Data::Date(_) => {}
        }
    }

    fn array(&mut self, at: &At, values: &[Value], view: &View<'a>) {
        let least = view.keyword("minItems").and_then(Json::as_u64).unwrap_or(0);
        let most = view.keyword("maxItems").and_then(Json::as_u64).unwrap_or(u64::MAX);
        let count = values.len() as u64;
        if count < least || count > most {
            let wanted = words::count(least, most);
            let message = format!("{} has {}, not {wanted}", at.quoted(), words::counted(count, "value"));
            self.report(at, message, words::hint(format!("give {wanted}"), view), None);
        }
        let (prefix_root, prefix) = view
            .rooted("prefixItems")
            .map_or((&Json::Null, &[][..]), |(root, list)| (root, list.as_array().map_or(&[][..], Vec::as_slice)));
        let items = view.rooted("items");
        for (index, value) in values.iter().enumerate() {
            let name = format!("{}[{index}]", at.name);
            let inner = At { name, path: at.path.clone(), span: value.span(), root: false };
            match (prefix.get(index), items) {
                (Some(schema), _) => self.value(&inner, value, prefix_root, schema),
                (None, Some((root, schema))) => self.value(&inner, value, root, schema),
                (None, None) => {}
            }
        }
        if view.keyword("uniqueItems") == Some(&Json::Bool(true)) {
            self.unique(at, values);
        }
    }

    fn unique(&mut self, at: &At, values: &[Value]) {
        let mut seen = std::collections::BTreeMap::new();
        for value in values {
            let shown = words::shown(value.get_ref());
            if let Some(first) = seen.insert(shown.clone(), value.span()) {
                let message = format!("{} holds {shown} twice", at.quoted());
                let problem = Problem::new(self.sources, &value.span(), message, "remove one of the two");
                self.problems.push(problem.note(self.sources, &first, "it is first given here"));
            }
        }
    }

    fn report(&mut self, at: &At, message: impl Into<String>, hint: impl Into<String>, label: Option<String>) {
        self.report_at(&at.span, message, hint, label);
    }

    fn report_at(&mut self, span: &Span, message: impl Into<String>, hint: impl Into<String>, label: Option<String>) {
        let problem = Problem::new(self.sources, span, message, hint);
        self.problems.push(match label {
            Some(label) => problem.label(label),
            None => problem,
        });
    }
}

#[cfg(test)]
mod tests;
