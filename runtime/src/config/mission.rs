//! Missions: which robots, made of what, with which behaviours, in which world.
//!
//! ```toml
//! [mission]
//! duration = 600.0
//! seed = 7
//!
//! [world]
//! file = "worlds/office-floor.toml"
//!
//! [template.huey]
//! base = { driver = "sim", platform = "b12-huey" }
//! sonar = { driver = "sim", ring = "denning-16" }
//!
//! [template.huey.agent.avoidance]
//! priority = 10
//!
//! [[robot]]
//! name = "ann"
//! template = "huey"
//! start = { x = 1.0, y = 2.0, heading_deg = 90 }
//! ```
//!
//! A robot is laid over its template, key by key ([`layers`](super::layers)); where it names another driver, or an agent of
//! another kind, that table stands alone. `count = N` makes N robots. What drivers, kinds of agents and names there are, the
//! [`Catalog`] says; each has a schema for its own keys.
//!
//! Every template is checked on its own, used or not, and every robot as a whole.

mod catalog;
mod keys;
mod names;
mod parts;
mod robots;
mod schema;
mod wiring;

use serde::Serialize;

pub use catalog::{AgentInfo, Catalog, DriverInfo};
pub use keys::{ClockKind, HardwarePlace, MOST_THREADS, MissionFile, MissionKeys, RecordKeys, SpacingKeys, StartKeys};
pub use schema::schema;

use super::{
    document::Section,
    layers::Templates,
    problem::{Problem, Problems},
    source::{SourceId, Sources, Span},
    validate::{self, Rules},
};
use crate::{geometry::Pose, link::Backend};

/// A mission that makes sense.
#[derive(Debug, Clone, Serialize)]
pub struct Mission {
    /// `[mission]`, with a name in any case.
    pub settings: MissionKeys,
    /// `[world]`, if the mission has one.
    pub world: Option<WorldConfig>,
    /// `[record]`.
    pub record: RecordKeys,
    /// The robots, in the order of the file.
    pub robots: Vec<RobotConfig>,
    /// All templates, whole, by name.
    pub templates: Vec<(String, Section)>,
}

/// The world that a mission names. Its file has been read, but not looked into.
#[derive(Debug, Clone, Serialize)]
pub struct WorldConfig {
    /// In which form it is written.
    pub kind: WorldKind,
    /// The file's name, as written in the mission.
    pub path: String,
    /// The file.
    #[serde(skip)]
    pub source: SourceId,
    /// Where the mission names it.
    #[serde(skip)]
    pub span: Span,
}

/// In which form a world is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WorldKind {
    /// Orienteer's own TOML.
    File,
    /// A map of the ROS map server.
    Map,
}

/// One robot.
#[derive(Debug, Clone, Serialize)]
pub struct RobotConfig {
    /// Unique in the mission.
    pub name: String,
    /// Where the configuration names it.
    #[serde(skip)]
    pub span: Span,
    /// Where it begins; the driver decides unless given.
    pub start: Option<Start>,
    /// Which process has base and sonar.
    pub hardware: HardwarePlace,
    /// The base.
    pub base: DriverConfig,
    /// The sonar, if it has one.
    pub sonar: Option<DriverConfig>,
    /// Its agents, in the order of the configuration.
    pub agents: Vec<AgentConfig>,
    /// Agents with `enabled = false`: not part of the robot.
    pub disabled: Vec<AgentConfig>,
}

/// Where a robot begins.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Start {
    /// Of the first robot, if it is repeated.
    pub at: StartAt,
    /// To be added to the position, world frame, m.
    pub offset: (f64, f64),
    /// Where the configuration says so.
    #[serde(skip)]
    pub span: Span,
}

/// A pose, or the name of one.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StartAt {
    /// In the world frame.
    Pose(Pose),
    /// A place that the world has a pose for.
    Place {
        /// The place's name.
        name: String,
        /// Heading instead of the place's own, rad.
        heading: Option<f64>,
    },
}

/// A driver and its own keys.
#[derive(Debug, Clone, Serialize)]
pub struct DriverConfig {
    /// The driver's name.
    pub name: String,
    /// Where the configuration names it.
    #[serde(skip)]
    pub span: Span,
    /// The driver's own keys, which fit its schema. See [`validate::read`].
    pub section: Section,
}

/// An agent and its own keys.
#[derive(Debug, Clone, Serialize)]
pub struct AgentConfig {
    /// Its name, unique on the robot.
    pub name: String,
    /// What kind of agent it is.
    pub kind: String,
    /// Who wins: the highest number.
    pub priority: u8,
    /// Longer steps are reported, s.
    pub deadline: Option<f64>,
    /// Where the configuration names it.
    #[serde(skip)]
    pub span: Span,
    /// The agent's own keys, which fit its kind's schema. See [`validate::read`].
    pub section: Section,
}

