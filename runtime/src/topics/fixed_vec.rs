//! A short list of fixed size, for payloads.

use std::{
    borrow::Cow,
    ops::{Deref, DerefMut},
};

use iceoryx2::prelude::ZeroCopySend;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

/// The most transducers that a ring may have; masks are 32 bits wide.
pub const MAX_TRANSDUCERS: usize = 32;

/// Up to [`MAX_TRANSDUCERS`] values, mostly one for each transducer of a ring in the ring's own order. Behaves like a slice.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::FixedVec.v1")]
pub struct FixedVec<T: ZeroCopySend> {
    len: u32,
    values: [T; MAX_TRANSDUCERS],
}

impl<T: ZeroCopySend + Copy + Default> FixedVec<T> {
    /// `len` copies of one value; a length above [`MAX_TRANSDUCERS`] is cut.
    #[must_use]
    pub fn filled(value: T, len: usize) -> Self {
        let mut values = [T::default(); MAX_TRANSDUCERS];
        let len = len.min(MAX_TRANSDUCERS);
        values[..len].fill(value);
        Self { len: len as u32, values }
    }

    /// Appends a value; false if there is no room for it.
    pub fn push(&mut self, value: T) -> bool {
        let len = self.len();
        let Some(place) = self.values.get_mut(len) else { return false };
        *place = value;
        self.len = len as u32 + 1;
        true
    }
}

impl<T: ZeroCopySend + Copy + Default> Default for FixedVec<T> {
    fn default() -> Self {
        Self::filled(T::default(), 0)
    }
}

impl<T: ZeroCopySend> Deref for FixedVec<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        // The length may have been written by another process.
        &self.values[..(self.len as usize).min(MAX_TRANSDUCERS)]
    }
}

impl<T: ZeroCopySend> DerefMut for FixedVec<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.values[..(self.len as usize).min(MAX_TRANSDUCERS)]
    }
}

impl<T: ZeroCopySend + Serialize> Serialize for FixedVec<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

impl<'de, T: ZeroCopySend + Copy + Default + Deserialize<'de>> Deserialize<'de> for FixedVec<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let values = Vec::<T>::deserialize(deserializer)?;
        if values.len() > MAX_TRANSDUCERS {
            return Err(D::Error::invalid_length(values.len(), &"at most 32 values"));
        }
        let mut list = Self::filled(T::default(), values.len());
        list.copy_from_slice(&values);
        Ok(list)
    }
}

impl<T: ZeroCopySend + JsonSchema> JsonSchema for FixedVec<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("FixedVecOf{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "array", "maxItems": MAX_TRANSDUCERS, "items": generator.subschema_for::<T>() })
    }
}
