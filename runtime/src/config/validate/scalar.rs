//! Types, numbers and text.

use serde_json::Value as Json;

use super::{At, Validator, view::View, words};
use crate::config::{document::Data, suggest};

impl<'a> Validator<'a> {
    /// Reports a value of the wrong type.
    pub(super) fn fits_type(&mut self, at: &At, value: &Data, view: &View<'a>) -> bool {
        let types = types_of(view);
        let fits = |name: &&str| match value {
            Data::Text(_) => *name == "string",
            Data::Whole(_) => matches!(*name, "integer" | "number"),
            Data::Number(_) => *name == "number",
            Data::Flag(_) => *name == "boolean",
            Data::Date(_) => false,
            Data::List(_) => *name == "array",
            Data::Table(_) => *name == "object",
        };
        if types.iter().any(fits) || (types.is_empty() && !matches!(value, Data::Date(_))) {
            return true;
        }
        let wanted =
            if types.is_empty() { "text in quotes, a number, a list or a table".to_owned() } else { words::wanted(&types) };
        let found = words::sort_of(value);
        let message = format!("{} must be {wanted}, not {found}", at.quoted());
        let hint = words::hint(self.repair(at, value, &types).unwrap_or_else(|| format!("give {wanted}")), view);
        self.report(at, message, hint, Some(format!("this is {found}")));
        false
    }

    /// What a person who wrote this probably wanted to write.
    fn repair(&self, at: &At, value: &Data, types: &[&str]) -> Option<String> {
        let key = &at.name;
        match (value, types.first().copied()?) {
            (Data::Text(text), "number" | "integer") if text.trim().parse::<f64>().is_ok() => {
                Some(format!("remove the quotes: `{key} = {}`", text.trim()))
            }
            (Data::Text(text), "number" | "integer") => {
                let digits: String = text.trim().chars().take_while(|c| c.is_ascii_digit() || ".+-".contains(*c)).collect();
                digits
                    .parse::<f64>()
                    .is_ok()
                    .then(|| format!("write the bare number, in the unit of the key: `{key} = {digits}`"))
            }
            (Data::Text(text), "boolean") => match text.to_lowercase().as_str() {
                "true" | "yes" | "on" => Some(format!("remove the quotes: `{key} = true`")),
                "false" | "no" | "off" => Some(format!("remove the quotes: `{key} = false`")),
                _ => None,
            },
            (Data::Whole(_), "boolean") => Some("write `true` or `false`".to_owned()),
            (Data::Number(number), "integer") => {
                number.is_finite().then(|| format!("write a number without a point, such as `{key} = {}`", number.round()))
            }
            (Data::Whole(_) | Data::Number(_) | Data::Flag(_), "string") => {
                Some(format!("put it in quotes: `{key} = \"{}\"`", words::shown(value)))
            }
            (Data::Text(_) | Data::Whole(_) | Data::Number(_), "array") => {
                Some(format!("put it in brackets: `{key} = [{}]`", words::shown(value)))
            }
            (Data::List(values), _) if values.len() == 1 && types != ["object"] => {
                values.first().map(|only| format!("remove the brackets: `{key} = {}`", words::shown(only.get_ref())))
            }
            (Data::List(values), "object") if values.iter().all(|value| value.get_ref().as_table().is_some()) => {
                Some(format!("write one table `[{key}]`, not a list of tables `[[{key}]]`"))
            }
            (Data::Table(_), "array") => Some(format!("write a list of tables: `[[{key}]]`")),
            _ => None,
        }
    }

    /// Range, size of the type, and numbers that are none.
    pub(super) fn number(&mut self, at: &At, value: &Data, view: &View<'a>) {
        let (exact, number) = match value {
            Data::Whole(number) => (Some(*number), *number as f64),
            Data::Number(number) => (None, *number),
            _ => return,
        };
        let shown = words::shown(value);
        let limits = Limits::of(view);
        let infinite = view.keyword("x-non-finite") == Some(&Json::Bool(true));
        if number.is_nan() || (number.is_infinite() && !infinite) {
            let message = match number.is_nan() {
                true => format!("{} is not a usable number", at.quoted()),
                false => format!("{} can't be infinite", at.quoted()),
            };
            let hint = words::hint(limits.told().unwrap_or_else(|| "give an ordinary number".to_owned()), view);
            return self.report(at, message, hint, None);
        }
        let Some((relation, limit)) = limits.broken_by(number, exact) else { return };
        let hint = words::hint(limits.told().unwrap_or_else(|| "give an ordinary number".to_owned()), view);
        let message = format!("{} = {shown} is {relation} {limit}", at.quoted());
        self.report(at, message, hint, None);
    }

    pub(super) fn text(&mut self, at: &At, text: &str, view: &View<'a>) {
        let allowed: Vec<&str> = constants(view);
        if !allowed.is_empty() && !allowed.contains(&text) {
            return self.unknown_name(at, text, &allowed);
        }
        if let Some(sort) = view.keyword("x-names").and_then(Json::as_str) {
            let names = (self.rules.names)(sort);
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            // Without a catalogue the names are for whoever has one to check.
            if !names.is_empty() && !names.contains(&text) {
                return self.unknown_name(at, text, &names);
            }
        }
        let least = view.keyword("minLength").and_then(Json::as_u64).unwrap_or(0);
        let most = view.keyword("maxLength").and_then(Json::as_u64).unwrap_or(u64::MAX);
        let count = text.chars().count() as u64;
        if count < least || count > most {
            let wanted = words::count(least, most);
            let message = match count {
                0 => format!("{} is empty", at.quoted()),
                count => format!("{} has {}, not {wanted}", at.quoted(), words::counted(count, "character")),
            };
            self.report(at, message, words::hint(format!("give {wanted} characters"), view), None);
        }
    }

