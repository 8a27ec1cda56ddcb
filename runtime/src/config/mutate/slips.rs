//! The slips themselves.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::keys;
use crate::config::{
    document::{Data, Section, Table},
    source::{Sources, Span},
};

/// What sort of slip it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Slip {
    CharacterReplaced,
    CharacterInserted,
    CharacterDeleted,
    CharactersSwapped,
    KeyRenamed,
    KeyMistyped,
    ValueReplaced,
    HeaderLost,
    HeaderChanged,
    LineDoubled,
    LineLost,
    LinesSwapped,
}

/// One changed file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mutation {
    /// What was done.
    pub slip: Slip,
    /// The whole text after it.
    pub text: String,
}

const SLIPS: [Slip; 12] = [
    Slip::CharacterReplaced,
    Slip::CharacterInserted,
    Slip::CharacterDeleted,
    Slip::CharactersSwapped,
    Slip::KeyRenamed,
    Slip::KeyMistyped,
    Slip::ValueReplaced,
    Slip::HeaderLost,
    Slip::HeaderChanged,
    Slip::LineDoubled,
    Slip::LineLost,
    Slip::LinesSwapped,
];

/// Characters that fingers find, or that copying from elsewhere brings.
const CHARACTERS: &[char] = &[
    'a', 'e', 's', 'z', 'A', '0', '1', '9', ' ', '\t', '\n', '\r', '.', ',', ':', ';', '=', '-', '_', '+', '#', '"', '\'', '\\',
    '[', ']', '{', '}', '(', '/', '\u{0}', '\u{7f}', '\u{a0}', 'é', '°', '\u{feff}', '\u{202e}', '🤖',
];

/// Values of other types, and extreme ones.
const VALUES: &[&str] = &[
    "0",
    "1",
    "-1",
    "2",
    "0.5",
    "-0.0",
    "1e308",
    "1e400",
    "-1e400",
    "5e-324",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "999999999999999999999999999999999999999999999999",
    "0xffff",
    "1_000",
    "\"\"",
    "\" \"",
    "\"x\"",
    "'sim'",
    "\"\\u0000\"",
    "\"../../../etc/passwd\"",
    "\"é\"",
    "true",
    "false",
    "[]",
    "[[]]",
    "[1, 2]",
    "[nan]",
    "{}",
    "{ x = 1 }",
    "[{}]",
    "{ kind = \"x\" }",
    "1979-05-27",
    "07:32:00",
    "",
];

/// Deterministic single mutations of a valid text, all sorts in turn. None equals the text itself.
pub fn mutations(text: &str, seed: u64) -> impl Iterator<Item = Mutation> + use<> {
    let mut dice = Pcg64::seed_from_u64(seed);
    let places = Places::of(text);
    let text = text.to_owned();
    let mut turn = 0;
    // A text without keys or headers has no room for some slips: give up after many turns without one.
    std::iter::from_fn(move || {
        for _ in 0..10_000 {
            turn += 1;
            let slip = SLIPS[turn % SLIPS.len()];
            if let Some(changed) = apply(slip, &text, &places, &mut dice).filter(|changed| *changed != text) {
                return Some(Mutation { slip, text: changed });
            }
        }
        None
    })
}

/// Where in the text things are.
struct Places {
    characters: Vec<usize>,
    keys: Vec<(String, Span)>,
    values: Vec<Span>,
    lines: Vec<Span>,
    headers: Vec<Span>,
}

impl Places {
    fn of(text: &str) -> Self {
        let mut lines = Vec::new();
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            lines.push(start..start + line.len());
            start += line.len();
        }
        let headers = lines.iter().filter(|line| text[(*line).clone()].starts_with('[')).cloned().collect();
        let characters = text.char_indices().map(|(at, _)| at).collect();
        Self { characters, keys: keys(text), values: values(text), lines, headers }
    }
}

