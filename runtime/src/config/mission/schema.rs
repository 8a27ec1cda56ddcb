//! The whole schema of mission files, for editors.

use serde_json::{Map, Value as Json, json};

use super::{
    Catalog,
    keys::{AgentTable, MissionFile},
};
use crate::config::validate::schema_of;

/// The JSON schema of mission files with everything that the catalogue knows: the keys of each kind of agent and each driver,
/// and all names. For editors: they complete keys, show descriptions and mark mistakes while one writes.
///
/// It asks less than reading does, because a robot may leave to its template what the schema of a single table would require.
#[must_use]
pub fn schema(catalog: &dyn Catalog) -> Json {
    let mut root = schema_of::<MissionFile>().to_value();
    let common = properties_of(schema_of::<AgentTable>().as_value());
    let mut definitions = Map::new();
    for kind in catalog.agent_kinds() {
        let Some(info) = catalog.agent(&kind) else { continue };
        let own = part(info.schema.as_value(), &format!("agent.{kind}"), &mut definitions);
        definitions.insert(format!("agent.{kind}"), joined(own, &info.help, "kind", &kind, &common));
    }
    definitions.insert("agent".to_owned(), tagged("kind", "agent", &catalog.agent_kinds()));
    definitions.insert("AgentTable".to_owned(), choice("kind", "agent", &catalog.agent_kinds()));
    for (table, device, names) in
        [("BaseTable", "base", catalog.base_drivers()), ("SonarTable", "sonar", catalog.sonar_drivers())]
    {
        for name in &names {
            let info = if device == "base" { catalog.base_driver(name) } else { catalog.sonar_driver(name) };
            let Some(info) = info else { continue };
            let own = part(info.schema.as_value(), &format!("{device}.{name}"), &mut definitions);
            definitions.insert(format!("{device}.{name}"), joined(own, &info.help, "driver", name, &Map::new()));
        }
        definitions.insert(table.to_owned(), choice("driver", device, &names));
    }
    if let Some(known) = root.get_mut("$defs").and_then(Json::as_object_mut) {
        known.extend(definitions);
        for owner in ["RobotKeys", "TemplateKeys"] {
            if let Some(agents) = known.get_mut(owner).and_then(|owner| owner.pointer_mut("/properties/agent")) {
                // An agent's name is its kind unless it says otherwise.
                let by_name = |kind: &String| {
                    let either = json!({ "anyOf": [{ "$ref": format!("#/$defs/agent.{kind}") }, { "$ref": "#/$defs/agent" }] });
                    (kind.clone(), either)
                };
                agents["properties"] = Json::Object(catalog.agent_kinds().iter().map(by_name).collect());
            }
        }
    }
    root["title"] = "Orienteer mission".into();
    name_names(&mut root, catalog);
    root
}

/// The keys of a kind or driver beside its tag and what all share.
fn joined(own: Json, help: &str, tag: &str, name: &str, common: &Map<String, Json>) -> Json {
    let Json::Object(mut own) = own else { return json!({ "type": "object" }) };
    let mut properties = Map::new();
    properties.insert(tag.to_owned(), json!({ "type": "string", "const": name, "description": help }));
    properties.extend(common.iter().filter(|(key, _)| *key != tag).map(|(key, value)| (key.clone(), value.clone())));
    properties.extend(properties_of(&Json::Object(own.clone())));
    own.remove("required");
    own.insert("description".to_owned(), help.into());
    own.insert("type".to_owned(), "object".into());
    own.insert("properties".to_owned(), Json::Object(properties));
    // Alternatives of an enum bring keys of their own.
    if !["oneOf", "anyOf", "allOf", "$ref"].iter().any(|keyword| own.contains_key(*keyword)) {
        own.entry("additionalProperties").or_insert(Json::Bool(false));
    }
    Json::Object(own)
}

/// A table whose tag says which definition holds.
fn tagged(tag: &str, prefix: &str, names: &[String]) -> Json {
    let one = |name: &String| json!({ "$ref": format!("#/$defs/{prefix}.{name}"), "required": [tag] });
    json!({ "oneOf": names.iter().map(one).collect::<Vec<_>>() })
}

/// The same, or no tag at all: then a template gives it.
fn choice(tag: &str, prefix: &str, names: &[String]) -> Json {
    let mut schema = tagged(tag, prefix, names);
    if let Some(alternatives) = schema["oneOf"].as_array_mut() {
        alternatives.push(json!({ "type": "object", "not": { "required": [tag] } }));
    }
    schema
}

fn properties_of(schema: &Json) -> Map<String, Json> {
    schema.get("properties").and_then(Json::as_object).cloned().unwrap_or_default()
}

/// A schema to be used within another: its definitions move up under names of their own.
fn part(schema: &Json, prefix: &str, definitions: &mut Map<String, Json>) -> Json {
    let mut own = schema.clone();
    rename(&mut own, prefix);
    let Some(object) = own.as_object_mut() else { return own };
    object.remove("$schema");
    object.remove("title");
    if let Some(Json::Object(inner)) = object.remove("$defs") {
        definitions.extend(inner.into_iter().map(|(name, schema)| (format!("{prefix}.{name}"), schema)));
    }
    own
}

fn rename(schema: &mut Json, prefix: &str) {
    each_object(schema, &mut |object| {
        if let Some(Json::String(target)) = object.get_mut("$ref")
            && let Some(name) = target.strip_prefix("#/$defs/")
        {
            *target = format!("#/$defs/{prefix}.{name}");
        }
    });
}

/// Turns `x-names` into the names, and drops what other programs can't read.
fn name_names(schema: &mut Json, catalog: &dyn Catalog) {
    each_object(schema, &mut |object| {
        if let Some(Json::String(sort)) = object.remove("x-names") {
            object.insert("enum".to_owned(), catalog.names(&sort).into());
        }
        object.remove("x-instead-of");
        object.remove("x-above");
    });
}

fn each_object(schema: &mut Json, change: &mut dyn FnMut(&mut Map<String, Json>)) {
    match schema {
        Json::Object(object) => {
            change(object);
            object.values_mut().for_each(|value| each_object(value, change));
        }
        Json::Array(values) => values.iter_mut().for_each(|value| each_object(value, change)),
        _ => {}
    }
}
