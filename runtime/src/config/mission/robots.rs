//! From tables to robots: templates, repetition, names and starts.

use std::collections::BTreeMap;

use super::{
    AgentConfig, RobotConfig, Start, StartAt, Templates, WorldConfig,
    catalog::{AgentInfo, Catalog, DriverInfo},
    keys::{RobotKeys, SpacingKeys, StartKeys},
    names,
    parts::{Checker, Device},
    wiring::{self, Wired},
};
use crate::{
    config::{
        document::{Data, Section, Table},
        problem::{Problem, Problems},
        source::{Sources, Span},
    },
    geometry::Pose,
};

/// What a mission file gives.
pub(super) struct Found {
    pub(super) robots: Vec<RobotConfig>,
    pub(super) templates: Vec<(String, Section)>,
}

/// Checks all templates and makes all robots. Without problems the result is whole.
pub(super) fn all(
    document: &Section,
    world: Option<&WorldConfig>,
    sources: &Sources,
    catalog: &dyn Catalog,
    problems: &mut Vec<Problem>,
) -> Found {
    let checker = Checker::new(sources, catalog);
    let templates = match document.section("template") {
        Some(section) => Templates::resolve(section.table(), sources, &different, problems),
        None => Templates::default(),
    };
    let whole: Vec<(String, Section)> =
        templates.names().filter_map(|name| Some((name.to_owned(), templates.get(name)?.clone()))).collect();
    for (_, template) in &whole {
        checker.device(template, Device::Base, true, problems);
        checker.device(template, Device::Sonar, true, problems);
        checker.agents(template, true, problems);
    }
    let mut maker =
        Maker { checker, world, has_world: document.table().contains_key("world"), taken: BTreeMap::new(), robots: Vec::new() };
    match document.table().get("robot").map(toml::Spanned::get_ref) {
        Some(Data::List(robots)) if !robots.is_empty() => {
            for value in robots {
                if let Some(table) = value.get_ref().as_table() {
                    maker.robot(&Section::new(table.clone(), value.span()), &templates, problems);
                }
            }
        }
        None | Some(Data::List(_)) => {
            let at = if document.table().contains_key("robot") { document.span_of_key("robot") } else { document.span() };
            let hint = "add one: `[[robot]]` with a `name` and a `base`";
            problems.push(Problem::new(sources, &at, "the mission has no robot", hint));
        }
        // Reported with the file as a whole.
        Some(_) => {}
    }
    Found { robots: maker.robots, templates: whole }
}

/// Tables that do not merge: another driver, another kind of agent, another way to say where.
fn different(key: &str, base: &Table, over: &Table) -> bool {
    let text = |table: &Table, of: &str| table.get(of).and_then(|value| value.get_ref().as_text()).map(str::to_owned);
    let has = |table: &Table, of: &[&str]| of.iter().any(|key| table.contains_key(*key));
    let changes = |tag: &str, unless: Option<String>| match (text(base, tag).or(unless), text(over, tag)) {
        (Some(below), Some(above)) => below != above,
        _ => false,
    };
    let swaps = |one: &[&str], other: &[&str]| has(base, one) && has(over, other) || has(base, other) && has(over, one);
    match key {
        "base" | "sonar" => changes("driver", None) || swaps(&["custom"], &["platform", "ring"]),
        "start" => swaps(&["place"], &["x", "y"]),
        _ => changes("kind", Some(key.to_owned())),
    }
}

struct Maker<'a> {
    checker: Checker<'a>,
    world: Option<&'a WorldConfig>,
    /// True if the file has a world, even if it could not be read.
    has_world: bool,
    taken: BTreeMap<String, Span>,
    robots: Vec<RobotConfig>,
}