fn apply(slip: Slip, text: &str, places: &Places, dice: &mut Pcg64) -> Option<String> {
    let replaced = |span: &Span, by: &str| format!("{}{by}{}", &text[..span.start], &text[span.end..]);
    let width = |at: usize| text[at..].chars().next().map_or(0, char::len_utf8);
    match slip {
        Slip::CharacterReplaced | Slip::CharacterInserted => {
            let at = *pick(&places.characters, dice)?;
            let end = if slip == Slip::CharacterReplaced { at + width(at) } else { at };
            let mut buffer = [0; 4];
            Some(replaced(&(at..end), pick(CHARACTERS, dice)?.encode_utf8(&mut buffer)))
        }
        Slip::CharacterDeleted => pick(&places.characters, dice).map(|at| replaced(&(*at..at + width(*at)), "")),
        Slip::CharactersSwapped => {
            let at = *pick(&places.characters, dice)?;
            let next = at + width(at);
            let end = next + text.get(next..).map_or(0, |rest| rest.chars().next().map_or(0, char::len_utf8));
            Some(replaced(&(at..end), &format!("{}{}", &text[next..end], &text[at..next])))
        }
        Slip::KeyRenamed => {
            let (_, span) = pick(&places.keys, dice)?;
            let (other, _) = pick(&places.keys, dice)?;
            Some(replaced(span, other.rsplit('.').next()?))
        }
        Slip::KeyMistyped => {
            let (_, span) = pick(&places.keys, dice)?;
            let at = dice.random_range(span.start..span.end);
            let at = text.floor_char_boundary(at);
            Some(replaced(&(at..at), pick(&["x", "e", "-", "_", "2"], dice)?))
        }
        Slip::ValueReplaced => {
            let span = pick(&places.values, dice)?;
            // Often another value of the same file: of the right type, in the wrong place.
            let by = if dice.random_range(0..4) == 0 { &text[pick(&places.values, dice)?.clone()] } else { pick(VALUES, dice)? };
            Some(replaced(span, by))
        }
        Slip::HeaderLost => pick(&places.headers, dice).map(|span| replaced(span, "")),
        Slip::HeaderChanged => {
            let span = pick(&places.headers, dice)?;
            let header = &text[span.clone()];
            let changed = match dice.random_range(0..4) {
                0 => header.replace("[[", "[").replace("]]", "]"),
                1 => format!("[{}]\n", header.trim()),
                2 => header.replacen('.', "", 1),
                _ => text[pick(&places.headers, dice)?.clone()].to_owned(),
            };
            Some(replaced(span, &changed))
        }
        Slip::LineDoubled => pick(&places.lines, dice).map(|span| replaced(span, &text[span.clone()].repeat(2))),
        Slip::LineLost => pick(&places.lines, dice).map(|span| replaced(span, "")),
        Slip::LinesSwapped => {
            let index = dice.random_range(0..places.lines.len().max(1));
            let (one, two) = (places.lines.get(index)?, places.lines.get(index + 1)?);
            Some(replaced(&(one.start..two.end), &format!("{}{}", &text[two.clone()], &text[one.clone()])))
        }
    }
}

fn pick<'a, T>(list: &'a [T], dice: &mut Pcg64) -> Option<&'a T> {
    if list.is_empty() { None } else { list.get(dice.random_range(0..list.len())) }
}

/// The places of all values that stand in one piece.
fn values(text: &str) -> Vec<Span> {
    let mut sources = Sources::embedded([("text".to_owned(), text.into())]);
    let parsed = sources.read("text").map(|id| (Section::parse(&sources, id), sources.start(id)));
    let mut found = Vec::new();
    if let Ok((Ok(section), start)) = parsed {
        gather(section.table(), text, start, &mut found);
    }
    found
}

fn gather(table: &Table, text: &str, start: usize, found: &mut Vec<Span>) {
    for value in table.values() {
        let span = value.span().start - start..value.span().end - start;
        match value.get_ref() {
            Data::Table(table) => {
                if text[span.clone()].starts_with('{') {
                    found.push(span);
                }
                gather(table, text, start, found);
            }
            Data::List(values) => {
                if !text[span.clone()].starts_with("[[") {
                    found.push(span);
                }
                for table in values.iter().filter_map(|value| value.get_ref().as_table()) {
                    gather(table, text, start, found);
                }
            }
            _ => found.push(span),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    const TEXT: &str = "# é\n[a]\nx = 1\ns = \"ü\"\n\n[[b]]\nt = { u = [1, 2] }\n[[b]]\n[b.c]\nv = 2.5\n";

    #[test]
    fn the_same_seed_makes_the_same_slips_and_all_sorts_of_them() {
        let made: Vec<Mutation> = mutations(TEXT, 1).take(500).collect();
        assert_eq!(made, mutations(TEXT, 1).take(500).collect::<Vec<_>>());
        assert_ne!(made, mutations(TEXT, 2).take(500).collect::<Vec<_>>());
        assert_eq!(made.iter().map(|mutation| mutation.slip).collect::<BTreeSet<_>>().len(), SLIPS.len());
        assert!(made.iter().all(|mutation| mutation.text != TEXT));
    }

    #[test]
    fn a_text_without_room_for_slips_ends() {
        assert_eq!(mutations("", 1).count(), 0);
        assert!(mutations("# only a comment", 1).take(50).count() == 50);
    }
}
