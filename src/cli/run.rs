//! `orienteer run`: a mission, from its configuration to its summary.

use std::time::Duration;

use crate::{
    Registry,
    mission::{self, EMBEDDED, Loaded, Recording, RunOptions},
    runtime::{clock::Pace, config::mission::ClockKind, time::Time},
};

use super::{
    Outcome, Refusal, RunArguments,
    progress::MissionWatch,
    style,
    summary::{Summary, conclude},
};

/// Runs a mission and prints what came of it.
pub fn run(arguments: &RunArguments, registry: &Registry) -> Result<Outcome, Refusal> {
    let loaded = match &arguments.config {
        Some(path) => mission::load(path, registry)?,
        None => mission::load_embedded(EMBEDDED[0], registry)?,
    };
    let pace = pace(arguments, &loaded)?;
    let settings = &loaded.mission.settings;
    let planned = Duration::from_secs_f64(arguments.duration.unwrap_or(settings.duration));
    let (bar, watch) = MissionWatch::new(&settings.name, Time::START + planned);
    let options = RunOptions {
        pace,
        duration: arguments.duration.map(Duration::from_secs_f64),
        seed: arguments.seed,
        threads: arguments.threads.map(usize::from),
        record: match &arguments.record {
            Some(path) => Recording::File(path.clone()),
            None if arguments.no_record => Recording::Off,
            None => Recording::AsConfigured,
        },
        out: Some(arguments.out.clone()),
        observer: Some(Box::new(watch)),
        ..RunOptions::default()
    };
    let ended = mission::run(loaded, registry, options);
    drop(bar);

    let ended = ended?;
    let summary = Summary::of(&ended, planned);
    if arguments.json {
        style::print_json(&summary)?;
    } else {
        style::print(&summary.text(style::Paint::stdout()))?;
    }
    Ok(conclude(&ended))
}

fn pace(arguments: &RunArguments, loaded: &Loaded) -> Result<Option<Pace>, Refusal> {
    match (arguments.speed, loaded.mission.settings.clock) {
        (Some(_), ClockKind::Wall) => Err(Refusal::misused(
            "`--speed` means nothing here: the mission has `clock = \"wall\"`, and real time goes by itself",
            "leave the option out, or set `clock = \"lockstep\"` in the configuration",
        )),
        (speed, _) => Ok(speed.map(Pace::Factor)),
    }
}
