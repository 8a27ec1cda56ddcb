//! The ROS 1 message definition of a payload, made from its JSON schema.
//!
//! Recording tools read definitions to show packed messages. A type has one if it is a struct of numbers, truth values,
//! texts, other such structs, and arrays of these: everything that a topic of the catalogue holds.
//!
//! ```text
//! # Where the robot thinks it is, in the map frame. Topic `pose`.
//! uint64 stamp
//! orienteer/Pose pose
//! float64[9] covariance
//! ================
//! MSG: orienteer/Pose
//! float64 x
//! ```

use schemars::{JsonSchema, generate::SchemaSettings};
use serde_json::{Map, Value};

/// What separates the definitions of nested types from each other.
const RULE: &str = "================================================================================";

/// A type of packed messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Definition {
    /// `package/Type`.
    pub(super) name: String,
    /// The definition with those of all nested types.
    pub(super) text: String,
    structs: Vec<Struct>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Struct {
    name: String,
    comment: String,
    fields: Vec<Field>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Field {
    name: String,
    comment: String,
    kind: Kind,
    count: Count,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Kind {
    /// A ROS name and its size.
    Number(&'static str, usize),
    Text,
    /// Index among the structs.
    Nested(usize),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Count {
    One,
    Fixed(usize),
    Counted,
}

impl Definition {
    /// The definition of `T` in `package`; `None` if `T` has no packed form.
    pub(super) fn of<T: JsonSchema>(package: &str) -> Option<Self> {
        let schema = SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>();
        let root = schema.as_value().as_object()?;
        let mut builder = Builder { defs: root.get("$defs").and_then(Value::as_object), structs: Vec::new() };
        builder.add(&T::schema_name(), root)?;
        is_name(package).then(|| Self::write(package, builder.structs))
    }

    fn write(package: &str, structs: Vec<Struct>) -> Self {
        let mut text = String::new();
        for (i, nested) in structs.iter().enumerate() {
            if i > 0 {
                text += &format!("{RULE}\nMSG: {package}/{}\n", nested.name);
            }
            comment(&mut text, &nested.comment);
            for field in &nested.fields {
                comment(&mut text, &field.comment);
                let kind = match &field.kind {
                    Kind::Number(name, _) => (*name).to_owned(),
                    Kind::Text => "string".to_owned(),
                    Kind::Nested(index) => format!("{package}/{}", structs[*index].name),
                };
                let count = match field.count {
                    Count::One => String::new(),
                    Count::Fixed(count) => format!("[{count}]"),
                    Count::Counted => "[]".to_owned(),
                };
                text += &format!("{kind}{count} {}\n", field.name);
            }
        }
        Self { name: format!("{package}/{}", structs[0].name), text, structs }
    }

    /// True if `bytes` can be one message of this type: every field finds its bytes and none are left over.
    pub(super) fn fits(&self, bytes: &[u8]) -> bool {
        self.after(0, bytes).is_some_and(<[u8]>::is_empty)
    }

    /// What follows one struct at the start of `bytes`.
    fn after<'b>(&self, index: usize, mut bytes: &'b [u8]) -> Option<&'b [u8]> {
        for field in &self.structs[index].fields {
            let count = match field.count {
                Count::One => 1,
                Count::Fixed(count) => count,
                Count::Counted => length(&mut bytes)?,
            };
            for _ in 0..count {
                bytes = match field.kind {
                    Kind::Number(_, size) => bytes.get(size..)?,
                    Kind::Text => {
                        let size = length(&mut bytes)?;
                        bytes.get(size..)?
                    }
                    Kind::Nested(nested) => self.after(nested, bytes)?,
                };
            }
        }
        Some(bytes)
    }
}

/// A definition without its comments: what must agree for two programs to read each other's messages.
pub(super) fn essence(text: &str) -> impl Iterator<Item = &str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'))
}

fn length(bytes: &mut &[u8]) -> Option<usize> {
    let (head, rest) = bytes.split_first_chunk::<4>()?;
    *bytes = rest;
    Some(u32::from_le_bytes(*head) as usize)
}

fn comment(text: &mut String, comment: &str) {
    for line in comment.lines() {
        *text += format!("# {line}").trim_end();
        text.push('\n');
    }
}

fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

struct Builder<'s> {
    defs: Option<&'s Map<String, Value>>,
    structs: Vec<Struct>,
}

impl<'s> Builder<'s> {
    /// Adds a struct and all that it contains; its index.
    fn add(&mut self, name: &str, schema: &'s Map<String, Value>) -> Option<usize> {
        if let Some(known) = self.structs.iter().position(|known| known.name == name) {
            return Some(known);
        }
        let properties = schema.get("properties")?.as_object()?;
        let required = schema.get("required")?.as_array()?;
        // A field that may be left out would shift all that follow it; other keywords add fields behind our back.
        let always = |field: &String| required.iter().any(|r| r.as_str() == Some(field));
        let foreign = ["allOf", "anyOf", "oneOf", "patternProperties"].iter().any(|keyword| schema.contains_key(*keyword));
        if !is_name(name) || foreign || !properties.keys().all(|field| is_name(field) && always(field)) {
            return None;
        }
        let index = self.structs.len();
        self.structs.push(Struct { name: name.to_owned(), comment: description(schema), fields: Vec::new() });
        for (field, schema) in properties {
            let (kind, count) = self.field(schema.as_object()?)?;
            let field = Field { name: field.clone(), comment: description(schema.as_object()?), kind, count };
            self.structs[index].fields.push(field);
        }
        Some(index)
    }

