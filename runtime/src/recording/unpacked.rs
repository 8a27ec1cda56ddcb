//! The way back from the packed form of [`super::packed`].

use serde::{
    de::{DeserializeOwned, DeserializeSeed, Deserializer, SeqAccess, Visitor},
    forward_to_deserialize_any,
};

use super::packed::PackError;

/// The value whose packed form is exactly `bytes`.
pub(super) fn unpack<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, PackError> {
    let mut unpacker = Unpacker { bytes };
    let value = T::deserialize(&mut unpacker)?;
    match unpacker.bytes.len() {
        0 => Ok(value),
        rest => Err(PackError(format!("{rest} bytes are left over"))),
    }
}

struct Unpacker<'de> {
    bytes: &'de [u8],
}

impl<'de> Unpacker<'de> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], PackError> {
        let Some((head, rest)) = self.bytes.split_first_chunk::<N>() else {
            return Err(PackError(format!("{N} bytes are wanted, {} are left", self.bytes.len())));
        };
        self.bytes = rest;
        Ok(*head)
    }

    fn length(&mut self) -> Result<usize, PackError> {
        Ok(u32::from_le_bytes(self.take()?) as usize)
    }

    fn text(&mut self) -> Result<&'de str, PackError> {
        let length = self.length()?;
        let Some((head, rest)) = self.bytes.split_at_checked(length) else {
            return Err(PackError(format!("a text of {length} bytes is wanted, {} are left", self.bytes.len())));
        };
        self.bytes = rest;
        std::str::from_utf8(head).map_err(|error| PackError(error.to_string()))
    }
}

macro_rules! numbers {
    ($($method:ident $visit:ident $type:ty),*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, PackError> {
            visitor.$visit(<$type>::from_le_bytes(self.take()?))
        }
    )*};
}

impl<'de> Deserializer<'de> for &mut Unpacker<'de> {
    type Error = PackError;

    numbers!(deserialize_u8 visit_u8 u8, deserialize_u16 visit_u16 u16, deserialize_u32 visit_u32 u32,
        deserialize_u64 visit_u64 u64, deserialize_i8 visit_i8 i8, deserialize_i16 visit_i16 i16,
        deserialize_i32 visit_i32 i32, deserialize_i64 visit_i64 i64, deserialize_f32 visit_f32 f32,
        deserialize_f64 visit_f64 f64);

    fn is_human_readable(&self) -> bool {
        true
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, PackError> {
        Err(PackError("the packed form does not say what type comes next".into()))
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, PackError> {
        match self.take()? {
            [0] => visitor.visit_bool(false),
            [1] => visitor.visit_bool(true),
            [other] => Err(PackError(format!("{other} is not a truth value"))),
        }
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, PackError> {
        visitor.visit_borrowed_str(self.text()?)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, PackError> {
        self.deserialize_str(visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, PackError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, PackError> {
        let left = self.length()?;
        visitor.visit_seq(Elements { unpacker: self, left })
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, left: usize, visitor: V) -> Result<V::Value, PackError> {
        visitor.visit_seq(Elements { unpacker: self, left })
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(self, _: &'static str, left: usize, visitor: V) -> Result<V::Value, PackError> {
        visitor.visit_seq(Elements { unpacker: self, left })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, PackError> {
        visitor.visit_seq(Elements { unpacker: self, left: fields.len() })
    }

    forward_to_deserialize_any! {
        i128 u128 char bytes byte_buf option unit unit_struct map enum identifier ignored_any
    }
}

struct Elements<'u, 'de> {
    unpacker: &'u mut Unpacker<'de>,
    left: usize,
}

impl<'de> SeqAccess<'de> for Elements<'_, 'de> {
    type Error = PackError;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, PackError> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        seed.deserialize(&mut *self.unpacker).map(Some)
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.left)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use proptest::prelude::*;
    use serde::{Deserialize, Serialize};

    use super::{super::packed::pack, *};
    use crate::topics::FixedVec;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Everything {
        byte: u8,
        yes: bool,
        pair: [f64; 2],
        list: FixedVec<f32>,
        small: i16,
        nested: (u32, i64),
        text: String,
    }

    fn packed<T: Serialize>(value: &T) -> Vec<u8> {
        let mut bytes = Vec::new();
        pack(value, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn the_bytes_are_those_of_ros_1() {
        let mut list = FixedVec::filled(1.0f32, 2);
        list[1] = -2.0;
        let value =
            Everything {
                byte: 7, yes: true, pair: [1.0, f64::NEG_INFINITY], list, small: -2, nested: (1, -1), text: "ä".into()
            };
        let expected: Vec<u8> = [
            &[7u8, 1][..],
            &[0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0, 0, 0, 0, 0, 0xf0, 0xff],
            &[2, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0],
            &[0xfe, 0xff],
            &[1, 0, 0, 0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff],
            &[2, 0, 0, 0, 0xc3, 0xa4],
        ]
        .concat();
        assert_eq!(packed(&value), expected);
        assert_eq!(unpack::<Everything>(&expected).unwrap(), value);
        for cut in 0..expected.len() {
            assert!(unpack::<Everything>(&expected[..cut]).is_err(), "{cut} bytes were enough");
        }
        assert!(unpack::<Everything>(&[&expected[..], &[0]].concat()).is_err());
    }

    #[test]
    fn what_has_no_form_is_refused() {
        assert!(pack(&Some(1u8), &mut Vec::new()).is_err());
        assert!(pack(&std::collections::BTreeMap::from([(1u8, 2u8)]), &mut Vec::new()).is_err());
        assert!(unpack::<Option<u8>>(&[1]).is_err());
        assert!(unpack::<serde_json::Value>(&[1]).is_err());
        assert!(unpack::<bool>(&[2]).is_err());
        assert!(unpack::<Vec<u64>>(&[0xff, 0xff, 0xff, 0xff]).is_err());
    }

    proptest! {
        #[test]
        fn every_bit_of_a_number_survives(bits in any::<u64>(), few in any::<u32>()) {
            let (double, float) = (f64::from_bits(bits), f32::from_bits(few));
            let back: (f64, f32) = unpack(&packed(&(double, float))).unwrap();
            prop_assert_eq!((back.0.to_bits(), back.1.to_bits()), (bits, few));
        }
    }
}
