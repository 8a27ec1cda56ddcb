//! What came of a mission, for people and for programs.

use std::{fmt::Write as _, time::Duration};

use crate::{
    mission,
    runtime::{config::mission::ClockKind, fleet::Ended, robot::RobotReport, time::Time},
};
use serde::Serialize;
use serde_json::{Map, Value};

use super::{
    Outcome,
    style::{self, Paint},
    table::{Align, Table},
};

/// Says what failed, and how a command that ran a mission ends.
pub fn conclude(ended: &mission::Outcome) -> Outcome {
    for failure in &ended.failures {
        style::complain(failure, "everything else was done; the messages before this one say more");
    }
    match ended.ended {
        Ended::Stopped => Outcome::Interrupted,
        _ if !ended.failures.is_empty() => Outcome::Failed,
        Ended::Complete | Ended::AllDone => Outcome::Well,
    }
}

/// The summary of a mission, as `--json` prints it.
#[derive(Debug, Serialize)]
pub struct Summary {
    mission: String,
    clock: ClockKind,
    seed: u64,
    ended: &'static str,
    time_s: f64,
    planned_s: f64,
    elapsed_s: f64,
    real_time_factor: f64,
    steps: u64,
    missed_steps: u64,
    recording_hash: Option<String>,
    recording_bytes: Option<u64>,
    files: Vec<String>,
    failures: Vec<String>,
    robots: Vec<Robot>,
    #[serde(skip)]
    time: Time,
}

/// What became of one robot. What nobody on it measures is `null`.
#[derive(Debug, Serialize)]
struct Robot {
    name: String,
    distance_m: Option<f64>,
    time_s: f64,
    driving_s: Option<f64>,
    /// Times it drove into something.
    collisions: Option<u64>,
    /// Times something walked into it.
    bumped: Option<u64>,
    contacts_avoided: Option<u64>,
    /// Who held the base how long.
    held_s: Map<String, Value>,
    overruns: u64,
    restarts: u64,
    dropped: u64,
    map: Option<MapFigures>,
    /// What its nodes say in words.
    notes: Vec<String>,
}

#[derive(Debug, Serialize)]
struct MapFigures {
    free_cells: u64,
    occupied_cells: u64,
    free_area_m2: f64,
}

/// What a node calls the figures of who held the base.
const HELD: &str = "held_s.";

impl Summary {
    /// The summary of what came of a mission that was planned to last so long.
    pub fn of(outcome: &mission::Outcome, planned: Duration) -> Self {
        let recording = outcome.recording.as_ref();
        Self {
            mission: outcome.name.clone(),
            clock: outcome.clock,
            seed: outcome.seed,
            ended: match outcome.ended {
                Ended::Complete => "complete",
                Ended::AllDone => "all-done",
                Ended::Stopped => "stopped",
            },
            time_s: outcome.time.as_secs_f64(),
            planned_s: planned.as_secs_f64(),
            elapsed_s: outcome.elapsed.as_secs_f64(),
            real_time_factor: outcome.real_time_factor(),
            steps: outcome.steps,
            missed_steps: outcome.missed,
            recording_hash: recording.map(|recording| recording.sha256.clone()),
            recording_bytes: recording.map(|recording| recording.bytes),
            files: outcome.files.iter().map(|path| path.display().to_string()).collect(),
            failures: outcome.failures.clone(),
            robots: outcome.robots.iter().map(|robot| Robot::of(robot, outcome.time)).collect(),
            time: outcome.time,
        }
    }

    /// The summary for a terminal.
    pub fn text(&self, paint: Paint) -> String {
        let mut text = self.heading(paint);
        for part in [self.robots(paint), self.holders(paint), self.maps(paint), self.notes(paint), self.files(paint)] {
            if !part.is_empty() {
                text.push('\n');
                text.push_str(&part);
            }
        }
        text
    }

    fn heading(&self, paint: Paint) -> String {
        let end = match self.ended {
            "stopped" => paint.bad(" - stopped by Ctrl-C or a signal"),
            "all-done" => " - all robots are done".to_owned(),
            _ => String::new(),
        };
        let (name, time, factor) = (paint.bold(&self.mission), style::time(self.time), self.real_time_factor);
        let seed = self.seed;
        let mut text = match self.clock {
            ClockKind::Wall => format!("{name}, seed {seed}: {time} of real time{end}\n"),
            ClockKind::Lockstep => {
                let digits = if factor < 10.0 { 1 } else { 0 };
                format!("{name}, seed {seed}: {time} simulated in {:.1} s, {factor:.digits$} × real time{end}\n", self.elapsed_s)
            }
        };
        if self.missed_steps > 0 {
            let (missed, all) = (self.missed_steps, self.steps);
            let _ = writeln!(text, "{missed} of {all} steps were skipped: the machine, or a behaviour, was too slow");
        }
        text
    }

