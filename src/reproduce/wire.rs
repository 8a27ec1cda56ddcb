//! What a wire may bring: noise, damaged packets, and packets that make no sense, through everything that listens to one.
//!
//! The same bytes go to both ends of a protocol: to the framer with the parser of each packet behind it, to a client's session, and to
//! the emulator of its base. They are noise, frames that are whole but random within, and the words of a real conversation with some bytes
//! changed, lost or doubled.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    time::Duration,
};

use orienteer_hardware::{
    arcos::{Profile, Session},
    base::presets,
    emulator::{ArcosEmulator, Emulator, Make},
    wire::arcos::{
        command::{Argument, Code, Command},
        frame::{self, Framer, HEADER},
        greeting::{Greeting, emit_sync},
        information::{Information, SonarReading},
        settings::Settings,
        units::Units,
    },
};
use orienteer_runtime::{time::Time, topics::Odometry};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{Effort, Row, Suite, SuiteError, in_parallel};

pub(super) const SUITE: Suite =
    Suite { name: "wire", help: "noise and damaged packets through the parsers of real robots' languages, both ends", run };

/// Portions that make up a full run, of a million bytes each.
const PORTIONS: u64 = 100;
const PORTION: usize = 1_000_000;
/// How often, in a portion, good packets follow garbage.
const TRIALS: usize = 1000;
/// Good packets behind a piece of garbage: more than a frame that garbage pretends to begin could swallow.
const BEHIND: usize = 12;
/// The longest frame, bytes.
const LONGEST: f64 = 205.0;

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
    /// The base was told to move without a session.
    moved: u32,
}

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let portions = effort.seeds(PORTIONS);
    let seen = in_parallel(effort, "wire", portions, |seed| Ok(portion(seed)))?;
    let sum = |of: fn(&Seen) -> f64| seen.iter().map(of).sum::<f64>();
    let late = seen.iter().map(|seen| seen.late).max().unwrap_or(0);
    Ok(vec![
        Row::at_least(
            "ARCOS: random bytes through each parser",
            (portions as usize * PORTION) as f64,
            sum(|seen| seen.bytes as f64),
            "bytes",
        ),
        Row::at_least("ARCOS: whole frames among them", 1.0, sum(|seen| seen.frames as f64), "frames"),
        Row::exactly("ARCOS: panics", 0.0, sum(|seen| f64::from(seen.panics)), ""),
        Row::exactly("ARCOS: good packets lost after garbage", 0.0, sum(|seen| seen.lost as f64), "packets"),
        Row::at_most(
            "ARCOS: bytes until the first good packet behind garbage is out, beside its own",
            LONGEST,
            late as f64,
            "bytes",
        ),
        Row::exactly("ARCOS: portions of noise by which an emulated base is moved", 0.0, sum(|seen| f64::from(seen.moved)), ""),
    ])
}

fn portion(seed: u64) -> Seen {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut seen = Seen::default();
    let mut bytes = Vec::with_capacity(PORTION + 512);
    match seed % 3 {
        0 => bytes.extend((0..PORTION).map(|_| random.random::<u8>())),
        1 => frames(&mut random, &mut bytes),
        _ => damaged(&mut random, &mut bytes),
    }
    seen.bytes = bytes.len();
    match catch_unwind(AssertUnwindSafe(|| listen(&bytes, seed.is_multiple_of(3)))) {
        Ok((frames, moved)) => (seen.frames, seen.moved) = (frames, u32::from(moved)),
        Err(_) => seen.panics += 1,
    }
    match catch_unwind(AssertUnwindSafe(|| resume(&mut random))) {
        Ok((lost, late)) => (seen.lost, seen.late) = (lost, late),
        Err(_) => seen.panics += 1,
    }
    seen
}

/// Frames that are whole, with anything in them.
fn frames(random: &mut Pcg64, bytes: &mut Vec<u8>) {
    while bytes.len() < PORTION {
        let mut body = [0; frame::MOST];
        let length = random.random_range(0..frame::MOST);
        random.fill_bytes(&mut body[..length]);
        // Most kinds mean nothing; those that do shall come often.
        let kind = if random.random_bool(0.5) {
            random.random()
        } else {
            [0, 1, 2, 3, 11, 21, 0x20, 0x32, 0x33][random.random_range(0..9)]
        };
        frame::emit(kind, &body[..length], bytes);
    }
}

