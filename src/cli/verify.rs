//! `orienteer verify`: is a recording what its configuration and seed give?

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

use crate::{
    Registry,
    mission::{self, Loaded, Recording, RunOptions},
    runtime::{
        clock::Pace,
        config::mission::ClockKind,
        fleet::Ended,
        recording::{Difference, Ending, Reader},
        time::Time,
    },
};
use sha2::{Digest, Sha256};

use super::{
    Outcome, Refusal, VerifyArguments,
    progress::MissionWatch,
    style::{self, Paint},
};

/// The version of this program, as recordings name it.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Runs a recorded mission again and compares the recordings byte for byte.
pub fn verify(arguments: &VerifyArguments, registry: &Registry) -> Result<Outcome, Refusal> {
    let reader = Reader::open(&arguments.recording)?;
    let hash = hash(&arguments.recording)?;
    let again = Repetition { reader: &reader, arguments, registry };
    let whole = *reader.ending() == Ending::Complete;
    if whole {
        let outcome = again.run(Recording::HashOnly)?;
        if interrupted(&outcome, &reader) {
            return Ok(stopped());
        }
        if outcome.recording.as_ref().is_some_and(|summary| summary.sha256 == hash) {
            style::print(&identical(arguments, &outcome, &hash))?;
            return Ok(Outcome::Well);
        }
    }
    // Now it matters where they part, so the repetition is needed as a whole.
    let draft = tempfile::Builder::new().prefix("orienteer-verify-").suffix(".mcap").tempfile().map_err(no_draft)?;
    let outcome = again.run(Recording::File(draft.path().to_owned()))?;
    if interrupted(&outcome, &reader) {
        return Ok(stopped());
    }
    if let Some(failure) = outcome.failures.first() {
        return Err(Refusal::failed(
            failure,
            "the repetition needs as much room as the recording; set `TMPDIR` to where there is some",
        ));
    }
    let difference = reader.first_difference(&Reader::open(draft.path())?)?;
    style::print(&different(arguments, &reader, difference.as_ref()))?;
    Ok(Outcome::FallsShort)
}

/// Runs the mission of a recording again.
struct Repetition<'a> {
    reader: &'a Reader,
    arguments: &'a VerifyArguments,
    registry: &'a Registry,
}

impl Repetition<'_> {
    fn run(&self, record: Recording) -> Result<mission::Outcome, Refusal> {
        let loaded = load(self.reader, self.registry)?;
        if loaded.mission.settings.clock == ClockKind::Wall {
            let hint = "only missions with `clock = \"lockstep\"` give the same recording each time";
            return Err(Refusal::misused("this mission ran in real time, which never passes the same way twice", hint));
        }
        let recorded = self.reader.mission();
        let end = self.reader.end_time();
        let (bar, watch) = MissionWatch::new("verify", end);
        let options = RunOptions {
            pace: Some(Pace::AsFastAsPossible),
            duration: Some(recorded.duration),
            seed: Some(recorded.seed),
            threads: self.arguments.threads.map(usize::from),
            record,
            // A mission that was stopped early is not expected to go on.
            observer: Some(Box::new(watch.until(end))),
            ..RunOptions::default()
        };
        let outcome = mission::run(loaded, self.registry, options);
        drop(bar);
        Ok(outcome?)
    }
}

/// Opens a recording to look into it, and tells if it is not whole.
pub fn open(path: &Path) -> Result<Reader, Refusal> {
    let reader = Reader::open(path)?;
    if *reader.ending() != Ending::Complete {
        let until = style::time(reader.end_time());
        tracing::warn!("the recording is {}: what is shown is what is left, up to {until}", reader.ending());
    }
    Ok(reader)
}

/// The mission that a recording carries.
pub fn load(reader: &Reader, registry: &Registry) -> Result<Loaded, Refusal> {
    let sources = reader.sources().and_then(|sources| Some((sources, sources.first()?)));
    let Some((sources, main)) = sources else {
        let hint = "it can't be run again; record the mission again";
        return Err(Refusal::failed("the recording was cut off before all of its configuration was written", hint));
    };
    let version = &reader.mission().version;
    if version != VERSION {
        tracing::warn!("the recording was made by version {version}, this is {VERSION}: expect differences");
    }
    let files = sources.iter().map(|source| (source.name.clone(), source.bytes.clone()));
    let mut loaded = mission::load_files(files, &main.name, registry)?;
    // The recorded mission may still be running under its name.
    loaded.mission.settings.run = None;
    Ok(loaded)
}

/// True if Ctrl-C ended the repetition before the recording's end.
fn interrupted(outcome: &mission::Outcome, reader: &Reader) -> bool {
    outcome.ended == Ended::Stopped && outcome.time < reader.end_time()
}

fn stopped() -> Outcome {
    style::complain_of("stopped before the recordings could be compared");
    Outcome::Interrupted
}

fn identical(arguments: &VerifyArguments, outcome: &mission::Outcome, hash: &str) -> String {
    let paint = Paint::stdout();
    let path = arguments.recording.display();
    let time = style::time(outcome.time);
    format!(
        "{} {path}\n{time} run again from the configuration inside, seed {}, in {:.1} s; every byte is the same\n{} {hash}\n",
        paint.good("identical"),
        outcome.seed,
        outcome.elapsed.as_secs_f64(),
        paint.bold("sha256"),
    )
}

fn different(arguments: &VerifyArguments, reader: &Reader, difference: Option<&Difference>) -> String {
    let paint = Paint::stdout();
    let path = arguments.recording.display();
    let end = style::time(reader.end_time());
    let cut = *reader.ending() != Ending::Complete;
    // What a file that was cut off lacks is no news.
    let parted = difference.filter(|difference| !(cut && difference.here.is_none()));
    let (verdict, mut remark) = match parted {
        Some(difference) => ("different", format!("first at {}: {}", style::time(difference.time), telling(difference))),
        None if cut && reader.end_time() == Time::START => ("incomplete", "nothing is left of its messages".to_owned()),
        None if cut => ("incomplete", format!("all that is left, up to {end}, is the same as in a new run")),
        None => {
            let remark =
                "all messages are the same, but not the bytes around them: the file was written by another program, or changed";
            ("different", remark.to_owned())
        }
    };
    if cut {
        remark = format!("it is {}; {remark}", reader.ending());
    }
    format!("{} {path}\n{}\n", paint.bad(verdict), style::wrap(&remark, 0))
}

fn telling(difference: &Difference) -> String {
    match (&difference.here, &difference.there) {
        (Some(here), Some(there)) if here == there => format!("a message of `{here}` says something else in a new run"),
        (Some(here), Some(there)) => format!("it has a message of `{here}` where a new run has one of `{there}`"),
        (Some(here), None) => format!("it goes on with `{here}` where a new run has ended"),
        (None, Some(there)) => format!("it has ended where a new run goes on with `{there}`"),
        (None, None) => "both end".to_owned(),
    }
}

fn hash(path: &Path) -> Result<String, Refusal> {
    let sum = || -> io::Result<String> {
        let (mut hash, mut file, mut part) = (Sha256::new(), File::open(path)?, vec![0; 1 << 16]);
        loop {
            match file.read(&mut part)? {
                0 => break,
                length => hash.update(&part[..length]),
            }
        }
        Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
    };
    sum().map_err(|error| {
        Refusal::failed(
            format!("cannot read the recording `{}`: {error}", path.display()),
            "check the file's permissions and the disk",
        )
    })
}

fn no_draft(error: io::Error) -> Refusal {
    Refusal::failed(format!("there is no room for the repetition: {error}"), "set `TMPDIR` to a directory that can be written to")
}