    fn robots(&self, paint: Paint) -> String {
        type Cell = fn(&Robot) -> Option<String>;
        let columns: [(&str, Cell); 8] = [
            ("distance", |robot| robot.distance_m.map(|metres| format!("{metres:.1} m"))),
            ("time", |robot| Some(format!("{:.1} s", robot.time_s))),
            ("collisions", |robot| robot.collisions.map(|count| count.to_string())),
            ("bumped", |robot| robot.bumped.map(|count| count.to_string())),
            ("avoided", |robot| robot.contacts_avoided.map(|count| count.to_string())),
            ("overruns", |robot| Some(robot.overruns.to_string())),
            ("restarts", |robot| Some(robot.restarts.to_string())),
            ("dropped", |robot| (robot.dropped > 0).then(|| robot.dropped.to_string())),
        ];
        // What nobody measures needs no column.
        let columns: Vec<_> =
            columns.into_iter().filter(|(_, cell)| self.robots.iter().any(|robot| cell(robot).is_some())).collect();
        let mut table =
            Table::new([("robot", Align::Left)].into_iter().chain(columns.iter().map(|(name, _)| (*name, Align::Right))));
        for robot in &self.robots {
            let cells = columns.iter().map(|(_, cell)| cell(robot).unwrap_or_else(|| "-".to_owned()));
            table.row([robot.name.clone()].into_iter().chain(cells));
        }
        let wrong =
            |column: usize| column > 0 && matches!(columns[column - 1].0, "collisions" | "overruns" | "restarts" | "dropped");
        table.render(paint, |_, column, cell| match cell {
            "0" | "-" => paint.dim(cell),
            _ if wrong(column) => paint.bad(cell),
            _ => cell.to_owned(),
        })
    }

    fn holders(&self, paint: Paint) -> String {
        let mut names: Vec<&str> = Vec::new();
        for name in self.robots.iter().flat_map(|robot| robot.held_s.keys()) {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        if names.is_empty() {
            return String::new();
        }
        let columns = names.iter().map(|name| (*name, Align::Right));
        let mut table = Table::new([("had the base", Align::Left)].into_iter().chain(columns).chain([("nobody", Align::Right)]));
        for robot in &self.robots {
            let held: Vec<f64> =
                names.iter().map(|name| robot.held_s.get(*name).and_then(Value::as_f64).unwrap_or(0.0)).collect();
            let nobody = (robot.time_s - held.iter().sum::<f64>()).max(0.0);
            let cells = held.iter().chain([&nobody]).map(|seconds| format!("{seconds:.1} s"));
            table.row([robot.name.clone()].into_iter().chain(cells));
        }
        table.render(paint, |_, _, cell| if cell == "0.0 s" { paint.dim(cell) } else { cell.to_owned() })
    }

    fn maps(&self, paint: Paint) -> String {
        if self.robots.iter().all(|robot| robot.map.is_none()) {
            return String::new();
        }
        let columns =
            [("map", Align::Left), ("free cells", Align::Right), ("occupied cells", Align::Right), ("free ground", Align::Right)];
        let mut table = Table::new(columns);
        for robot in &self.robots {
            let Some(map) = &robot.map else { continue };
            let cells = [map.free_cells.to_string(), map.occupied_cells.to_string(), format!("{:.1} m²", map.free_area_m2)];
            table.row([robot.name.clone()].into_iter().chain(cells));
        }
        table.render(paint, |_, _, cell| cell.to_owned())
    }

    /// What nodes say in words, robot by robot.
    fn notes(&self, paint: Paint) -> String {
        let mut text = String::new();
        for robot in self.robots.iter().filter(|robot| !robot.notes.is_empty()) {
            let _ = writeln!(text, "{}", paint.bold(format!("{} found", robot.name)));
            for note in &robot.notes {
                let _ = writeln!(text, "{}", style::wrap(note, 3));
            }
        }
        text
    }

    fn files(&self, paint: Paint) -> String {
        let mut text = String::new();
        if !self.files.is_empty() {
            let _ = writeln!(text, "{}", paint.bold("written"));
        }
        for file in &self.files {
            let size = self.recording_bytes.filter(|_| file.ends_with(".mcap")).map(style::bytes);
            let size = size.map(|size| paint.dim(format!("  {size}"))).unwrap_or_default();
            let _ = writeln!(text, "{file}{size}");
        }
        if let Some(hash) = &self.recording_hash {
            let _ = writeln!(text, "\n{} {hash}", paint.bold("recording sha256"));
        }
        text
    }
}

impl Robot {
    fn of(report: &RobotReport, time: Time) -> Self {
        let count = |name: &str| report.fact(name).map(|value| value.max(0.0) as u64);
        let map = || {
            let free_area_m2 = report.fact("free_area_m2")?;
            Some(MapFigures { free_cells: count("free_cells")?, occupied_cells: count("occupied_cells")?, free_area_m2 })
        };
        let held = report.facts().filter_map(|(name, seconds)| Some((name.strip_prefix(HELD)?.to_owned(), Value::from(seconds))));
        Self {
            name: report.name.clone(),
            distance_m: report.fact("distance_m"),
            time_s: time.as_secs_f64(),
            driving_s: report.fact("driving_s"),
            collisions: count("collisions"),
            bumped: count("bumped"),
            contacts_avoided: count("contacts_avoided"),
            held_s: held.collect(),
            overruns: report.nodes.iter().map(|node| u64::from(node.overruns)).sum(),
            restarts: report.nodes.iter().map(|node| u64::from(node.panics)).sum(),
            dropped: report.nodes.iter().map(|node| node.dropped).sum(),
            map: map(),
            notes: report.nodes.iter().flat_map(|node| node.finish.notes.iter().cloned()).collect(),
        }
    }
}
