//! All that a schema says about one value, gathered from its references.

use serde_json::{Map, Value as Json};

/// References to references end here; a schema from Rust types nests two or three.
const MAX_DEPTH: usize = 32;

/// The keyword maps that hold for one value at the same time, the nearest first, each with the document in which its own
/// references are to be looked up.
#[derive(Debug, Clone, Default)]
pub(super) struct View<'a> {
    layers: Vec<(&'a Json, &'a Map<String, Json>)>,
    refuses: bool,
}

impl<'a> View<'a> {
    /// Follows `$ref`, `allOf`, and the one alternative that is left of an option without `null`.
    pub(super) fn of(root: &'a Json, schema: &'a Json) -> Self {
        let mut view = Self::default();
        view.gather(root, schema, 0);
        view
    }

    /// Lets the rules of another view hold too.
    pub(super) fn add(&mut self, other: View<'a>) {
        self.layers.extend(other.layers);
    }

    /// True for the schema `false`.
    pub(super) fn refuses_all(&self) -> bool {
        self.refuses
    }

    /// The nearest use of a keyword.
    pub(super) fn keyword(&self, name: &str) -> Option<&'a Json> {
        self.rooted(name).map(|(_, value)| value)
    }

    /// The nearest use of a keyword and the document it stands in.
    pub(super) fn rooted(&self, name: &str) -> Option<(&'a Json, &'a Json)> {
        self.layers.iter().find_map(|(root, layer)| layer.get(name).map(|value| (*root, value)))
    }

    /// All uses of a keyword.
    pub(super) fn all<'b>(&'b self, name: &'b str) -> impl Iterator<Item = (&'a Json, &'a Json)> + 'b {
        self.layers.iter().filter_map(move |(root, layer)| layer.get(name).map(|value| (*root, value)))
    }

    /// Every known key with its document and schema, the nearest description first.
    pub(super) fn properties(&self) -> Vec<(&'a str, &'a Json, &'a Json)> {
        let mut found: Vec<(&str, &Json, &Json)> = Vec::new();
        for (root, properties) in self.all("properties") {
            for (key, schema) in properties.as_object().into_iter().flatten() {
                if !found.iter().any(|(known, ..)| known == key) {
                    found.push((key, root, schema));
                }
            }
        }
        found
    }

    /// The alternatives of a choice, without `null`, if there are several.
    pub(super) fn alternatives(&self) -> Vec<View<'a>> {
        let lists = ["oneOf", "anyOf"].into_iter().flat_map(|name| self.all(name).collect::<Vec<_>>());
        for (root, list) in lists {
            let left: Vec<&Json> = real(list).collect();
            if left.len() > 1 {
                return left.into_iter().map(|schema| View::of(root, schema)).collect();
            }
        }
        Vec::new()
    }

    fn gather(&mut self, root: &'a Json, schema: &'a Json, depth: usize) {
        let layer = match schema {
            Json::Object(layer) if depth < MAX_DEPTH => layer,
            Json::Bool(false) => return self.refuses = true,
            _ => return,
        };
        self.layers.push((root, layer));
        if let Some(target) = layer.get("$ref").and_then(Json::as_str).and_then(|path| root.pointer(path.strip_prefix('#')?)) {
            self.gather(root, target, depth + 1);
        }
        for part in layer.get("allOf").and_then(Json::as_array).into_iter().flatten() {
            self.gather(root, part, depth + 1);
        }
        for list in ["oneOf", "anyOf"].into_iter().filter_map(|name| layer.get(name)) {
            let mut left = real(list);
            if let (Some(only), None) = (left.next(), left.next()) {
                self.gather(root, only, depth + 1);
            }
        }
    }
}

/// The alternatives that are not `null`, which TOML does not have.
fn real(list: &Json) -> impl Iterator<Item = &Json> {
    let null = |schema: &&Json| schema.get("type") == Some(&Json::from("null"));
    list.as_array().into_iter().flatten().filter(move |schema| !null(schema))
}
