//! A small catalogue, as a library of behaviours and drivers would give, and a mission that uses most of it.
#![allow(clippy::unwrap_used, missing_docs, dead_code)]

use orienteer_runtime::config::{
    Mission, Problems, Sources,
    mission::{AgentInfo, Catalog, DriverInfo},
    validate::schema_of,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

macro_rules! keys {
    ($(#[$doc:meta])* $name:ident { $($(#[$key_doc:meta])* $key:ident: $type:ty = $default:expr,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name { $($(#[$key_doc])* pub $key: $type,)* }
        impl Default for $name { fn default() -> Self { Self { $($key: $default,)* } } }
    };
}

keys! { WhereAmI {
    /// Growth of the variance of the heading, rad²/rad.
    #[schemars(range(min = 0.0, max = 1.0))]
    heading_variance: f64 = 0.001,
} }

keys! { Avoidance {
    /// Nearest distance that is left to an obstacle, m.
    #[schemars(range(min = 0.05, max = 2.0))]
    clearance: f64 = 0.4,
    /// Speed while giving way, m/s.
    #[schemars(range(min = 0.0, max = 1.0))]
    escape_speed: f64 = 0.2,
    /// How it gives way.
    strategy: Strategy = Strategy::Stop,
} }

/// How to give way.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Strategy {
    /// Stand still.
    Stop,
    /// Back away.
    Retreat {
        /// At most this far, m.
        #[schemars(range(min = 0.1, max = 5.0))]
        distance: f64,
    },
}

keys! { Follower {
    /// Speed along the corridor, m/s.
    #[schemars(range(min = 0.01, max = 1.0))]
    speed: f64 = 0.3,
    /// Which wall to follow.
    side: Side = Side::Both,
    /// Widths that count as a corridor, m.
    width: (f64, f64) = (1.0, 3.0),
} }

/// A wall.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Port.
    Left,
    /// Starboard.
    Right,
    /// The middle between them.
    Both,
}

keys! { Mapper {
    /// Edge of a cell, m.
    #[schemars(range(min = 0.01, max = 1.0))]
    cell: f64 = 0.1,
    /// Where the picture goes.
    picture: Option<String> = None,
} }

keys! { SimBase {
    /// The kind of base.
    #[schemars(extend("x-names" = "platform"))]
    platform: String = "b12-huey".into(),
    /// Standard deviation of measured distances, as a share of them.
    #[schemars(range(min = 0.0, max = 0.5))]
    odometry_noise: f64 = 0.0,
} }

keys! { SimSonar {
    /// The ring.
    #[schemars(extend("x-names" = "ring"))]
    ring: String = "denning-16".into(),
    /// Standard deviation of a range, m.
    #[schemars(range(min = 0.0, max = 0.5))]
    noise: f64 = 0.01,
} }

/// A robot on a serial line.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Arcos {
    /// The serial port.
    port: String,
    /// Bits per second.
    #[serde(default)]
    baud: Option<u32>,
}