    fn field(&mut self, schema: &'s Map<String, Value>) -> Option<(Kind, Count)> {
        let (name, schema) = self.resolve(schema)?;
        if schema.get("type").and_then(Value::as_str) != Some("array") {
            return Some((self.kind(name, schema)?, Count::One));
        }
        let bound = |key: &str| schema.get(key).and_then(Value::as_u64).and_then(|bound| usize::try_from(bound).ok());
        let count = match (bound("minItems"), bound("maxItems")) {
            (Some(least), Some(most)) if least == most => Count::Fixed(most),
            _ => Count::Counted,
        };
        let (name, items) = self.resolve(schema.get("items")?.as_object()?)?;
        Some((self.kind(name, items)?, count))
    }

    fn kind(&mut self, name: &str, schema: &'s Map<String, Value>) -> Option<Kind> {
        let text = |key: &str| schema.get(key).and_then(Value::as_str);
        Some(match (text("type")?, text("format")) {
            ("object", None) => Kind::Nested(self.add(name, schema)?),
            ("boolean", None) => Kind::Number("bool", 1),
            ("string", None) if !schema.contains_key("enum") && !schema.contains_key("const") => Kind::Text,
            ("number", Some("double")) => Kind::Number("float64", 8),
            ("number", Some("float")) => Kind::Number("float32", 4),
            ("integer", Some("uint8")) => Kind::Number("uint8", 1),
            ("integer", Some("uint16")) => Kind::Number("uint16", 2),
            ("integer", Some("uint32")) => Kind::Number("uint32", 4),
            ("integer", Some("uint64")) => Kind::Number("uint64", 8),
            ("integer", Some("int8")) => Kind::Number("int8", 1),
            ("integer", Some("int16")) => Kind::Number("int16", 2),
            ("integer", Some("int32")) => Kind::Number("int32", 4),
            ("integer", Some("int64")) => Kind::Number("int64", 8),
            _ => return None,
        })
    }

    /// Follows a reference to where the type is described, and its name there.
    fn resolve(&self, schema: &'s Map<String, Value>) -> Option<(&'s str, &'s Map<String, Value>)> {
        let Some(reference) = schema.get("$ref").and_then(Value::as_str) else { return Some(("", schema)) };
        let name = reference.strip_prefix("#/$defs/")?;
        Some((name, self.defs?.get(name)?.as_object()?))
    }
}

fn description(schema: &Map<String, Value>) -> String {
    schema.get("description").and_then(Value::as_str).unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use serde::{Deserialize, Serialize};

    use super::{super::packed::pack, *};
    use crate::topics::*;

    #[test]
    fn the_definition_names_every_field() {
        let definition = Definition::of::<PoseEstimate>("orienteer").unwrap();
        assert_eq!(definition.name, "orienteer/PoseEstimate");
        let lines: Vec<_> = essence(&definition.text).collect();
        assert_eq!(
            lines,
            [
                "uint64 stamp",
                "orienteer/Pose pose",
                "float64[9] covariance",
                "float64 travelled",
                RULE,
                "MSG: orienteer/Pose",
                "float64 x",
                "float64 y",
                "float64 heading"
            ]
        );
        assert!(definition.text.contains("# Path length driven since the start, m.\nfloat64 travelled"));
    }

    fn assert_fits<P: Payload>(sample: P) {
        let definition = Definition::of::<P>("orienteer").unwrap();
        let mut bytes = Vec::new();
        pack(&sample, &mut bytes).unwrap();
        assert!(definition.fits(&bytes), "{} does not describe {bytes:?}", definition.text);
        bytes.push(0);
        assert!(!definition.fits(&bytes));
        assert!(!definition.fits(&bytes[..bytes.len() - 2]));
    }

    #[test]
    fn every_payload_of_the_catalogue_has_a_definition_that_fits_its_bytes() {
        assert_fits(SonarScan::unfired(16));
        assert_fits(SonarClaim {
            program: FiringProgram { slots: FixedVec::filled(3, 5), ..Default::default() },
            ..Default::default()
        });
        assert_fits(SonarDecision::default());
        assert_fits(Odometry::default());
        assert_fits(MotionReport::default());
        assert_fits(BaseClaim::default());
        assert_fits(BaseDecision::default());
        assert_fits(BaseNotice::default());
        assert_fits(PoseEstimate::default());
        assert_fits(CorridorOrder::default());
        assert_fits(FeatureReport::default());
        assert_fits(PlaceOrder::default());
        assert_fits(PlaceBelief::default());
        assert_fits(PlaceReport::default());
        assert_fits(FeatureRequest::default());
        assert_fits(CorridorReport::default());
        assert_fits(Truth::default());
    }

    #[derive(Serialize, Deserialize, JsonSchema)]
    enum Mood {
        Good,
    }

    #[derive(Serialize, Deserialize, JsonSchema)]
    struct Moody {
        mood: Mood,
    }

    #[derive(Serialize, Deserialize, JsonSchema)]
    struct Optional {
        maybe: Option<f64>,
    }

    #[derive(Serialize, Deserialize, JsonSchema)]
    struct Skipping {
        #[serde(skip_serializing_if = "Vec::is_empty")]
        often_empty: Vec<f64>,
    }

    #[derive(Serialize, Deserialize, JsonSchema)]
    struct Deep {
        rows: Vec<Vec<f64>>,
    }

    #[test]
    fn types_without_a_packed_form_have_no_definition() {
        assert_eq!(Definition::of::<Moody>("test"), None);
        assert_eq!(Definition::of::<Optional>("test"), None);
        assert_eq!(Definition::of::<Skipping>("test"), None);
        assert_eq!(Definition::of::<Deep>("test"), None);
        assert_eq!(Definition::of::<f64>("test"), None);
        assert_eq!(Definition::of::<Truth>("no name"), None);
    }
}
