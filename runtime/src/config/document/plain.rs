//! Configuration as plain data, without places.

use serde::{Serialize, Serializer, ser::SerializeMap};

use super::{Data, Section, Table};

impl Serialize for Section {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        PlainTable(&self.table).serialize(serializer)
    }
}

struct PlainTable<'a>(&'a Table);

impl Serialize for PlainTable<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (key, value) in self.0 {
            map.serialize_entry(key.get_ref(), &PlainData(value.get_ref()))?;
        }
        map.end()
    }
}

struct PlainData<'a>(&'a Data);

impl Serialize for PlainData<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Data::Text(text) | Data::Date(text) => serializer.serialize_str(text),
            Data::Whole(number) => match i64::try_from(*number) {
                Ok(number) => serializer.serialize_i64(number),
                Err(_) => serializer.serialize_i128(*number),
            },
            Data::Number(number) => serializer.serialize_f64(*number),
            Data::Flag(yes) => serializer.serialize_bool(*yes),
            Data::List(values) => serializer.collect_seq(values.iter().map(|value| PlainData(value.get_ref()))),
            Data::Table(table) => PlainTable(table).serialize(serializer),
        }
    }
}