/// Both sides of a conversation, with a byte in fifty changed, lost or doubled.
fn damaged(random: &mut Pcg64, bytes: &mut Vec<u8>) {
    let mut whole = Vec::new();
    while bytes.len() < PORTION {
        whole.clear();
        word(random, &mut whole);
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

/// Something that either side may say.
fn word(random: &mut Pcg64, into: &mut Vec<u8>) {
    let number = random.random_range(-70_000..70_000);
    match random.random_range(0..6) {
        0 => emit_sync(random.random_range(0..3), into),
        1 => Greeting { name: "a".into(), class: "Pioneer".into(), model: "p3dx-sh".into() }.emit(into),
        2 => Settings { watchdog: random.random(), name: "b".into(), ..Settings::default() }.emit(into),
        3 => information(random).emit(into),
        4 => {
            let text: [u8; 16] = random.random();
            Command::new(Code::Polling, Argument::Text(&text)).emit(into);
        }
        _ => Command::new(Code::ALL[random.random_range(0..Code::ALL.len())], Argument::Integer(number)).emit(into),
    }
}

fn information(random: &mut Pcg64) -> Information {
    let count = random.random_range(0..8);
    let sonars = (0..count).map(|_| SonarReading { transducer: random.random(), range: random.random() }).collect();
    Information {
        x: random.random(),
        y: random.random(),
        heading: random.random(),
        flags: random.random(),
        sonars,
        ..Information::default()
    }
}

/// Everything that listens hears these bytes. Returns how many frames there were, and whether an emulated base has moved.
fn listen(bytes: &[u8], is_noise: bool) -> (u64, bool) {
    let mut framer = Framer::default();
    framer.push(bytes, |frame| {
        let _ = (Command::parse(frame).is_ok(), Information::parse(frame).is_ok());
        let _ = (Greeting::parse(frame).is_ok(), Settings::parse(frame).is_ok());
    });
    let profile =
        Profile { units: Units::of("p3dx"), acceleration: 0.3, angular_acceleration: 1.7, transducers: 16, max_range: 5.0 };
    let mut session = Session::new(profile);
    let mut emulator = emulator();
    let (mut now, mut sent, mut scans, mut moved) = (Time::START, Vec::new(), Vec::new(), false);
    for piece in bytes.chunks(97) {
        now = now + Duration::from_millis(10);
        session.receive(now, piece);
        session.transmit(now, &mut sent);
        if let Some(readings) = session.readings() {
            readings.fetch(&mut scans);
        }
        emulator.receive(now, piece);
        moved |= !emulator.drive(now, &Odometry::default()).is_stop();
        let _ = emulator.firing();
        emulator.transmit(now, &Odometry::default(), &mut sent);
        sent.clear();
        scans.clear();
    }
    // Frames without noise around them may say anything, that it is to move included.
    (framer.counts().frames, moved && is_noise)
}

fn emulator() -> ArcosEmulator {
    // Both names are built in.
    let (units, body) = (Units::of("p3dx-sh").unwrap_or(orienteer_hardware::wire::arcos::units::MODELS[0]), presets::p3dx());
    ArcosEmulator::new(Make::new(units, &body, 16))
}

/// Good packets behind garbage: how many never came out, and after how many bytes beside its own the first one did.
fn resume(random: &mut Pcg64) -> (usize, usize) {
    let (mut lost, mut late) = (0, 0);
    for trial in 0..TRIALS {
        let mut framer = Framer::default();
        let mut garbage: Vec<u8> = (0..random.random_range(0..300)).map(|_| random.random()).collect();
        if trial.is_multiple_of(2) {
            // As if a frame had begun just before the line broke.
            garbage.extend(HEADER);
            garbage.push(random.random());
        }
        framer.push(&garbage, |_| {});
        let packets: Vec<Information> = (0..BEHIND).map(|_| information(random)).collect();
        let (mut out, mut come, mut own) = (0, 0, 0);
        for packet in &packets {
            let mut bytes = Vec::new();
            packet.emit(&mut bytes);
            if come == 0 {
                own = bytes.len();
            }
            for byte in bytes {
                come += 1;
                let before = out;
                framer.push(&[byte], |frame| {
                    out += usize::from(Information::parse(frame).as_ref() == Ok(&packets[out.min(BEHIND - 1)]))
                });
                if before == 0 && out > 0 {
                    late = late.max(come - own);
                }
            }
        }
        lost += BEHIND - out;
    }
    (lost, late)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sort_of_bytes_is_survived() {
        for seed in 0..3 {
            let seen = portion(seed);
            assert!(seen.bytes >= PORTION && (seen.panics, seen.lost, seen.moved) == (0, 0, 0), "{seed}");
            assert!(seed == 0 || seen.frames > 1000, "{seed}: {}", seen.frames);
        }
    }
}
