//! Single mistakes in the shipped configurations, and in the worlds that they name.

use std::{collections::BTreeMap, path::Path};

use orienteer_hardware::world::plan::WorldPlan;
use orienteer_runtime::{
    config::{
        Problem, Problems, Section, Sources,
        mission::ClockKind,
        mutate::{Slip, Verdict, check_mutation, mutations},
        validate,
    },
    link::Backend,
};

use super::{Effort, Row, Suite, SuiteError, in_parallel};
use crate::{
    Registry,
    mission::{self, RunError},
};

pub(super) const SUITE: Suite = Suite {
    name: "config",
    help: "single mistakes in all shipped configurations and worlds: refused with a place and a hint, or meant so",
    run,
};

/// Mutations of all files together.
const MUTATIONS: u64 = 4_000;
/// Mutations that a thread makes at a time.
const PORTION: u64 = 10;
/// Bad outcomes that are told in the log, for each portion.
const TOLD: usize = 2;
/// Missions that are made up for a world that none of the shipped ones names.
const MADE_UP: &str = "try-";
/// The configurations of the repository that this program was built from.
const REPOSITORY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/configs");

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let registry = Registry::standard();
    let subjects = subjects(&registry)?;
    let files = subjects.len() as u64;
    let portions = effort.seeds(MUTATIONS).div_ceil(PORTION * files);
    let counts = in_parallel(effort, "mutations", portions * files, |job| {
        Ok(subjects[(job % files) as usize].check(1 + job / files, &registry))
    })?;
    let mut all = Counts::default();
    counts.iter().for_each(|counts| all.add(counts));
    let asked = (portions * PORTION * files) as f64;
    Ok(vec![
        Row::at_least("shipped files", 5.0, files as f64, "files"),
        // Mutations that leave the text as it was are left out, and tiny files have room for few.
        Row::at_least("single mutations", (0.9 * asked).floor(), all.mutations as f64, ""),
        Row::exactly("panics", 0.0, all.panics as f64, ""),
        Row::exactly("keys ignored in silence", 0.0, all.ignored as f64, ""),
        Row::exactly("refusals without file, line, column or hint", 0.0, all.vague as f64, ""),
        Row::at_least("refused", 1.0, all.refused as f64, ""),
        Row::at_least("valid, and every key in them means something", 1.0, all.valid as f64, ""),
        Row::at_least("sorts of slips", 12.0, all.slips.len() as f64, ""),
    ])
}

#[derive(Debug, Default)]
struct Counts {
    mutations: u64,
    valid: u64,
    refused: u64,
    vague: u64,
    ignored: u64,
    panics: u64,
    slips: BTreeMap<Slip, u64>,
}

impl Counts {
    fn add(&mut self, other: &Self) {
        self.mutations += other.mutations;
        self.valid += other.valid;
        self.refused += other.refused;
        self.vague += other.vague;
        self.ignored += other.ignored;
        self.panics += other.panics;
        for (slip, count) in &other.slips {
            *self.slips.entry(*slip).or_default() += count;
        }
    }
}

/// A file to be spoilt, and the mission that reads it.
struct Subject {
    /// Everything that the mission reads, by name.
    files: Vec<(String, Vec<u8>)>,
    mission: String,
    /// The file to be spoilt, and its text.
    name: String,
    text: String,
}

impl Subject {
    fn check(&self, seed: u64, registry: &Registry) -> Counts {
        let mut counts = Counts::default();
        let mut told = 0;
        for mutation in mutations(&self.text, seed).take(PORTION as usize) {
            counts.mutations += 1;
            *counts.slips.entry(mutation.slip).or_default() += 1;
            let verdict = check_mutation(&self.text, &mutation.text, &|text| self.understood(text, registry));
            match &verdict {
                Verdict::Valid => counts.valid += 1,
                Verdict::Refused(_) => counts.refused += 1,
                Verdict::Vague(_) => counts.vague += 1,
                Verdict::Ignored(..) => counts.ignored += 1,
                Verdict::Panicked(_) => counts.panics += 1,
            }
            if !verdict.good() && told < TOLD {
                told += 1;
                tracing::error!("{}, {:?}: {verdict:?}; changed: {}", self.name, mutation.slip, self.changes(&mutation.text));
            }
        }
        counts
    }

    /// The lines of a mutation that the file does not have.
    fn changes(&self, mutated: &str) -> String {
        let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
        let (old, new) = (lines(&self.text), lines(mutated));
        let start = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
        let rest = old.len().min(new.len()) - start;
        let end = old.iter().rev().zip(new.iter().rev()).take(rest).take_while(|(a, b)| a == b).count();
        format!("line {}: {:?} -> {:?}", start + 1, &old[start..old.len() - end], &new[start..new.len() - end])
    }

