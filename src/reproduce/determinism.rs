//! The same configuration and seed give the same recording, byte for byte.

use std::{
    path::PathBuf,
    process,
    sync::atomic::{AtomicU64, Ordering},
    time::Duration,
};

use orienteer_runtime::{link::Backend, recording::Reader};

use super::{Effort, Row, Suite, SuiteError, in_parallel};
use crate::{
    Registry,
    mission::{self, Loaded, Outcome, Recording, RunOptions},
};

pub(super) const SUITE: Suite = Suite {
    name: "determinism",
    help: "eight robots for five minutes: one recording on any number of threads, on any links, and when run again",
    run,
};

/// The mission; its world is built in.
const MISSION: &str = include_str!("determinism/eight.toml");
const MISSION_FILE: &str = "eight.toml";
/// How long the robots drive, simulated seconds.
const DURATION: f64 = 300.0;
const QUICK_DURATION: f64 = 30.0;
/// A seed that none of the others is.
const ANOTHER: u64 = 1 << 40;

/// One way of running the mission, and what it must give.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    /// On so many threads, with these links.
    With(usize, Backend),
    /// With another seed.
    OtherSeed,
    /// Recorded into a file, and run again from what the file says of itself.
    Replayed,
}

const REFERENCE: Way = Way::With(1, Backend::Direct);

const WAYS: [(Way, &str); 8] = [
    (REFERENCE, "a second time in one process"),
    (Way::With(2, Backend::Direct), "on 2 threads"),
    (Way::With(8, Backend::Direct), "on 8 threads"),
    (Way::With(1, Backend::Local), "with `local` links"),
    (Way::With(1, Backend::Shared), "with `shared` links"),
    (Way::With(8, Backend::Shared), "on 8 threads with `shared` links"),
    (Way::Replayed, "from the files inside the recording"),
    (Way::OtherSeed, "with another seed"),
];

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let seeds = effort.seeds(1);
    let duration = if effort.quick { QUICK_DURATION } else { DURATION };
    let bench = Bench { registry: Registry::standard(), duration };
    let references = in_parallel(effort, "determinism: reference", seeds, |seed| bench.hash(REFERENCE, 1 + seed))?;
    let ways = WAYS.len() as u64;
    let hashes = in_parallel(effort, "determinism", ways * seeds, |job| {
        let (way, seed) = (WAYS[(job % ways) as usize].0, 1 + job / ways);
        bench.hash(way, seed)
    })?;
    let mut rows = Vec::new();
    for (i, (way, words)) in WAYS.into_iter().enumerate() {
        let found = hashes.iter().skip(i).step_by(WAYS.len());
        let pairs = references.iter().zip(found).zip(1..);
        let mut different = 0;
        for ((reference, hash), seed) in pairs {
            if hash != reference {
                different += 1;
                if way != Way::OtherSeed {
                    bench.explain(way, seed);
                }
            }
        }
        let row = format!("recordings of {duration} s that differ: {words}");
        let expected = if way == Way::OtherSeed { seeds } else { 0 };
        rows.push(Row::exactly(row, expected as f64, f64::from(different), &format!("of {seeds}")));
    }
    Ok(rows)
}

struct Bench {
    registry: Registry,
    duration: f64,
}

impl Bench {
    fn load(&self) -> Result<Loaded, SuiteError> {
        let files = mission::embedded_files().chain([(MISSION_FILE.to_owned(), MISSION.as_bytes().to_vec())]);
        mission::load_files(files, MISSION_FILE, &self.registry).map_err(SuiteError::from_display)
    }

    /// Runs the mission and returns the hash of its recording.
    fn hash(&self, way: Way, seed: u64) -> Result<String, SuiteError> {
        if way == Way::Replayed {
            let draft = Draft::new();
            self.run(REFERENCE, seed, Recording::File(draft.0.clone()))?;
            return self.replay(&draft);
        }
        self.run(way, seed, Recording::HashOnly)
    }

    fn run(&self, way: Way, seed: u64, record: Recording) -> Result<String, SuiteError> {
        let mut loaded = self.load()?;
        let (threads, links, seed) = match way {
            Way::With(threads, links) => (threads, links, seed),
            Way::OtherSeed => (1, Backend::Direct, ANOTHER + seed),
            Way::Replayed => (1, Backend::Direct, seed),
        };
        // Not in the text: the recording carries it.
        loaded.mission.settings.links = links;
        let options = RunOptions {
            duration: Some(Duration::from_secs_f64(self.duration)),
            seed: Some(seed),
            threads: Some(threads),
            record,
            ..RunOptions::default()
        };
        let outcome = mission::run(loaded, &self.registry, options).map_err(SuiteError::from_display)?;
        hash_of(outcome)
    }

    /// Runs a recorded mission again, from nothing but its recording.
    fn replay(&self, recording: &Draft) -> Result<String, SuiteError> {
        let reader = Reader::open(&recording.0).map_err(SuiteError::from_display)?;
        let recorded = reader.mission();
        let Some(main) = recorded.sources.first() else {
            return Err(SuiteError("the recording holds no configuration".into()));
        };
        let files = recorded.sources.iter().map(|source| (source.name.clone(), source.bytes.clone()));
        let mut loaded = mission::load_files(files, &main.name, &self.registry).map_err(SuiteError::from_display)?;
        loaded.mission.settings.links = Backend::Direct;
        let options = RunOptions {
            duration: Some(recorded.duration),
            seed: Some(recorded.seed),
            record: Recording::HashOnly,
            ..RunOptions::default()
        };
        hash_of(mission::run(loaded, &self.registry, options).map_err(SuiteError::from_display)?)
    }

    /// Says in the log where a recording parts from the reference.
    fn explain(&self, way: Way, seed: u64) {
        let (ours, theirs) = (Draft::new(), Draft::new());
        let both = self
            .run(REFERENCE, seed, Recording::File(ours.0.clone()))
            .and_then(|_| self.run(way, seed, Recording::File(theirs.0.clone())));
        let difference = both.and_then(|_| {
            let reader = |draft: &Draft| Reader::open(&draft.0).map_err(SuiteError::from_display);
            reader(&ours)?.first_difference(&reader(&theirs)?).map_err(SuiteError::from_display)
        });
        match difference {
            Ok(Some(difference)) => tracing::error!("{way:?}, seed {seed}: {difference}"),
            Ok(None) => tracing::error!("{way:?}, seed {seed}: all messages agree when run once more, or only the rest differs"),
            Err(error) => tracing::error!("{way:?}, seed {seed}: can't be compared: {error}"),
        }
    }
}

fn hash_of(outcome: Outcome) -> Result<String, SuiteError> {
    match outcome.recording {
        Some(recording) => Ok(recording.sha256),
        None => Err(SuiteError(format!("there is no recording: {}", outcome.failures.join("; ")))),
    }
}

/// A file that goes when it is no longer needed.
struct Draft(PathBuf);

impl Draft {
    fn new() -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        Self(std::env::temp_dir().join(format!("orienteer-{}-{number}.mcap", process::id())))
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // It may never have been begun.
        let _ = std::fs::remove_file(&self.0);
    }
}