    /// A text that is none of a fixed set.
    pub(super) fn unknown_name(&mut self, at: &At, text: &str, allowed: &[&str]) {
        let list = suggest::list(allowed.iter().copied());
        let what = match suggest::nearest(text, allowed.iter().copied()) {
            Some(near) if allowed.len() > 1 => format!("did you mean `{near}`? Known are {list}"),
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("known are {list}"),
        };
        let message = format!("{} can't be {}", at.quoted(), words::shown(&Data::Text(text.to_owned())));
        self.report(at, message, what, None);
    }
}

/// The types a schema names, without `null`.
fn types_of<'a>(view: &View<'a>) -> Vec<&'a str> {
    let types: Vec<&str> = match view.keyword("type") {
        Some(Json::String(one)) => vec![one],
        Some(Json::Array(several)) => several.iter().filter_map(Json::as_str).collect(),
        _ if view.keyword("properties").is_some() => vec!["object"],
        _ if !constants(view).is_empty() => vec!["string"],
        _ => Vec::new(),
    };
    types.into_iter().filter(|name| *name != "null").collect()
}

/// The texts that `enum` and `const` allow.
pub(super) fn constants<'a>(view: &View<'a>) -> Vec<&'a str> {
    let several = view.keyword("enum").and_then(Json::as_array).into_iter().flatten();
    several.chain(view.keyword("const")).filter_map(Json::as_str).collect()
}

/// The allowed range of a number.
struct Limits {
    least: Option<f64>,
    most: Option<f64>,
    above: Option<f64>,
    below: Option<f64>,
    /// The range of the Rust type, where it is exact.
    whole: Option<(i128, i128)>,
}

impl Limits {
    fn of(view: &View<'_>) -> Self {
        let number = |name: &str| view.keyword(name).and_then(Json::as_f64);
        let whole = match view.keyword("format").and_then(Json::as_str) {
            Some("int8") => Some((i8::MIN.into(), i8::MAX.into())),
            Some("uint8") => Some((0, u8::MAX.into())),
            Some("int16") => Some((i16::MIN.into(), i16::MAX.into())),
            Some("uint16") => Some((0, u16::MAX.into())),
            Some("int32") => Some((i32::MIN.into(), i32::MAX.into())),
            Some("uint32") => Some((0, u32::MAX.into())),
            Some("int64" | "int") => Some((i64::MIN.into(), i64::MAX.into())),
            Some("uint64" | "uint") => Some((0, u64::MAX.into())),
            _ => None,
        };
        let single = view.keyword("format") == Some(&Json::from("float"));
        let size = single.then_some(f64::from(f32::MAX));
        Self {
            least: number("minimum").or(size.map(|size| -size)),
            most: number("maximum").or(size),
            above: number("exclusiveMinimum"),
            below: number("exclusiveMaximum"),
            whole,
        }
    }

    /// How a number lies outside, and which limit it breaks.
    fn broken_by(&self, number: f64, exact: Option<i128>) -> Option<(&'static str, String)> {
        let least = self.least.filter(|least| number < *least).map(|least| ("below the minimum of", least));
        let most = self.most.filter(|most| number > *most).map(|most| ("above the maximum of", most));
        let above = self.above.filter(|above| number <= *above).map(|above| ("not above", above));
        let below = self.below.filter(|below| number >= *below).map(|below| ("not below", below));
        let broken = [least, most, above, below].into_iter().flatten().next();
        if let Some((relation, limit)) = broken {
            return Some((relation, words::number_shown(limit)));
        }
        let ((lowest, highest), exact) = (self.whole?, exact?);
        if exact < lowest {
            return Some(("below the minimum of", lowest.to_string()));
        }
        (exact > highest).then(|| ("above the maximum of", highest.to_string()))
    }

    /// The range in words.
    fn told(&self) -> Option<String> {
        let real = |limit: &f64| limit.abs() < f64::from(f32::MAX);
        let low = self.least.filter(real).map(words::number_shown).or(self.whole.map(|(low, _)| low.to_string()));
        let high = self.most.filter(real).map(words::number_shown).or(self.whole.map(|(_, high)| high.to_string()));
        let above = self.above.map(|above| format!("above {}", words::number_shown(above)));
        let below = self.below.map(|below| format!("below {}", words::number_shown(below)));
        match (low, high, above, below) {
            (_, None, Some(above), None) => Some(format!("allowed is anything {above}")),
            (_, Some(high), Some(above), None) => Some(format!("allowed is anything {above}, up to {high}")),
            (_, _, Some(above), Some(below)) => Some(format!("allowed is anything {above} and {below}")),
            (Some(low), _, None, Some(below)) => Some(format!("allowed is {low} or more, {below}")),
            (None, _, None, Some(below)) => Some(format!("allowed is anything {below}")),
            (Some(low), Some(high), ..) => Some(format!("allowed is {low} to {high}")),
            (Some(low), None, ..) => Some(format!("allowed is {low} or more")),
            (None, Some(high), ..) => Some(format!("allowed is {high} or less")),
            (None, None, None, None) => None,
        }
    }
}
