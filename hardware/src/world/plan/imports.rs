//! Worlds that come from files: maps and floor plans.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{super::map::Unknown, Xy, hard};

/// A map of the ROS map server; resolution, origin and thresholds are in its YAML file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RosMap {
    /// The YAML file, relative to the world file.
    pub file: PathBuf,
    /// What a cell is that nobody has looked into. Beyond the edge of the map everything is free.
    #[serde(default)]
    pub unknown: Unknown,
    /// Patches of fewer cells than this, solid or free, are taken for noise and dropped.
    #[serde(default = "min_speck")]
    #[schemars(range(min = 0, max = 10_000))]
    pub min_speck: u32,
    /// How far a traced wall may lie beside the cells' edges, in cells. Below 0.71 a diagonal stays a staircase, which
    /// would scatter sound that a wall reflects.
    #[serde(default = "tolerance")]
    #[schemars(range(min = 0.0, max = 5.0))]
    pub tolerance: f64,
    /// Echo amplitude as a share of a hard, smooth wall's.
    #[serde(default = "hard")]
    #[schemars(range(min = 0.01, max = 1.0))]
    pub reflectance: f64,
}

impl RosMap {
    /// A map with everything else as usual.
    #[must_use]
    pub fn of(file: impl Into<PathBuf>) -> Self {
        let (min_speck, tolerance, reflectance) = (min_speck(), tolerance(), hard());
        Self { file: file.into(), unknown: Unknown::default(), min_speck, tolerance, reflectance }
    }
}

/// A picture with a scale: dark is solid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FloorPlan {
    /// The picture (PNG, PGM, PPM), relative to the world file.
    pub file: PathBuf,
    /// Metres per pixel.
    #[schemars(range(min = 0.001, max = 5.0))]
    pub resolution: f64,
    /// Where the picture's lower left corner lies, m.
    #[serde(default = "zero")]
    pub origin: Xy,
    /// How far the picture is turned about that corner, degrees, counter-clockwise.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation_deg: f64,
    /// Brightness from 0 (black) to 255 (white); what is darker than this is solid.
    #[serde(default = "half_bright")]
    #[schemars(range(min = 1, max = 255))]
    pub threshold: u8,
    /// True if bright is solid instead.
    #[serde(default)]
    pub negate: bool,
    /// Patches of fewer pixels than this, solid or free, are taken for noise and dropped.
    #[serde(default = "min_speck")]
    #[schemars(range(min = 0, max = 10_000))]
    pub min_speck: u32,
    /// How far a traced wall may lie beside the pixels' edges, in pixels.
    #[serde(default = "tolerance")]
    #[schemars(range(min = 0.0, max = 5.0))]
    pub tolerance: f64,
    /// Echo amplitude as a share of a hard, smooth wall's.
    #[serde(default = "hard")]
    #[schemars(range(min = 0.01, max = 1.0))]
    pub reflectance: f64,
}

fn min_speck() -> u32 {
    4
}

fn tolerance() -> f64 {
    0.75
}

fn zero() -> Xy {
    Xy([0.0, 0.0])
}

fn half_bright() -> u8 {
    128
}