impl Mission {
    /// Reads a mission that is among the sources, and the world file that it names.
    ///
    /// # Errors
    /// Everything that is wrong, each at its place.
    pub fn load(sources: &mut Sources, id: SourceId, catalog: &dyn Catalog) -> Result<Self, Problems> {
        let document = Section::parse(sources, id)?;
        let mut problems = Vec::new();
        let keys = validate::schema_of::<MissionFile>();
        let names = |sort: &str| catalog.names(sort);
        let elsewhere = |key: &str| parts::owner(key, catalog);
        let rules =
            Rules { schema: &keys, common: None, partial: false, name: "the mission", names: &names, elsewhere: &elsewhere };
        problems.extend(validate::check(&document, &rules, sources));

        let world = world(&document, sources, &mut problems);
        let found = robots::all(&document, world.as_ref(), sources, catalog, &mut problems);
        let settings = settings(&document, sources, &mut problems);
        check_record(&document, sources, &mut problems);
        Problems::check(problems)?;

        let mut settings = settings?;
        if settings.name.is_empty() {
            let file = sources.name(id).rsplit('/').next().unwrap_or_default();
            settings.name = file.strip_suffix(".toml").unwrap_or(file).to_owned();
        }
        let record = part(&document, "record", sources)?;
        Ok(Self { settings, world, record, robots: found.robots, templates: found.templates })
    }
}

/// A table of the file as its type; the type's default if it is not there.
fn part<T: serde::de::DeserializeOwned>(document: &Section, key: &str, sources: &Sources) -> Result<T, Problems> {
    let empty = || Section::new(super::document::Table::new(), document.span());
    document.section(key).unwrap_or_else(empty).deserialize(sources)
}

fn settings(document: &Section, sources: &Sources, problems: &mut Vec<Problem>) -> Result<MissionKeys, Problems> {
    let settings: MissionKeys = part(document, "mission", sources)?;
    if let (Some(_), ClockKind::Wall, Some(section)) = (settings.speed, settings.clock, document.section("mission")) {
        let message = "`speed` means nothing with `clock = \"wall\"`: real time goes by itself";
        let hint = "remove the line, or set `clock = \"lockstep\"`";
        let problem = Problem::new(sources, &section.span_of_key("speed"), message, hint);
        problems.push(problem.note(sources, &section.span_of("clock"), "the clock is chosen here"));
    }
    if let (Err((message, hint)), Some(section)) = (names::check_title(&settings.name), document.section("mission")) {
        problems.push(Problem::new(sources, &section.span_of("name"), message, hint));
    }
    if let (Some(run), Some(section)) = (&settings.run, document.section("mission")) {
        if let Err((message, hint)) = names::check(run, "run", &[]) {
            problems.push(Problem::new(sources, &section.span_of("run"), message, hint));
        }
        if settings.links != Backend::Shared {
            let message = "`run` means nothing with these links: nobody outside can attach to them";
            let hint = "remove the line, or set `links = \"shared\"`";
            let problem = Problem::new(sources, &section.span_of_key("run"), message, hint);
            problems.push(problem.note(sources, &section.span_of("links"), "the links are chosen here"));
        }
    }
    Ok(settings)
}

/// What is recorded must be told from what is not.
fn check_record(document: &Section, sources: &Sources, problems: &mut Vec<Problem>) {
    let Some(section) = document.section("record") else { return };
    let Some(file) = section.text("file") else { return };
    if matches!(section.table().get("enabled").map(toml::Spanned::get_ref), Some(super::document::Data::Flag(false))) {
        let message = "`file` means nothing with `enabled = false`: nothing is recorded";
        let problem = Problem::new(sources, &section.span_of_key("file"), message, "remove one of the two lines");
        problems.push(problem.note(sources, &section.span_of_key("enabled"), "recording is switched off here"));
    }
    if file.strip_suffix(".mcap").is_none_or(|stem| stem.is_empty() || stem.ends_with('/')) {
        let stem = file.trim_end_matches('/');
        let hint = format!("call it `{}.mcap`; it goes into the output directory", if stem.is_empty() { "run" } else { stem });
        problems.push(Problem::new(sources, &section.span_of("file"), "a recording has a name that ends in `.mcap`", hint));
    }
}

/// The world, with its file read.
fn world(document: &Section, sources: &mut Sources, problems: &mut Vec<Problem>) -> Option<WorldConfig> {
    let section = document.section("world")?;
    let (kind, key) = match (section.text("file"), section.text("map")) {
        (Some(_), Some(_)) => {
            let message = "a mission has one world, but this names two";
            let problem = Problem::new(sources, &section.span_of_key("map"), message, "remove `file` or `map`");
            problems.push(problem.note(sources, &section.span_of_key("file"), "the other one is here"));
            return None;
        }
        (Some(_), None) => (WorldKind::File, "file"),
        (None, Some(_)) => (WorldKind::Map, "map"),
        (None, None) => {
            // An empty table says nothing; a wrong key in it was reported.
            if section.table().is_empty() {
                let hint = "add `file = \"worlds/….toml\"`, or remove the table";
                problems.push(Problem::new(sources, &section.span(), "the table `[world]` names no world", hint));
            }
            return None;
        }
    };
    let path = section.text(key).unwrap_or_default().to_owned();
    let span = section.span_of(key);
    match sources.read_for(&path, &span) {
        Ok(source) => Some(WorldConfig { kind, path, source, span }),
        Err(problem) => {
            problems.push(problem);
            None
        }
    }
}
