//! What a wire may bring: noise, damaged packets, and packets that make no sense, through everything that listens to one.
//!
//! The same bytes go to both ends of a protocol: to the framer with the parser of each packet behind it, to a client's session, and to
//! the emulator of its base. They are noise, frames that are whole but random within, and the words of a real conversation with some bytes
//! changed, lost or doubled.

mod arcos;
mod oi;

use std::panic::{AssertUnwindSafe, catch_unwind};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{Effort, Row, Suite, SuiteError, in_parallel};
use arcos::Arcos;
use oi::OpenInterface;

pub(super) const SUITE: Suite =
    Suite { name: "wire", help: "noise and damaged packets through the parsers of real robots' languages, both ends", run };

/// Portions that make up a full run, of a million bytes each.
const PORTIONS: u64 = 100;
const PORTION: usize = 1_000_000;
/// How often, in a portion, good packets follow garbage.
const TRIALS: usize = 1000;
/// Good packets behind a piece of garbage: more than a frame that garbage pretends to begin could swallow.
const BEHIND: usize = 12;

/// A language and both of its ends.
trait Language {
    const NAME: &'static str;
    /// The longest frame, bytes.
    const LONGEST: f64;
    /// What no bytes may bring about.
    const MOVED: &'static str;

    /// Appends a portion of frames that are whole, with anything in them.
    fn frames(random: &mut Pcg64, bytes: &mut Vec<u8>);

    /// Appends something that either side may say.
    fn word(random: &mut Pcg64, into: &mut Vec<u8>);

    /// Everything that listens hears these bytes. Returns how many frames there were, and whether that came about which may not.
    fn listen(bytes: &[u8], portion: Portion) -> (u64, bool);

    /// Good packets behind garbage, at whose end a frame may be torn: how many never came out, and after how many bytes beside its own
    /// the first one did.
    fn resume(random: &mut Pcg64, torn: bool) -> (usize, usize);
}

/// What a portion is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Portion {
    Noise,
    Frames,
    Damaged,
}

/// What came of one portion.
#[derive(Default)]
struct Seen {
    bytes: usize,
    frames: u64,
    panics: u32,
    /// Good packets that never came out.
    lost: usize,
    /// The most bytes that came in before the first good packet behind garbage came out, from its own end on.
    late: usize,
    /// What may not come about did.
    moved: u32,
}

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    Ok([rows::<Arcos>(effort)?, rows::<OpenInterface>(effort)?].concat())
}

fn rows<L: Language>(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let portions = effort.seeds(PORTIONS);
    let seen = in_parallel(effort, "wire", portions, |seed| Ok(portion::<L>(seed)))?;
    let sum = |of: fn(&Seen) -> f64| seen.iter().map(of).sum::<f64>();
    let late = seen.iter().map(|seen| seen.late).max().unwrap_or(0);
    let name = |what: &str| format!("{}: {what}", L::NAME);
    Ok(vec![
        Row::at_least(
            name("random bytes through each parser"),
            (portions as usize * PORTION) as f64,
            sum(|seen| seen.bytes as f64),
            "bytes",
        ),
        Row::at_least(name("whole frames among them"), 1.0, sum(|seen| seen.frames as f64), "frames"),
        Row::exactly(name("panics"), 0.0, sum(|seen| f64::from(seen.panics)), ""),
        Row::exactly(name("good packets lost after garbage"), 0.0, sum(|seen| seen.lost as f64), "packets"),
        Row::at_most(
            name("bytes until the first good packet behind garbage is out, beside its own"),
            L::LONGEST,
            late as f64,
            "bytes",
        ),
        Row::exactly(name(L::MOVED), 0.0, sum(|seen| f64::from(seen.moved)), ""),
    ])
}

fn portion<L: Language>(seed: u64) -> Seen {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut seen = Seen::default();
    let mut bytes = Vec::with_capacity(PORTION + 512);
    let sort = [Portion::Noise, Portion::Frames, Portion::Damaged][(seed % 3) as usize];
    match sort {
        Portion::Noise => bytes.extend((0..PORTION).map(|_| random.random::<u8>())),
        Portion::Frames => L::frames(&mut random, &mut bytes),
        Portion::Damaged => damaged::<L>(&mut random, &mut bytes),
    }
    seen.bytes = bytes.len();
    match catch_unwind(AssertUnwindSafe(|| L::listen(&bytes, sort))) {
        Ok((frames, moved)) => (seen.frames, seen.moved) = (frames, u32::from(moved)),
        Err(_) => seen.panics += 1,
    }
    for trial in 0..TRIALS {
        match catch_unwind(AssertUnwindSafe(|| L::resume(&mut random, trial.is_multiple_of(2)))) {
            Ok((lost, late)) => (seen.lost, seen.late) = (seen.lost + lost, seen.late.max(late)),
            Err(_) => seen.panics += 1,
        }
    }
    seen
}

/// Both sides of a conversation, with a byte in fifty changed, lost or doubled.
fn damaged<L: Language>(random: &mut Pcg64, bytes: &mut Vec<u8>) {
    let mut whole = Vec::new();
    while bytes.len() < PORTION {
        whole.clear();
        L::word(random, &mut whole);
        for byte in &whole {
            match random.random_range(0..150) {
                0 => bytes.push(random.random()),
                1 => {}
                2 => bytes.extend([*byte, *byte]),
                _ => bytes.push(*byte),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn each_sort_of_bytes_is_survived<L: Language>() {
        for seed in 0..3 {
            let seen = portion::<L>(seed);
            let wrong = (seen.panics, seen.lost, seen.moved);
            assert!(seen.bytes >= PORTION && wrong == (0, 0, 0), "{}, {seed}: {wrong:?}", L::NAME);
            assert!(seed == 0 || seen.frames > 1000, "{}, {seed}: {}", L::NAME, seen.frames);
        }
    }

    #[test]
    fn arcos_survives_each_sort_of_bytes() {
        each_sort_of_bytes_is_survived::<Arcos>();
    }

    #[test]
    fn oi_survives_each_sort_of_bytes() {
        each_sort_of_bytes_is_survived::<OpenInterface>();
    }
}
