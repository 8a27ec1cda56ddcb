//! In which form the samples of a payload are recorded.

use foxglove::{Encode, Schema};
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};
use schemars::generate::SchemaSettings;

use super::{
    definition::Definition,
    packed::{PackError, pack},
    unpacked::unpack,
};
use crate::topics::Payload;

/// Everything that readers need to know of a channel's messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ChannelType {
    pub(super) message_encoding: &'static str,
    pub(super) schema_name: String,
    pub(super) schema_encoding: &'static str,
    pub(super) schema: Vec<u8>,
    /// Versioned name of the payload's type; empty for Foxglove's.
    pub(super) type_name: String,
}

/// MCAP's name of the packed encoding.
pub(super) const PACKED: &str = "ros1";
/// MCAP's name of JSON.
pub(super) const JSON: &str = "json";

/// The form of a payload's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// Small, fast and exact.
    Packed,
    /// For what has no packed form. Numbers may come back off by their last digit, NaN and infinity not at all.
    Json,
}

impl Form {
    /// Appends a sample.
    pub(super) fn encode<P: Payload>(self, sample: &P, bytes: &mut Vec<u8>) -> Result<(), PackError> {
        match self {
            Form::Packed => pack(sample, bytes),
            Form::Json => serde_json::to_writer(bytes, sample).map_err(|error| PackError(error.to_string())),
        }
    }
}

/// The versioned name of a payload's type, `package::Type.vN`.
pub(super) fn type_name<P: Payload>() -> String {
    TypeDetail::new::<P>(TypeVariant::FixedSize).type_name().to_string()
}

/// A payload's message definition in the package that its type name begins with.
pub(super) fn definition<P: Payload>() -> Option<Definition> {
    let name = type_name::<P>();
    let (package, _) = name.split_once("::")?;
    Definition::of::<P>(package)
}

/// The form in which samples like this one are recorded, and what the channel says of it. Packed, if the type has a definition,
/// the definition fits the bytes, and the bytes give the sample back.
pub(super) fn form<P: Payload>(sample: &P) -> (Form, ChannelType) {
    match definition::<P>().filter(|definition| comes_back(sample, definition)) {
        Some(definition) => {
            let channel = ChannelType {
                message_encoding: PACKED,
                schema_name: definition.name,
                schema_encoding: "ros1msg",
                schema: definition.text.into_bytes(),
                type_name: type_name::<P>(),
            };
            (Form::Packed, channel)
        }
        None => (Form::Json, json_channel::<P>()),
    }
}

fn comes_back<P: Payload>(sample: &P, definition: &Definition) -> bool {
    let (mut there, mut back) = (Vec::new(), Vec::new());
    pack(sample, &mut there).is_ok()
        && definition.fits(&there)
        && unpack::<P>(&there).is_ok_and(|sample| pack(&sample, &mut back).is_ok())
        && there == back
}

fn json_channel<P: Payload>() -> ChannelType {
    let schema = SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<P>();
    ChannelType {
        message_encoding: JSON,
        schema_name: P::schema_name().into_owned(),
        schema_encoding: "jsonschema",
        schema: schema.as_value().to_string().into_bytes(),
        type_name: type_name::<P>(),
    }
}

/// The channel of one of Foxglove's own messages.
pub(super) fn foxglove_channel<M: Encode>() -> ChannelType {
    let schema = M::get_schema().unwrap_or_else(|| Schema::new("", "", Vec::new()));
    ChannelType {
        message_encoding: "protobuf",
        schema_name: schema.name,
        schema_encoding: "protobuf",
        schema: schema.data.into_owned(),
        type_name: String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topics::{BaseDecision, SonarScan};

    #[test]
    fn the_catalogue_is_packed() {
        assert_eq!(form(&BaseDecision::default()).0, Form::Packed);
        let (form, channel) = form(&SonarScan::unfired(16));
        assert_eq!(form, Form::Packed);
        assert_eq!(
            (channel.schema_name.as_str(), channel.type_name.as_str()),
            ("orienteer/SonarScan", "orienteer::SonarScan.v1")
        );
    }
}
