#![allow(clippy::unwrap_used)]
use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;
use serde::{Deserialize, Serialize};

use super::*;

/// A way to turn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
enum Turn {
    /// On the spot.
    Spot {
        /// Turn rate, deg/s.
        #[schemars(range(min = 1.0, max = 90.0))]
        rate_deg: f64,
    },
    /// Along a curve.
    Curve(Curve),
    /// Not at all.
    Never,
}

/// A curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Curve {
    /// Radius, m.
    radius: f32,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Side {
    /// To port.
    Left,
    /// To starboard.
    Right,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Plain {
    One,
    Two,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Outer {
    Nothing,
    Distance(f64),
    Box { width: f64, height: f64 },
}

/// Says nothing of unknown fields, which must not make it open.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
struct Forgetful {
    a: Option<u8>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Everything {
    /// Top speed, m/s.
    ///
    /// It is more than enough.
    #[schemars(range(min = 0.0, max = 3.0))]
    speed: f64,
    count: u8,
    big: u64,
    signed: i32,
    turn: Turn,
    maybe_turn: Option<Turn>,
    side: Side,
    maybe_side: Option<Side>,
    plain: Plain,
    outer: Outer,
    maybe: Option<f64>,
    forgetful: Forgetful,
    point: (f64, f64),
    triple: [f32; 3],
    words: Vec<String>,
    set: BTreeSet<String>,
    by_name: BTreeMap<String, Curve>,
    by_number: BTreeMap<u8, f64>,
    flag: bool,
    letter: char,
    #[schemars(length(min = 1, max = 4))]
    short: String,
    #[schemars(extend("x-names" = "ring"))]
    ring: Option<String>,
    #[schemars(extend("x-non-finite" = true))]
    endless: f64,
    #[schemars(extend("x-instead-of" = "ring"))]
    own_ring: Option<Curve>,
    from: f64,
    #[schemars(extend("x-above" = "from"))]
    to: Option<f64>,
}

impl Default for Everything {
    fn default() -> Self {
        Self {
            speed: 0.3,
            count: 1,
            big: 0,
            signed: 0,
            turn: Turn::Never,
            maybe_turn: None,
            side: Side::Left,
            maybe_side: None,
            plain: Plain::One,
            outer: Outer::Nothing,
            maybe: None,
            forgetful: Forgetful { a: None },
            point: (0.0, 0.0),
            triple: [0.0; 3],
            words: Vec::new(),
            set: BTreeSet::new(),
            by_name: BTreeMap::new(),
            by_number: BTreeMap::new(),
            flag: false,
            letter: 'a',
            short: "abc".into(),
            ring: None,
            endless: 1.0,
            own_ring: None,
            from: 0.0,
            to: None,
        }
    }
}

fn rings(sort: &str) -> Vec<String> {
    if sort == "ring" { vec!["denning-16".into(), "luey-8".into()] } else { Vec::new() }
}

fn try_read(text: &str) -> Result<Everything, Problems> {
    let mut sources = Sources::embedded([("f".to_owned(), text.into())]);
    let id = sources.read("f").unwrap();
    let section = Section::parse(&sources, id)?;
    let schema = schema_of::<Everything>();
    let rules = Rules { schema: &schema, common: None, partial: false, name: "the file", names: &rings, elsewhere: &|_| None };
    Problems::check(check(&section, &rules, &sources))?;
    section.deserialize(&sources)
}

/// The lines of all problems, without the file's name.
fn told(text: &str) -> String {
    try_read(text).unwrap_err().to_string().replace("f:1:", "").replace("error: ", "")
}

#[test]
fn all_that_is_valid_is_read() {
    let read = try_read(
        r#"
        speed = 3
        count = 0xff
        big = 18446744073709551615
        signed = -5
        turn = { kind = "curve", radius = 2 }
        maybe_turn.kind = "spot"
        maybe_turn.rate_deg = 90
        side = "right"
        maybe_side = "left"
        plain = "two"
        outer = { box = { width = 1, height = 2.5 } }
        maybe = 1e-3
        forgetful.a = 3
        point = [1, 2.5]
        triple = [1, 2, 3]
        words = ["a", 'b']
        set = ["a"]
        by_name.x.radius = 1
        by_number = { 7 = 1.5 }
        flag = true
        letter = "é"
        short = "äöüß"
        ring = "luey-8"
        endless = inf
        from = 1
        to = 2.5
        "#,
    )
    .unwrap();
    let wanted = Everything {
        speed: 3.0,
        count: 255,
        big: u64::MAX,
        signed: -5,
        turn: Turn::Curve(Curve { radius: 2.0 }),
        maybe_turn: Some(Turn::Spot { rate_deg: 90.0 }),
        side: Side::Right,
        maybe_side: Some(Side::Left),
        plain: Plain::Two,
        outer: Outer::Box { width: 1.0, height: 2.5 },
        maybe: Some(1e-3),
        forgetful: Forgetful { a: Some(3) },
        point: (1.0, 2.5),
        triple: [1.0, 2.0, 3.0],
        words: vec!["a".into(), "b".into()],
        set: BTreeSet::from(["a".to_owned()]),
        by_name: BTreeMap::from([("x".to_owned(), Curve { radius: 1.0 })]),
        by_number: BTreeMap::from([(7, 1.5)]),
        flag: true,
        letter: 'é',
        short: "äöüß".into(),
        ring: Some("luey-8".into()),
        endless: f64::INFINITY,
        from: 1.0,
        to: Some(2.5),
        ..Everything::default()
    };
    assert_eq!(read, wanted);
    assert_eq!(try_read("").unwrap(), Everything::default());
}

#[test]
fn numbers() {
    let hint = "allowed is 0 to 3: top speed, m/s; the default is 0.3";
    assert_eq!(told("speed = 40"), format!("9: `speed` = 40 is above the maximum of 3 (hint: {hint})"));
    assert_eq!(told("speed = -0.5"), format!("9: `speed` = -0.5 is below the minimum of 0 (hint: {hint})"));
    assert_eq!(told("speed = nan"), format!("9: `speed` is not a usable number (hint: {hint})"));
    assert_eq!(told("speed = 1e400"), format!("9: `speed` is not a usable number (hint: {hint})"));
    assert_eq!(told("speed = inf"), format!("9: `speed` can't be infinite (hint: {hint})"));
    assert_eq!(told("count = 256"), "9: `count` = 256 is above the maximum of 255 (hint: allowed is 0 to 255; the default is 1)");
    assert_eq!(told("count = -1"), "9: `count` = -1 is below the minimum of 0 (hint: allowed is 0 to 255; the default is 1)");
    assert!(told("signed = 2147483648").starts_with("10: `signed` = 2147483648 is above the maximum of 2147483647"));
    assert!(told("big = 18446744073709551616").contains("above the maximum of 18446744073709551615"));
    assert!(told("big = 999999999999999999999999999999999999999999").contains("must be a whole number"));
    assert!(told("count = 2.0").contains("write a number without a point, such as `count = 2`"));
    assert_eq!(
        told("triple = [1, 2, 1e39]"),
        "17: `triple[2]` = 1e39 is above the maximum of 3.4028234663852886e38 (hint: give an ordinary number)"
    );
    assert!(told("endless = nan").contains("not a usable number"));
    assert!(told("endless = 1e400").contains("not a usable number"));
    assert!(told("maybe = inf").contains("can't be infinite"));
}

#[test]
fn types() {
    let hint = ": top speed, m/s; the default is 0.3";
    let wrong = "9: `speed` must be a number, not";
    assert_eq!(told("speed = \"0.5\""), format!("{wrong} text (hint: remove the quotes: `speed = 0.5`{hint})"));
    assert!(told("speed = \"0.5 m/s\"").contains("write the bare number, in the unit of the key: `speed = 0.5`"));
    assert_eq!(told("speed = true"), format!("{wrong} true or false (hint: give a number{hint})"));
    assert_eq!(told("speed = [1]"), format!("{wrong} a list (hint: remove the brackets: `speed = 1`{hint})"));
    assert!(told("speed = {}").starts_with("9: `speed` must be a number, not a table"));
    assert!(told("speed = 1979-05-27").starts_with("9: `speed` must be a number, not a date"));
    assert!(told("flag = \"yes\"").contains("remove the quotes: `flag = true`"));
    assert!(told("flag = 1").contains("write `true` or `false`"));
    assert!(told("short = 12").contains("put it in quotes: `short = \"12\"`"));
    assert!(told("words = \"a\"").contains("put it in brackets: `words = [\"a\"]`"));
    assert!(told("forgetful = [{a = 1}]").contains("write one table `[forgetful]`"));
    assert!(told("by_name = { x = 3 }").starts_with("17: `x` must be a table, not a whole number"));
}

#[test]
fn keys() {
    assert_eq!(told("sped = 1"), "1: unknown key `sped` in the file (hint: did you mean `speed`? (top speed, m/s))");
    assert!(
        told("forgetful.b = 1").contains("unknown key `b` in `forgetful` (hint: did you mean `a`?)")
            || told("forgetful.b = 1").contains("keys known here: `a`")
    );
    assert_eq!(
        told("width = 1"),
        "1: unknown key `width` in the file (hint: remove it, or use one of the keys known here: `speed`, `count`, `big`, `signed`, `turn`, `maybe_turn`, `side`, `maybe_side`, `plain`, `outer`, `maybe`, `forgetful`, `point`, `triple`, `words`, `set` and 10 more)"
    );
    assert_eq!(
        told("a = 1"),
        "1: unknown key `a` in the file (hint: `a` belongs in `[forgetful]`: move it there, or put the missing header above it)"
    );
    assert_eq!(told("turn = { kind = \"curve\" }"), "8: `turn` lacks the key `radius` (hint: add `radius = …`: radius, m)");
    assert!(told("by_number = { x = 1 }").starts_with("15: "));
    assert!(told("by_number = { 300 = 1 }").starts_with("15: "));
}

#[test]
fn choices() {
    assert_eq!(told("side = \"lefft\""), "8: `side` can't be \"lefft\" (hint: did you mean `left`? Known are `left`, `right`)");
    assert_eq!(told("maybe_side = \"up\""), "14: `maybe_side` can't be \"up\" (hint: known are `left`, `right`)");
    assert_eq!(told("plain = \"three\""), "9: `plain` can't be \"three\" (hint: known are `one`, `two`)");
    assert_eq!(
        told("side = 1"),
        "8: `side` must be text in quotes, not a whole number (hint: choose one of `left`, `right`; the default is \"left\")"
    );
    assert!(
        told("turn = { kind = \"spott\" }")
            .starts_with("17: `kind` can't be \"spott\" (hint: did you mean `spot`? Known are `spot`, `curve`, `never`)")
    );
    assert!(
        told("turn = { rate_deg = 3 }")
            .starts_with("8: `turn` lacks the key `kind` (hint: add `kind = \"…\"`, one of `spot`, `curve`, `never`)")
    );
    assert!(told("turn = { kind = 3 }").starts_with("17: `kind` must be text in quotes"));
    assert!(told("turn = \"spot\"").starts_with("8: `turn` must be a table, not text"));
    assert!(told("maybe_turn = { kind = \"spot\", rate_deg = 0 }").starts_with("42: `rate_deg` = 0 is below the minimum of 1"));
    assert!(told("turn = { kind = \"never\", radius = 1 }").starts_with("26: unknown key `radius` in `turn`"));
    assert!(told("outer = \"distance\"").starts_with("9: "));
    assert!(told("outer = { dist = 1 }").starts_with("11: `outer` must have exactly one known key"));
    assert!(told("outer = { box = { width = 1 } }").starts_with("17: `outer.box` lacks the key `height`"));
    assert!(told("outer = { distance = 1, box = {} }").contains("unknown table `box`"));
    assert_eq!(
        told("ring = \"luey-6\""),
        "8: `ring` can't be \"luey-6\" (hint: did you mean `luey-8`? Known are `denning-16`, `luey-8`)"
    );
}

#[test]
fn lists_and_texts() {
    assert_eq!(told("point = [1]"), "9: `point` has 1 value, not exactly 2 (hint: give exactly 2; the default is [0, 0])");
    assert!(told("triple = [1, 2, 3, 4]").starts_with("10: `triple` has 4 values, not exactly 3"));
    assert!(told("point = [1, \"x\"]").starts_with("13: `point[1]` must be a number, not text"));
    assert!(told("set = [\"a\", \"b\", \"a\"]").starts_with("18: `set` holds \"a\" twice"));
    assert_eq!(told("short = \"\""), "9: `short` is empty (hint: give 1 to 4 characters; the default is \"abc\")");
    assert!(told("short = \"abcde\"").contains("has 5 characters, not 1 to 4"));
    assert!(told("letter = \"ab\"").contains("has 2 characters, not exactly 1"));
}

#[test]
fn values_that_contradict_each_other() {
    assert_eq!(
        told("own_ring.radius = 2\nring = \"luey-8\""),
        "1: `own_ring` stands beside `ring`, but takes its place (hint: remove `own_ring` or `ring`)"
    );
    assert!(try_read("own_ring.radius = 2").is_ok() && try_read("to = -3").is_ok());
    let hint = "(hint: give a number above `from`, or exchange the two)";
    assert_eq!(told("to = 1\nfrom = 2.5"), format!("6: `to` = 1 is not above `from` = 2.5 {hint}"));
    assert_eq!(told("to = 1\nfrom = 1"), format!("6: `to` = 1 is not above `from` = 1 {hint}"));
}

#[test]
fn all_problems_are_told_at_once() {
    let problems = try_read("speed = 9\nsped = 1\nflag = 3\n").unwrap_err();
    assert_eq!(problems.list().len(), 3);
}

#[test]
fn a_template_may_lack_keys() {
    let mut sources = Sources::embedded([("f".to_owned(), b"turn.kind = 'spot'\nmaybe_turn.rate_deg = 3".to_vec())]);
    let id = sources.read("f").unwrap();
    let section = Section::parse(&sources, id).unwrap();
    let schema = schema_of::<Everything>();
    let rules = Rules { schema: &schema, common: None, partial: true, name: "the file", names: &no_names, elsewhere: &|_| None };
    assert_eq!(check(&section, &rules, &sources), []);
}

/// Any value for any key.
fn values() -> impl Strategy<Value = toml::Value> {
    let leaf = prop_oneof![
        any::<bool>().prop_map(toml::Value::Boolean),
        prop_oneof![-3_i64..9, any::<i64>()].prop_map(toml::Value::Integer),
        prop_oneof![-1.0..4.0, any::<f64>()].prop_map(toml::Value::Float),
        prop_oneof!["left|right|one|two|spot|curve|never|nothing|box", ".{0,5}"].prop_map(toml::Value::String),
    ];
    leaf.prop_recursive(3, 12, 4, |inner| {
        let key = "kind|radius|rate_deg|width|height|box|distance|a|[0-9]{1,3}|[a-z]";
        prop_oneof![
            proptest::collection::vec(inner.clone(), 0..4).prop_map(toml::Value::Array),
            proptest::collection::btree_map(key, inner, 0..4).prop_map(|map| toml::Value::Table(map.into_iter().collect())),
        ]
    })
}

/// All keys of [`Everything`].
fn names() -> Vec<String> {
    let toml::Value::Table(table) = toml::Value::try_from(Everything::default()).unwrap() else { unreachable!() };
    let optional = ["maybe_turn", "maybe_side", "maybe", "ring"].map(str::to_owned);
    table.keys().cloned().chain(optional).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// serde alone, on plain data, is the oracle: what it refuses is refused, and what is accepted reads the same.
    #[test]
    fn checked_reading_agrees_with_serde(key in proptest::sample::select(names()), value in values()) {
        let text = toml::Table::from_iter([(key, value)]).to_string();
        let plain: Result<Everything, _> = toml::from_str(&text);
        match (try_read(&text), plain) {
            (Ok(checked), Ok(plain)) => prop_assert_eq!(checked, plain),
            (Ok(checked), Err(error)) => prop_assert!(false, "{text} was read as {checked:?}, but {error}"),
            (Err(problems), _) => {
                for problem in problems.list() {
                    prop_assert!(problem.location().is_some() && !problem.hint().is_empty(), "{problem}");
                }
            }
        }
    }
}