pub struct Fake {
    agents: Vec<(&'static str, AgentInfo)>,
    bases: Vec<(&'static str, DriverInfo)>,
    sonars: Vec<(&'static str, DriverInfo)>,
}

fn agent<T: JsonSchema>(help: &str, reads: &[&str], writes: &[&str], priority: u8) -> AgentInfo {
    let owned = |topics: &[&str]| topics.iter().map(|topic| (*topic).to_owned()).collect();
    let takes_base = writes.contains(&"base/claims");
    AgentInfo { schema: schema_of::<T>(), help: help.into(), reads: owned(reads), writes: owned(writes), takes_base, priority }
}

fn driver<T: JsonSchema>(help: &str, writes: &[&str], needs_world: bool) -> DriverInfo {
    let writes = writes.iter().map(|topic| (*topic).to_owned()).collect();
    DriverInfo { schema: schema_of::<T>(), help: help.into(), writes, needs_world }
}

impl Default for Fake {
    fn default() -> Self {
        let base = ["base/odometry", "base/motion"];
        Self {
            agents: vec![
                ("where-am-i", agent::<WhereAmI>("Keeps the robot's pose.", &["base/odometry"], &["pose"], 0)),
                (
                    "avoidance",
                    agent::<Avoidance>("Steps aside for people.", &["sonar/scan"], &["base/claims", "sonar/claims"], 10),
                ),
                (
                    "corridor-follower",
                    agent::<Follower>("Drives along corridors.", &["sonar/scan", "pose"], &["base/claims", "corridor/report"], 5),
                ),
                ("mapper", agent::<Mapper>("Draws the map.", &["sonar/scan", "pose"], &[], 0)),
            ],
            bases: vec![
                ("sim", driver::<SimBase>("A simulated base.", &[base[0], base[1], "truth"], true)),
                ("arcos", driver::<Arcos>("A Pioneer or AmigoBot.", &base, false)),
            ],
            sonars: vec![
                ("sim", driver::<SimSonar>("A simulated sonar.", &["sonar/scan"], true)),
                ("arcos", driver::<Arcos>("The sonar of a Pioneer.", &["sonar/scan"], false)),
            ],
        }
    }
}

fn find<'a, T>(list: &'a [(&'static str, T)], name: &str) -> Option<&'a T> {
    list.iter().find(|(known, _)| *known == name).map(|(_, info)| info)
}

fn all<T>(list: &[(&'static str, T)]) -> Vec<String> {
    list.iter().map(|(name, _)| (*name).to_owned()).collect()
}

impl Catalog for Fake {
    fn agent(&self, kind: &str) -> Option<&AgentInfo> {
        find(&self.agents, kind)
    }
    fn agent_kinds(&self) -> Vec<String> {
        all(&self.agents)
    }
    fn base_driver(&self, name: &str) -> Option<&DriverInfo> {
        find(&self.bases, name)
    }
    fn base_drivers(&self) -> Vec<String> {
        all(&self.bases)
    }
    fn sonar_driver(&self, name: &str) -> Option<&DriverInfo> {
        find(&self.sonars, name)
    }
    fn sonar_drivers(&self) -> Vec<String> {
        all(&self.sonars)
    }
    fn names(&self, sort: &str) -> Vec<String> {
        let names: &[&str] = match sort {
            "ring" => &["denning-16", "luey-8", "yamabico-12"],
            "platform" => &["b12-huey", "wheelchair", "p3-dx"],
            _ => &[],
        };
        names.iter().map(|name| (*name).to_owned()).collect()
    }
}

pub const WORLD: &str = "# an empty world\n";

/// A mission with templates on templates, overrides, repetition, and every table.
pub const MISSION: &str = r#"#:schema orienteer.schema.json
[mission]
name = "office floor"
duration = 600.0
seed = 7
clock = "lockstep"
control_rate_hz = 20
links = "shared"
threads = 2

[world]
file = "worlds/office.toml"

[record]
file = "out/office.mcap"
enabled = true

[template.sonar-robot]
sonar = { driver = "sim", ring = "denning-16", noise = 0.02 }

[template.sonar-robot.agent.where-am-i]
heading_variance = 0.002

[template.huey]
template = "sonar-robot"
base = { driver = "sim", platform = "b12-huey" }
start = { heading_deg = 90 }

[template.huey.agent.avoidance]
priority = 20
deadline_ms = 5.0
clearance = 0.5
strategy = { kind = "retreat", distance = 0.7 }

[template.huey.agent.corridor-follower]
speed = 0.3
side = "both"
width = [1.0, 2.5]

[[robot]]
name = "ann"
template = "huey"
start = { x = 1.0, y = 2.0 }

[robot.agent.draw]
kind = "mapper"
cell = 0.05

[[robot]]
name = "bob"
template = "huey"
count = 3
start = { place = "north" }
spacing = { x = 2.0, y = 1.5, columns = 2 }

[robot.agent.corridor-follower]
speed = 0.2

[[robot]]
name = "real"
template = "huey"
base = { driver = "arcos", port = "/dev/ttyUSB0" }
sonar = { driver = "arcos", port = "/dev/ttyUSB0" }
start = { x = 0.0, y = 0.0 }

[robot.agent.avoidance]
enabled = false
"#;

/// The sources of a mission that stands in `mission.toml`.
pub fn sources(text: &str) -> Sources {
    Sources::embedded([
        ("mission.toml".to_owned(), text.as_bytes().to_vec()),
        ("worlds/office.toml".to_owned(), WORLD.as_bytes().to_vec()),
    ])
}

pub fn load(text: &str) -> Result<Mission, Problems> {
    load_with(text, &Fake::default())
}

pub fn load_with(text: &str, catalog: &Fake) -> Result<Mission, Problems> {
    let mut sources = sources(text);
    let id = sources.read("mission.toml")?;
    Mission::load(&mut sources, id, catalog)
}