    /// All that is understood of the mission and its world with another text for the file, after both have been tried out:
    /// world, drivers and agents are opened as for a run.
    fn understood(&self, text: &str, registry: &Registry) -> Result<String, Problems> {
        let files = self
            .files
            .iter()
            .map(|(name, bytes)| (name.clone(), if *name == self.name { text.as_bytes().to_vec() } else { bytes.clone() }));
        let mut loaded = mission::load_files(files, &self.mission, registry)?;
        let mut understood = serde_json::to_string(&loaded.mission).map_err(unusual)?;
        if let Some(world) = loaded.mission.world.as_ref().filter(|world| world.path.ends_with(".toml")) {
            understood += &world_plan(&loaded.sources, world.source)?;
        }
        // The machine's threads and links are not what is tried.
        loaded.mission.settings.links = Backend::Direct;
        loaded.mission.settings.clock = ClockKind::Lockstep;
        let seed = loaded.mission.settings.seed;
        match mission::compose(loaded, registry, seed) {
            Ok(_) => Ok(understood),
            Err(RunError::Config(problems)) => Err(problems),
            Err(error) => Err(unusual(error)),
        }
    }
}

fn world_plan(sources: &Sources, file: orienteer_runtime::config::SourceId) -> Result<String, Problems> {
    let plan: WorldPlan = validate::read(&Section::parse(sources, file)?, sources)?;
    serde_json::to_string(&plan).map_err(unusual)
}

/// Something that has no place in a file: counts as vague.
fn unusual(error: impl std::fmt::Display) -> Problems {
    Problem::nowhere(error.to_string(), "").into()
}

/// All files that ship: those of the repository if it is there, else those that are built in.
fn subjects(registry: &Registry) -> Result<Vec<Subject>, SuiteError> {
    let mut found = Vec::new();
    let mut spoilt = std::collections::BTreeSet::new();
    for (mission, loaded) in missions(registry)? {
        let composed = mission::compose(loaded, registry, 1);
        let composed = match composed {
            Ok(composed) => composed,
            // Somebody's own, half-done, beside those that ship; the tests look after these.
            Err(error) if !mission.starts_with(MADE_UP) => {
                tracing::warn!("{mission} is left out, it does not work out unspoilt: {error}");
                continue;
            }
            Err(error) => return Err(SuiteError(format!("{mission} does not work out unspoilt: {error}"))),
        };
        let files: Vec<_> = composed.recorded_sources().into_iter().map(|source| (source.name, source.bytes)).collect();
        for (name, bytes) in &files {
            let Some(text) = String::from_utf8(bytes.clone()).ok().filter(|_| name.ends_with(".toml")) else { continue };
            // A world that several missions share is spoilt once, and what was made up here is not shipped.
            if !name.starts_with(MADE_UP) && spoilt.insert(name.clone()) {
                found.push(Subject { files: files.clone(), mission: mission.clone(), name: name.clone(), text });
            }
        }
    }
    Ok(found)
}

/// All missions that ship, and one for each world that none of them names.
fn missions(registry: &Registry) -> Result<Vec<(String, mission::Loaded)>, SuiteError> {
    let repository = Path::new(REPOSITORY);
    let mut missions = Vec::new();
    if !repository.is_dir() {
        for name in mission::EMBEDDED {
            let loaded = mission::load_embedded(name, registry).map_err(SuiteError::from_display)?;
            missions.push((format!("{name}.toml"), loaded));
        }
        return Ok(missions);
    }
    for name in toml_files(repository)? {
        match mission::load(repository.join(&name), registry) {
            Ok(loaded) => missions.push((name, loaded)),
            // It may need data that this machine does not have.
            Err(problems) => tracing::warn!("left out: {problems}"),
        }
    }
    let worlds = repository.join("worlds");
    for name in toml_files(&worlds)? {
        let path = format!("worlds/{name}");
        let text = std::fs::read(worlds.join(&name)).map_err(SuiteError::from_display)?;
        let mission = format!("{MADE_UP}{name}");
        let files = [(mission.clone(), mission_in(&path, &text).into_bytes()), (path, text)];
        let loaded = mission::load_files(files, &mission, registry).map_err(SuiteError::from_display)?;
        missions.push((mission, loaded));
    }
    Ok(missions)
}

fn toml_files(directory: &Path) -> Result<Vec<String>, SuiteError> {
    let unreadable = |error: std::io::Error| SuiteError(format!("`{}` can't be read: {error}", directory.display()));
    let mut names = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(unreadable)? {
        let name = entry.map_err(unreadable)?.file_name().to_string_lossy().into_owned();
        if name.ends_with(".toml") {
            names.push(name);
        }
    }
    names.sort_unstable();
    Ok(names)
}

/// A mission with one robot at the first place of a world.
fn mission_in(world: &str, text: &[u8]) -> String {
    let plan = WorldPlan::parse(&String::from_utf8_lossy(text)).unwrap_or_default();
    let start = plan.place.first().map(|place| format!("start = {{ place = {:?} }}", place.name)).unwrap_or_default();
    format!("[world]\nfile = {world:?}\n\n[[robot]]\nname = \"huey\"\nbase = {{ driver = \"sim\" }}\n{start}\n")
}
