//! One table laid over another, and templates to lay them on.

mod templates;

use toml::Spanned;

use super::document::{Data, Table};
pub use templates::{Other, Templates};

/// Lays `over` on `base`: tables merge key by key, everything else in `over` replaces what is in `base`. Keys keep the order of
/// `base`, new ones follow. Each key and value keeps its place, so that an error points to the file and line it came from.
///
/// Two tables of one key that `other(key, base, over)` says are different things (another driver, another kind of agent) do
/// not merge: the settings of one mean nothing to the other, so the later one stands alone.
#[must_use]
pub fn merge(base: Table, mut over: Table, other: &impl Fn(&str, &Table, &Table) -> bool) -> Table {
    let mut merged = Table::with_capacity(base.len() + over.len());
    for (key, value) in base {
        let Some((over_key, over_value)) = over.remove_entry(key.get_ref().as_str()) else {
            merged.insert(key, value);
            continue;
        };
        let span = over_value.span();
        let value = match (value.into_inner(), over_value.into_inner()) {
            (Data::Table(below), Data::Table(above)) if !other(key.get_ref(), &below, &above) => {
                Data::Table(merge(below, above, other))
            }
            (_, above) => above,
        };
        merged.insert(over_key, Spanned::new(span, value));
    }
    merged.extend(over);
    merged
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;
    use crate::config::{Section, Sources};

    fn table(text: &str) -> Table {
        let mut sources = Sources::embedded([("f".to_owned(), text.into())]);
        let id = sources.read("f").unwrap();
        Section::parse(&sources, id).unwrap().table().clone()
    }

    fn plain(table: Table) -> toml::Table {
        toml::Table::try_from(Section::new(table, 0..0)).unwrap()
    }

    #[test]
    fn tables_merge_and_all_else_is_replaced() {
        let base = table("a = 1\nb = { x = 1, y = [1, 2] }\nc = 'old'\nd = { z = 1 }");
        let over = table("new = 1\nc = 'new'\nb.y = [3]\nd = 5");
        let merged = merge(base, over, &|_, _, _| false);
        let keys: Vec<&str> = merged.keys().map(|key| key.get_ref().as_str()).collect();
        assert_eq!(keys, ["a", "b", "c", "d", "new"]);
        assert_eq!(plain(merged), "a = 1\nb = { x = 1, y = [3] }\nc = 'new'\nd = 5\nnew = 1".parse().unwrap());
    }

    #[test]
    fn places_survive() {
        let mut sources =
            Sources::embedded([("one".to_owned(), b"k = { a = 1 }".to_vec()), ("two".to_owned(), b"k.b = 2".to_vec())]);
        let ids = ["one", "two"].map(|name| sources.read(name).unwrap());
        let [one, two] = ids.map(|id| Section::parse(&sources, id).unwrap());
        let merged = Section::new(merge(one.table().clone(), two.table().clone(), &|_, _, _| false), 0..0);
        let k = merged.section("k").unwrap();
        assert_eq!(sources.locate(&k.span_of("a")).unwrap().to_string(), "one:1:11");
        assert_eq!(sources.locate(&k.span_of("b")).unwrap().to_string(), "two:1:7");
    }

    #[test]
    fn different_things_do_not_merge() {
        let base = table("base = { driver = 'sim', noise = 1 }");
        let over = table("base = { driver = 'arcos', port = 'x' }");
        let merged = merge(base, over, &|key, _, _| key == "base");
        assert_eq!(plain(merged), "base = { driver = 'arcos', port = 'x' }".parse().unwrap());
    }

    fn tables() -> impl Strategy<Value = toml::Table> {
        let leaf = any::<i64>().prop_map(toml::Value::Integer);
        let value = leaf.prop_recursive(3, 24, 4, |inner| {
            proptest::collection::btree_map("[a-d]", inner, 0..4).prop_map(|map| toml::Value::Table(map.into_iter().collect()))
        });
        proptest::collection::btree_map("[a-d]", value, 0..4).prop_map(|map| map.into_iter().collect())
    }

    /// The same rule on plain data, told the other way round: what does one path lead to?
    fn at<'a>(table: &'a toml::Table, path: &[String]) -> Option<&'a toml::Value> {
        let (first, rest) = path.split_first()?;
        let value = table.get(first)?;
        if rest.is_empty() { Some(value) } else { at(value.as_table()?, rest) }
    }

    proptest! {
        #[test]
        fn the_upper_one_wins(a in tables(), b in tables(), path in proptest::collection::vec("[a-d]", 1..4)) {
            let spanned = |t: &toml::Table| table(&t.to_string());
            let over = |x: Table, y: Table| merge(x, y, &|_, _, _| false);
            let two = plain(over(spanned(&a), spanned(&b)));
            match (at(&a, &path), at(&b, &path)) {
                (_, Some(toml::Value::Integer(n))) => prop_assert_eq!(at(&two, &path), Some(&toml::Value::Integer(*n))),
                (Some(toml::Value::Integer(n)), None) => {
                    let hidden = (1..path.len()).any(|n| at(&b, &path[..n]).is_some_and(|v| !v.is_table()));
                    prop_assert_eq!(at(&two, &path).is_some_and(|v| v.as_integer() == Some(*n)), !hidden);
                }
                _ => {}
            }
            prop_assert_eq!(&plain(over(spanned(&a), Table::new())), &a);
            prop_assert_eq!(&plain(over(Table::new(), spanned(&a))), &a);
        }
    }
}
