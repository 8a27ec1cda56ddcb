//! `orienteer list`: what a configuration may name.

use std::{fs, path::Path};

use crate::{
    Registry,
    hardware::{
        base::{
            kinematics::{BaseConfig, Drive},
            presets,
        },
        rings,
    },
    mission::embedded_files,
    reproduce::SUITES,
};
use serde::Serialize;

use super::{
    ListArguments, Outcome, Refusal,
    style::{self, Paint},
};

/// Something with a name.
#[derive(Debug, Clone, Serialize)]
struct Item {
    name: String,
    help: String,
}

impl Item {
    fn new(name: impl Into<String>, help: impl Into<String>) -> Self {
        Self { name: name.into(), help: help.into() }
    }
}

/// All things of a sort.
struct List {
    sort: &'static str,
    about: &'static str,
    items: Vec<Item>,
}

/// Prints what there is.
pub fn list(arguments: &ListArguments, registry: &Registry) -> Result<Outcome, Refusal> {
    let wanted = |list: &List| arguments.what.as_deref().is_none_or(|what| what == list.sort);
    let lists: Vec<List> = lists(registry).into_iter().filter(wanted).collect();
    if arguments.json {
        match lists.as_slice() {
            [only] => style::print_json(&only.items)?,
            all => {
                let map = all.iter().map(|list| (list.sort.to_owned(), serde_json::json!(list.items)));
                style::print_json(&map.collect::<serde_json::Map<_, _>>())?;
            }
        }
        return Ok(Outcome::Well);
    }
    let paint = Paint::stdout();
    let texts: Vec<String> = lists.iter().map(|list| text(list, paint)).collect();
    style::print(&texts.join("\n"))?;
    Ok(Outcome::Well)
}

fn text(list: &List, paint: Paint) -> String {
    let widest = list.items.iter().map(|item| item.name.chars().count()).max().unwrap_or(0);
    let mut text = format!("{}  {}\n", paint.bold(list.sort), paint.dim(list.about));
    for item in &list.items {
        let name = format!("{:widest$}", item.name);
        let line = format!("  {name}  {}", style::wrap(&item.help, widest + 4));
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

fn lists(registry: &Registry) -> Vec<List> {
    let agents = registry.agents().kinds().iter().map(|kind| Item::new(kind.name, &kind.info.help));
    let bases = registry.drivers().bases().iter().map(|kind| Item::new(format!("base {}", kind.name), &kind.info.help));
    let sonars = registry.drivers().sonars().iter().map(|kind| Item::new(format!("sonar {}", kind.name), &kind.info.help));
    vec![
        List { sort: "agents", about: "[robot.agent.NAME]", items: agents.collect() },
        List {
            sort: "drivers",
            about: "base = { driver = \"...\" }, sonar = { driver = \"...\" }",
            items: bases.chain(sonars).collect(),
        },
        List {
            sort: "platforms",
            about: "base = { platform = \"...\" }",
            items: presets::all().map(|base| platform(&base)).collect(),
        },
        List {
            sort: "rings",
            about: "sonar = { ring = \"...\" }",
            items: rings::all().map(|ring| Item::new(&ring.ring.name, ring.help)).collect(),
        },
        List { sort: "worlds", about: "[world] file = \"...\"", items: worlds() },
        List {
            sort: "suites",
            about: "orienteer reproduce ...",
            items: SUITES.iter().map(|suite| Item::new(suite.name, suite.help)).collect(),
        },
    ]
}

fn platform(base: &BaseConfig) -> Item {
    let drive = match base.drive {
        Drive::Synchro { .. } => "synchro drive",
        Drive::Differential { .. } => "differential drive",
        Drive::Bicycle { .. } => "steered like a bicycle",
    };
    let (radius, speed, rate) = (base.radius, base.speed, base.turn_rate.to_degrees());
    Item::new(&base.name, format!("{drive}, radius {radius:.2} m, up to {speed:.1} m/s and {rate:.0} deg/s"))
}

/// Where worlds lie, below the directory in which the program is called.
const WORLDS: &str = "configs/worlds";

/// Worlds that lie here, and those that are built in.
fn worlds() -> Vec<Item> {
    let mut found: Vec<Item> = Vec::new();
    let mut files: Vec<_> = fs::read_dir(WORLDS).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    files.sort();
    for path in files.iter().filter(|path| path.extension().is_some_and(|end| end == "toml")) {
        let Some(name) = path.file_name() else { continue };
        let name = Path::new("worlds").join(name);
        found.push(Item::new(name.display().to_string(), fs::read_to_string(path).map(|text| about(&text)).unwrap_or_default()));
    }
    for (name, bytes) in embedded_files().filter(|(name, _)| name.starts_with("worlds/")) {
        if !found.iter().any(|item| item.name == name) {
            found.push(Item::new(name, about(&String::from_utf8_lossy(&bytes))));
        }
    }
    found
}

/// The comment with which a file begins: its first sentence.
fn about(text: &str) -> String {
    let lines = text
        .lines()
        .skip_while(|line| line.starts_with("#:"))
        .map_while(|line| line.strip_prefix('#'))
        .map(str::trim)
        .take_while(|line| !line.is_empty());
    let comment = lines.collect::<Vec<_>>().join(" ");
    comment.split(". ").next().unwrap_or_default().trim_end_matches('.').to_owned()
}
