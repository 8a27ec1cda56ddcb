//! From a table to any type, with the place of what it refuses.

use std::fmt;

use serde::{
    Deserializer,
    de::{
        self, DeserializeOwned, DeserializeSeed, EnumAccess, IntoDeserializer, MapAccess, SeqAccess, Unexpected, VariantAccess,
        Visitor, value::StrDeserializer,
    },
    forward_to_deserialize_any,
};
use toml::Spanned;

use super::{Data, Key, Span, Table, Value};

/// Reads a whole table.
pub(super) fn table<T: DeserializeOwned>(table: &Table) -> Result<T, Refusal> {
    T::deserialize(Reader(Source::Table(table)))
}

/// What a type refused, and where.
#[derive(Debug)]
pub(super) struct Refusal {
    pub(super) message: String,
    pub(super) span: Option<Span>,
}

impl Refusal {
    /// At this place, unless a deeper one is known.
    fn at(mut self, span: Span) -> Self {
        self.span.get_or_insert(span);
        self
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Refusal {}

impl de::Error for Refusal {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self { message: message.to_string(), span: None }
    }
}

#[derive(Clone, Copy)]
enum Source<'a> {
    Data(&'a Data),
    Table(&'a Table),
}

struct Reader<'a>(Source<'a>);

impl<'a> Reader<'a> {
    fn of(value: &'a Value) -> Self {
        Self(match value.get_ref() {
            Data::Table(table) => Source::Table(table),
            data => Source::Data(data),
        })
    }
}

impl<'de> Deserializer<'de> for Reader<'_> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        match self.0 {
            Source::Table(table) | Source::Data(Data::Table(table)) => {
                visitor.visit_map(Entries { rest: table.iter(), value: None })
            }
            Source::Data(Data::Text(text) | Data::Date(text)) => visitor.visit_str(text),
            Source::Data(Data::Whole(number)) => match (i64::try_from(*number), u64::try_from(*number)) {
                (Ok(number), _) => visitor.visit_i64(number),
                (_, Ok(number)) => visitor.visit_u64(number),
                _ => visitor.visit_i128(*number),
            },
            Source::Data(Data::Number(number)) => visitor.visit_f64(*number),
            Source::Data(Data::Flag(yes)) => visitor.visit_bool(*yes),
            Source::Data(Data::List(values)) => visitor.visit_seq(Elements { rest: values.iter() }),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        match self.0 {
            Source::Data(Data::Text(text)) => visitor.visit_enum(text.as_str().into_deserializer()),
            Source::Table(table) | Source::Data(Data::Table(table)) => {
                let mut entries = table.iter();
                match (entries.next(), entries.next()) {
                    (Some((key, value)), None) => visitor.visit_enum(Variant { key, value }),
                    _ => Err(de::Error::custom("must have exactly one key")),
                }
            }
            Source::Data(_) => Err(de::Error::custom("must be text or a table")),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

struct Entries<'a, I: Iterator<Item = (&'a Key, &'a Value)>> {
    rest: I,
    value: Option<&'a Value>,
}

impl<'de, 'a, I: Iterator<Item = (&'a Key, &'a Value)>> MapAccess<'de> for Entries<'a, I> {
    type Error = Refusal;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Refusal> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        self.value = Some(value);
        seed.deserialize(KeyReader(key)).map(Some).map_err(|error| error.at(key.span()))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refusal> {
        let value = self.value.take().ok_or_else(|| <Refusal as de::Error>::custom("a value was asked for before its key"))?;
        seed.deserialize(Reader::of(value)).map_err(|error| error.at(value.span()))
    }
}

struct Elements<'a> {
    rest: std::slice::Iter<'a, Value>,
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Refusal;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Refusal> {
        let Some(value) = self.rest.next() else { return Ok(None) };
        seed.deserialize(Reader::of(value)).map(Some).map_err(|error| error.at(value.span()))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// A key may stand for a number or a name.
struct KeyReader<'a>(&'a Spanned<String>);

macro_rules! numbers_in_keys {
    ($($method:ident $type:ty => $visit:ident),*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
            match self.0.get_ref().parse::<$type>() {
                Ok(number) => visitor.$visit(number),
                Err(_) => Err(de::Error::invalid_value(Unexpected::Str(self.0.get_ref()), &visitor)),
            }
        }
    )*};
}

impl<'de> Deserializer<'de> for KeyReader<'_> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_str(self.0.get_ref())
    }

    numbers_in_keys!(deserialize_u8 u8 => visit_u8, deserialize_u16 u16 => visit_u16, deserialize_u32 u32 => visit_u32,
        deserialize_u64 u64 => visit_u64, deserialize_i8 i8 => visit_i8, deserialize_i16 i16 => visit_i16,
        deserialize_i32 i32 => visit_i32, deserialize_i64 i64 => visit_i64, deserialize_bool bool => visit_bool);

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        visitor.visit_enum(self.0.get_ref().as_str().into_deserializer())
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_newtype_struct(self)
    }

    forward_to_deserialize_any! {
        i128 u128 f32 f64 char str string bytes byte_buf option unit unit_struct seq tuple tuple_struct map struct identifier
        ignored_any
    }
}

struct Variant<'a> {
    key: &'a Key,
    value: &'a Value,
}

impl<'de, 'a> EnumAccess<'de> for Variant<'a> {
    type Error = Refusal;
    type Variant = Content<'a>;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Content<'a>), Refusal> {
        let name: StrDeserializer<'_, Refusal> = self.key.get_ref().as_str().into_deserializer();
        let variant = seed.deserialize(name).map_err(|error| error.at(self.key.span()))?;
        Ok((variant, Content(self.value)))
    }
}

struct Content<'a>(&'a Value);

impl<'de> VariantAccess<'de> for Content<'_> {
    type Error = Refusal;

    fn unit_variant(self) -> Result<(), Refusal> {
        Err(<Refusal as de::Error>::custom("this name takes no value").at(self.0.span()))
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Refusal> {
        seed.deserialize(Reader::of(self.0)).map_err(|error| error.at(self.0.span()))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Refusal> {
        Reader::of(self.0).deserialize_any(visitor).map_err(|error| error.at(self.0.span()))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, Refusal> {
        Reader::of(self.0).deserialize_any(visitor).map_err(|error| error.at(self.0.span()))
    }
}
