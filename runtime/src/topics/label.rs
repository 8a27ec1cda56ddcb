//! A short text of fixed size, for payloads.

use std::{borrow::Cow, fmt};

use iceoryx2::prelude::ZeroCopySend;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A text of up to [`Label::MOST`] bytes, such as the name of a place. Longer ones are cut.
///
/// ```
/// use orienteer_runtime::topics::Label;
/// assert_eq!(Label::new("T, branch right").as_str(), "T, branch right");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::Label.v1")]
pub struct Label {
    len: u32,
    bytes: [u8; Self::MOST],
}

impl Label {
    /// The most bytes.
    pub const MOST: usize = 60;

    /// A label with this text, as much of it as there is room for.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let end = (0..=text.len().min(Self::MOST)).rev().find(|end| text.is_char_boundary(*end)).unwrap_or_default();
        let mut bytes = [0; Self::MOST];
        bytes[..end].copy_from_slice(&text.as_bytes()[..end]);
        Self { len: end as u32, bytes }
    }

    /// The text. Another process may have written what is none; it is empty then.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let len = (self.len as usize).min(Self::MOST);
        std::str::from_utf8(&self.bytes[..len]).unwrap_or_default()
    }
}

impl Default for Label {
    fn default() -> Self {
        Self { len: 0, bytes: [0; Self::MOST] }
    }
}

impl fmt::Debug for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl Serialize for Label {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for Label {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self::new(&Cow::<str>::deserialize(deserializer)?))
    }
}

impl JsonSchema for Label {
    fn schema_name() -> Cow<'static, str> {
        "Label".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "maxLength": Self::MOST })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_long_is_cut_between_letters() {
        let long = "ü".repeat(40);
        assert_eq!(Label::new(&long).as_str(), "ü".repeat(30));
        assert_eq!(Label::new(&format!("x{long}")).as_str().len(), 59);
    }

    #[test]
    fn what_is_no_text_is_empty() {
        let strange = Label { len: 900, bytes: [0xff; Label::MOST] };
        assert_eq!(strange.as_str(), "");
    }
}
