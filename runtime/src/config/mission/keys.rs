//! The keys of a mission file, as types. Schema, checks and documentation all come from here.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::link::Backend;

/// A mission can't have more threads than this.
pub const MOST_THREADS: u16 = 256;

/// An Orienteer mission: which robots, in which world, for how long.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MissionFile {
    /// The mission as a whole.
    pub mission: MissionKeys,
    /// The world in which simulated robots live.
    pub world: WorldKeys,
    /// What is recorded.
    pub record: RecordKeys,
    /// Named sets of keys that robots can be based on.
    pub template: BTreeMap<String, TemplateKeys>,
    /// The robots.
    pub robot: Vec<RobotKeys>,
}

/// The mission as a whole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MissionKeys {
    /// What to call the mission; the file's name unless given.
    pub name: String,
    /// How long it lasts, s.
    #[schemars(range(min = 0.001, max = 2_678_400.0))]
    pub duration: f64,
    /// Every random number of the run follows from it.
    pub seed: u64,
    /// What drives time forward.
    pub clock: ClockKind,
    /// How many times faster than life simulated time goes; as fast as it can unless given.
    #[schemars(range(min = 0.001, max = 1_000_000.0))]
    pub speed: Option<f64>,
    /// Control steps per second of every robot, Hz. Sonar readings would be too old to drive by below 5 Hz.
    #[schemars(range(min = 5.0, max = 1000.0))]
    pub control_rate_hz: f64,
    /// What topics are carried by.
    pub links: Backend,
    /// A name under which other processes of this user may attach to the running mission (`links = "shared"`): monitors, recorders,
    /// drivers. Nobody can unless given.
    pub run: Option<String>,
    /// Threads that robots are spread over; unless given, one for every eight robots, but no more than there are cores. Never changes
    /// the result.
    #[schemars(range(min = 1, max = MOST_THREADS))]
    pub threads: Option<u16>,
}

impl Default for MissionKeys {
    fn default() -> Self {
        Self {
            name: String::new(),
            duration: 60.0,
            seed: 1,
            clock: ClockKind::Lockstep,
            speed: None,
            control_rate_hz: 20.0,
            links: Backend::Shared,
            run: None,
            threads: None,
        }
    }
}

/// What drives time forward.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ClockKind {
    /// Simulated time: the next step begins when all robots have finished the last.
    #[default]
    Lockstep,
    /// The machine's clock, as real robots need it.
    Wall,
}

/// The world in which simulated robots live.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WorldKeys {
    /// A TOML world, relative to this file.
    pub file: Option<String>,
    /// A map in the form of the ROS map server (`.yaml`), relative to this file.
    pub map: Option<String>,
}

/// What is recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RecordKeys {
    /// False for none.
    pub enabled: bool,
    /// The recording (`.mcap`), in the output directory; named after the mission unless given.
    pub file: Option<String>,
}

impl Default for RecordKeys {
    fn default() -> Self {
        Self { enabled: true, file: None }
    }
}

/// A named set of keys that robots, and other templates, can be based on.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TemplateKeys {
    /// The template that this one is based on.
    pub template: Option<String>,
    /// How many robots to make; their names get a number from 1.
    #[schemars(range(min = 1, max = 10_000))]
    pub count: Option<u32>,
    /// Where the robot begins: at the origin, heading along x, unless given.
    pub start: Option<StartKeys>,
    /// How repeated robots stand from each other.
    pub spacing: Option<SpacingKeys>,
    /// Which process has base and sonar: this one, or `orienteer hardware`.
    pub hardware: Option<HardwarePlace>,
    /// The base and its driver.
    pub base: Option<BaseTable>,
    /// The sonar ring and its driver.
    pub sonar: Option<SonarTable>,
    /// The behaviours, each under the name it has on this robot.
    pub agent: BTreeMap<String, AgentTable>,
}

/// A robot, or several alike.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotKeys {
    /// Its name, also the first part of its topics: a letter, then letters, digits, `-` or `_`.
    pub name: String,
    /// The template that it is based on.
    #[serde(default)]
    pub template: Option<String>,
    /// How many robots to make; their names get a number from 1.
    #[serde(default)]
    #[schemars(range(min = 1, max = 10_000))]
    pub count: Option<u32>,
    /// Where it begins: at the origin, heading along x, unless given.
    #[serde(default)]
    pub start: Option<StartKeys>,
    /// How repeated robots stand from each other.
    #[serde(default)]
    pub spacing: Option<SpacingKeys>,
    /// Which process has base and sonar: this one, or `orienteer hardware`.
    #[serde(default)]
    pub hardware: Option<HardwarePlace>,
    /// The base and its driver.
    #[serde(default)]
    pub base: Option<BaseTable>,
    /// The sonar ring and its driver.
    #[serde(default)]
    pub sonar: Option<SonarTable>,
    /// The behaviours, each under the name it has on this robot.
    #[serde(default)]
    pub agent: BTreeMap<String, AgentTable>,
}

/// Which process has a robot's base and sonar.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HardwarePlace {
    /// The process that runs the mission.
    #[default]
    Here,
    /// One of its own, which `orienteer hardware` starts with the same configuration.
    Elsewhere,
}

/// Where a robot begins: `x` and `y`, or a place of the world.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StartKeys {
    /// World frame, m.
    #[schemars(range(min = -100_000.0, max = 100_000.0))]
    pub x: Option<f64>,
    /// World frame, m.
    #[schemars(range(min = -100_000.0, max = 100_000.0))]
    pub y: Option<f64>,
    /// Counter-clockwise from the x axis, degrees; 0, or the place's own, unless given.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub heading_deg: Option<f64>,
    /// The name of a place of the world.
    pub place: Option<String>,
}

/// How repeated robots stand from each other: in rows, the first at `start`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpacingKeys {
    /// From one robot of a row to the next, along the world's x axis, m.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub x: f64,
    /// From one row to the next, along the world's y axis, m.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub y: f64,
    /// Robots in a row.
    #[schemars(range(min = 1, max = 10_000))]
    pub columns: u32,
}

impl Default for SpacingKeys {
    fn default() -> Self {
        Self { x: 2.0, y: 2.0, columns: 10 }
    }
}

/// The base: which driver, and that driver's own keys.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(extend("additionalProperties" = true))]
pub struct BaseTable {
    /// The driver that moves the base.
    pub driver: Option<String>,
}

/// The sonar: which driver, and that driver's own keys.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(extend("additionalProperties" = true))]
pub struct SonarTable {
    /// The driver that fires the sonar.
    pub driver: Option<String>,
}

/// A behaviour: the keys that all share, and its kind's own.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(extend("additionalProperties" = true))]
pub struct AgentTable {
    /// What kind of agent it is; its name unless given.
    pub kind: Option<String>,
    /// Who wins when several want the base or the sonar: the highest number.
    pub priority: Option<u8>,
    /// False to leave it out.
    pub enabled: bool,
    /// A step that takes longer is counted and reported, ms.
    #[schemars(range(min = 0.01, max = 60_000.0))]
    pub deadline_ms: Option<f64>,
}

impl Default for AgentTable {
    fn default() -> Self {
        Self { kind: None, priority: None, enabled: true, deadline_ms: None }
    }
}