impl<'a> Maker<'a> {
    fn robot(&mut self, section: &Section, templates: &Templates, problems: &mut Vec<Problem>) {
        let sources = self.checker.sources;
        let Some(whole) = templates.under(section, sources, &different, problems) else {
            self.take(section, 1, false, problems);
            return;
        };
        let before = problems.len();
        let base = self.checker.device(&whole, Device::Base, false, problems);
        let sonar = self.checker.device(&whole, Device::Sonar, false, problems);
        let agents = self.checker.agents(&whole, false, problems);
        if !whole.table().contains_key("base") {
            let message = format!("the robot `{}` has no base", section.text("name").unwrap_or("?"));
            let drivers = self.checker.catalog.base_drivers().join("`, `");
            let hint = format!("add `base = {{ driver = \"…\" }}` (drivers: `{drivers}`), or a `template` that has one");
            problems.push(Problem::new(sources, &section.span(), message, hint));
        }
        let keys = match self.keys(&whole) {
            Ok(keys) => keys,
            // Reported with the file as a whole.
            Err(_) => return,
        };
        let repeated = keys.count.is_some();
        let start = self.start(&whole, &keys, problems);
        self.spacing(&whole, &keys, base.as_ref().is_some_and(|(_, info)| info.needs_world), problems);
        self.needs_world(&[base.as_ref(), sonar.as_ref()], problems);
        let names = self.take(section, keys.count.unwrap_or(1), repeated, problems);
        let Some((base, base_info)) = base else { return };
        let infos: Vec<&AgentInfo> = agents.iter().filter(|(_, enabled, _)| *enabled).map(|(.., info)| *info).collect();
        let (enabled, disabled): (Vec<_>, Vec<_>) = agents.into_iter().partition(|(_, enabled, _)| *enabled);
        let configs = |agents: Vec<(AgentConfig, bool, &AgentInfo)>| agents.into_iter().map(|(agent, ..)| agent).collect();
        let first = RobotConfig {
            name: section.text("name").unwrap_or_default().to_owned(),
            span: section.span_of("name"),
            start: None,
            hardware: keys.hardware.unwrap_or_default(),
            base,
            sonar: sonar.as_ref().map(|(config, _)| config.clone()),
            agents: configs(enabled),
            disabled: configs(disabled),
        };
        // What is wired to a part with problems is not worth reporting.
        if problems.len() == before {
            let mut devices: Vec<(&'static str, &[String])> = vec![("base", &base_info.writes)];
            devices.extend(sonar.as_ref().map(|(_, info)| ("sonar", info.writes.as_slice())));
            wiring::check(&Wired { robot: &first, agents: &infos, devices }, self.checker.catalog, sources, problems);
        }
        let spacing = keys.spacing.unwrap_or_default();
        for (index, name) in names.into_iter().enumerate() {
            let start = start.clone().map(|start| Start { offset: offset(&spacing, index), ..start });
            self.robots.push(RobotConfig { name, start, ..first.clone() });
        }
    }

    fn keys(&self, whole: &Section) -> Result<RobotKeys, Problems> {
        whole.deserialize(self.checker.sources)
    }

    /// The names of a robot and its copies, if they are good and free.
    fn take(&mut self, section: &Section, count: u32, repeated: bool, problems: &mut Vec<Problem>) -> Vec<String> {
        let sources = self.checker.sources;
        let Some(name) = section.text("name") else { return Vec::new() };
        let span = section.span_of("name");
        if let Err((message, hint)) = names::check(name, "robot", names::TAKEN_FROM_ROBOTS) {
            problems.push(Problem::new(sources, &span, message, hint));
        }
        let all = (1..=count.min(10_000)).map(|n| if repeated { format!("{name}-{n}") } else { name.to_owned() });
        let all: Vec<String> = all.collect();
        for name in &all {
            if let Some(first) = self.taken.insert(name.clone(), span.clone()) {
                let hint = format!("choose another name, such as `{}`", self.free(name));
                let problem = Problem::new(sources, &span, format!("two robots are called `{name}`"), hint);
                problems.push(problem.note(sources, &first, "the first is here"));
                break;
            }
        }
        all
    }

    /// A name like this one that no robot has.
    fn free(&self, name: &str) -> String {
        let free = (2..).map(|n| format!("{name}-{n}")).find(|name| !self.taken.contains_key(name));
        free.unwrap_or_default()
    }

    fn start(&self, whole: &Section, keys: &RobotKeys, problems: &mut Vec<Problem>) -> Option<Start> {
        let sources = self.checker.sources;
        let Some(start) = &keys.start else {
            // Copies need something to be spaced from.
            let span = whole.span_of("spacing");
            return keys.spacing.is_some().then(|| Start { at: StartAt::Pose(Pose::default()), offset: (0.0, 0.0), span });
        };
        let span = whole.span_of("start");
        let heading = start.heading_deg.map(f64::to_radians);
        let at = match start {
            StartKeys { place: Some(name), x: None, y: None, .. } => {
                if self.world.is_none() && !self.has_world {
                    let section = whole.section("start").unwrap_or_else(|| whole.clone());
                    let hint = "add `[world]`, or give `x` and `y`";
                    let message = format!("the place `{name}` is in no world, for the mission has none");
                    problems.push(Problem::new(sources, &section.span_of("place"), message, hint));
                }
                StartAt::Place { name: name.clone(), heading }
            }
            StartKeys { place: None, x: Some(x), y: Some(y), .. } => StartAt::Pose(Pose::new(*x, *y, heading.unwrap_or(0.0))),
            StartKeys { place: Some(_), .. } => {
                let hint = "give either `place`, or `x` and `y`";
                problems.push(Problem::new(sources, &span, "a robot begins at one place, but this names two", hint));
                return None;
            }
            StartKeys { x, .. } => {
                let lacks = if x.is_some() { "`y`" } else { "`x`" };
                let hint = "write `start = { x = 1.0, y = 2.0 }` or `start = { place = \"…\" }`";
                problems.push(Problem::new(sources, &span, format!("`start` lacks {lacks}"), hint));
                return None;
            }
        };
        Some(Start { at, offset: (0.0, 0.0), span })
    }

    /// Copies may not stand on each other, and a single robot has nothing to be spaced from.
    fn spacing(&self, whole: &Section, keys: &RobotKeys, simulated: bool, problems: &mut Vec<Problem>) {
        let sources = self.checker.sources;
        match (keys.count, &keys.spacing) {
            (None, Some(_)) => {
                let hint = "add `count = …`, or remove `spacing`";
                let message = "`spacing` means nothing without `count`";
                problems.push(Problem::new(sources, &whole.span_of_key("spacing"), message, hint));
            }
            (Some(2..), None) if keys.start.is_some() || simulated => {
                let hint = "add `spacing = { x = 2.0, y = 2.0, columns = 10 }`";
                let message = "repeated robots would all begin at the same place";
                problems.push(Problem::new(sources, &whole.span_of_key("count"), message, hint));
            }
            (Some(2..), Some(SpacingKeys { x, y, columns })) => {
                let rows = keys.count.unwrap_or(1).div_ceil(*columns);
                if (*x == 0.0 && *columns > 1) || (*y == 0.0 && rows > 1) {
                    let hint = "make `x` and `y` larger than a robot, or set `columns = 1` for a column, or as large as `count` for a row";
                    let message = "with this spacing some robots would begin at the same place";
                    problems.push(Problem::new(sources, &whole.span_of("spacing"), message, hint));
                }
            }
            _ => {}
        }
    }

    fn needs_world(&self, devices: &[Option<&(super::DriverConfig, &DriverInfo)>], problems: &mut Vec<Problem>) {
        let simulated = devices.iter().flatten().find(|(_, info)| info.needs_world);
        if let (Some((config, _)), false) = (simulated, self.has_world) {
            let message = format!("the driver `{}` is simulated, but the mission has no world", config.name);
            let hint = "add `[world]` with `file = \"worlds/….toml\"`";
            problems.push(Problem::new(self.checker.sources, &config.span, message, hint));
        }
    }
}

/// Where the copy of this index stands from the first.
fn offset(spacing: &SpacingKeys, index: usize) -> (f64, f64) {
    let columns = spacing.columns.max(1) as usize;
    ((index % columns) as f64 * spacing.x, (index / columns) as f64 * spacing.y)
}
