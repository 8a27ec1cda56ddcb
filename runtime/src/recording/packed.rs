//! ROS 1 serialization of the serde data model: numbers little-endian and unpadded, in the order of the fields.
//!
//! A sequence is preceded by its length as `u32`, an array (a serde tuple) is not, a string is its length and its bytes. The
//! form says nothing about itself; the message definition beside it does, see [`super::definition`]. Numbers survive bit
//! by bit, NaN included, which JSON could not promise.

use std::fmt;

use serde::{
    Serialize, Serializer,
    ser::{Error as _, Impossible, SerializeSeq, SerializeStruct, SerializeTuple, SerializeTupleStruct},
};

/// Why a value has no packed form, or bytes are not the packed form of a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PackError(pub(super) String);

impl fmt::Display for PackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for PackError {}

impl serde::ser::Error for PackError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

impl serde::de::Error for PackError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

/// Appends the packed form of `value` to `bytes`. After an error, what was appended is of no use.
pub(super) fn pack<T: Serialize>(value: &T, bytes: &mut Vec<u8>) -> Result<(), PackError> {
    value.serialize(Packer { bytes })
}

struct Packer<'b> {
    bytes: &'b mut Vec<u8>,
}

impl Packer<'_> {
    fn length(&mut self, length: usize) -> Result<(), PackError> {
        let length = u32::try_from(length).map_err(PackError::custom)?;
        self.bytes.extend_from_slice(&length.to_le_bytes());
        Ok(())
    }
}

fn no_form<T>(what: &str) -> Result<T, PackError> {
    Err(PackError(format!("{what} have no packed form")))
}

macro_rules! numbers {
    ($($method:ident $type:ty),*) => {$(
        fn $method(self, value: $type) -> Result<(), PackError> {
            self.bytes.extend_from_slice(&value.to_le_bytes());
            Ok(())
        }
    )*};
}

impl Serializer for Packer<'_> {
    type Ok = ();
    type Error = PackError;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Impossible<(), PackError>;
    type SerializeMap = Impossible<(), PackError>;
    type SerializeStruct = Self;
    type SerializeStructVariant = Impossible<(), PackError>;

    numbers!(serialize_u8 u8, serialize_u16 u16, serialize_u32 u32, serialize_u64 u64, serialize_i8 i8, serialize_i16 i16,
        serialize_i32 i32, serialize_i64 i64, serialize_f32 f32, serialize_f64 f64);

    /// The definition is made from the JSON schema, so types must choose the same form here as there.
    fn is_human_readable(&self) -> bool {
        true
    }

    fn serialize_bool(self, value: bool) -> Result<(), PackError> {
        self.bytes.push(u8::from(value));
        Ok(())
    }

    fn serialize_str(mut self, value: &str) -> Result<(), PackError> {
        self.length(value.len())?;
        self.bytes.extend_from_slice(value.as_bytes());
        Ok(())
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(self, _: &'static str, value: &T) -> Result<(), PackError> {
        value.serialize(self)
    }

    fn serialize_seq(mut self, length: Option<usize>) -> Result<Self, PackError> {
        let Some(length) = length else { return no_form("sequences of unknown length") };
        self.length(length)?;
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, PackError> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, PackError> {
        Ok(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, PackError> {
        Ok(self)
    }

    fn serialize_char(self, _: char) -> Result<(), PackError> {
        no_form("characters")
    }

    fn serialize_bytes(self, _: &[u8]) -> Result<(), PackError> {
        no_form("byte strings")
    }

    fn serialize_none(self) -> Result<(), PackError> {
        no_form("options")
    }

    fn serialize_some<T: ?Sized + Serialize>(self, _: &T) -> Result<(), PackError> {
        no_form("options")
    }

    fn serialize_unit(self) -> Result<(), PackError> {
        no_form("units")
    }

    fn serialize_unit_struct(self, _: &'static str) -> Result<(), PackError> {
        no_form("units")
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), PackError> {
        no_form("enums")
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: &T,
    ) -> Result<(), PackError> {
        no_form("enums")
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleVariant, PackError> {
        no_form("enums")
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeStructVariant, PackError> {
        no_form("enums")
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, PackError> {
        no_form("maps")
    }
}

/// Sequences, tuples and tuple structs are packed alike: one element after the other.
macro_rules! pack_one_after_the_other {
    ($($form:ident :: $element:ident),*) => {$(
        impl $form for Packer<'_> {
            type Ok = ();
            type Error = PackError;

            fn $element<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), PackError> {
                value.serialize(Packer { bytes: self.bytes })
            }

            fn end(self) -> Result<(), PackError> {
                Ok(())
            }
        }
    )*};
}

pack_one_after_the_other!(
    SerializeSeq::serialize_element,
    SerializeTuple::serialize_element,
    SerializeTupleStruct::serialize_field
);

impl SerializeStruct for Packer<'_> {
    type Ok = ();
    type Error = PackError;

    fn serialize_field<T: ?Sized + Serialize>(&mut self, _: &'static str, value: &T) -> Result<(), PackError> {
        value.serialize(Packer { bytes: self.bytes })
    }

    fn end(self) -> Result<(), PackError> {
        Ok(())
    }

    fn skip_field(&mut self, _: &'static str) -> Result<(), PackError> {
        no_form("skipped fields")
    }
}
