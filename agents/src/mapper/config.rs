//! The parameters of the mapper.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::certainty_grid::{Rules, Thresholds, decay::DecayConfig, marking::MarkingConfig, pairs::PairConfig, rcd::RcdConfig};

/// How the robot maps its surroundings. The numbers are those of Good (1992) except where the documentation of a key says
/// otherwise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Edge of a cell, m. (The source: 0.2, suited to a 33 cm robot that plans its way cell by cell; 0.1 makes better pictures.)
    #[schemars(range(min = 0.02, max = 1.0))]
    pub cell: f64,
    /// Width of the map along x, m; in a map that grows, the width at the start.
    #[schemars(range(min = 1.0, max = 500.0))]
    pub width: f64,
    /// Height of the map along y, m; in a map that grows, the height at the start.
    #[schemars(range(min = 1.0, max = 500.0))]
    pub height: f64,
    /// What happens when the robot comes near the edge of the map.
    pub extent: Extent,
    /// Probability that ground nobody has looked at is occupied.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub background: f32,
    /// Where free and occupied cells begin.
    pub thresholds: Thresholds,
    /// A reading of emptiness that leaves a cell's confidence at or below this removes what is left of its probability.
    #[schemars(range(min = -6.0, max = 0.0))]
    pub residue_confidence: f32,
    /// How readings are drawn.
    pub marking: MarkingConfig,
    /// How far readings are believed.
    pub regions: RcdConfig,
    /// How transducers are fused in pairs.
    pub pairs: PairConfig,
    /// Transducers, by their number in the ring, that only mark objects and only nearby ones: those that look along
    /// a wall and are deceived by it. (The source: the two at ±45° of its front arrangement.)
    #[schemars(length(max = 32), inner(range(min = 0, max = 31)))]
    pub short_sighted: Vec<u8>,
    /// How far short-sighted transducers are believed, m.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub short_sight: f64,
    /// Whether something nearer than the ring's minimum range is marked as an object at that range.
    pub mark_too_near: bool,
    /// The ground that the robot has driven over.
    pub trail: TrailConfig,
    /// Whether and how the map fades as the robot moves.
    pub decay: DecayConfig,
    /// Take every n-th scan only; a fast ring says the same many times.
    #[schemars(range(min = 1, max = 1000))]
    pub every: u32,
    /// Seconds from one picture of the map in the recording to the next; 0 for none.
    #[schemars(range(min = 0.0, max = 86_400.0))]
    pub picture_period: f64,
}

/// What happens at the edge of the map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Extent {
    /// The window moves with the robot and forgets what it leaves behind: constant memory, for navigation.
    Recentre {
        /// The window moves when the robot comes nearer to its edge than this, m.
        #[schemars(range(min = 0.0, max = 100.0))]
        margin: f64,
    },
    /// The map grows and forgets nothing: for mapping a whole building.
    Grow {
        /// It grows by multiples of this, m.
        #[schemars(range(min = 1.0, max = 100.0))]
        block: f64,
        /// It never covers more than this, m²; readings beyond are dropped.
        #[schemars(range(min = 100.0, max = 250000.0))]
        most_area: f64,
    },
}

impl Default for Extent {
    fn default() -> Self {
        Self::Grow { block: 8.0, most_area: 40_000.0 }
    }
}

/// The ground that the robot has driven over, which is free beyond doubt.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrailConfig {
    /// Cells whose centre was nearer to the robot's centre than this are free, m; 0 marks only the cells its centre crossed, as
    /// the source does. Not more than the robot's radius.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub radius: f64,
    /// A move longer than this between two poses, m, is a correction of the pose, not a path driven.
    #[schemars(range(min = 0.05, max = 10.0))]
    pub longest_move: f64,
}

impl Default for TrailConfig {
    fn default() -> Self {
        Self { radius: 0.15, longest_move: 1.0 }
    }
}

impl Default for Config {
    fn default() -> Self {
        Self {
            cell: 0.1,
            width: 20.0,
            height: 20.0,
            extent: Extent::default(),
            background: 0.5,
            thresholds: Thresholds::default(),
            residue_confidence: -1.0,
            marking: MarkingConfig::default(),
            regions: RcdConfig::default(),
            pairs: PairConfig::default(),
            short_sighted: Vec::new(),
            short_sight: 1.0,
            mark_too_near: true,
            trail: TrailConfig::default(),
            decay: DecayConfig::default(),
            every: 1,
            picture_period: 60.0,
        }
    }
}

impl Config {
    /// The settings of the source: 100 × 100 cells of 20 cm that follow the robot, every reading drawn to its full reach, nothing
    /// done against silence but the narrow cone.
    #[must_use]
    pub fn luey() -> Self {
        use crate::certainty_grid::marking::{Occlusion, SilenceConfig};
        let silence = SilenceConfig { clear_to: 6.0, most_weight: 6, spare_at: 7.0 };
        Self {
            cell: 0.2,
            extent: Extent::Recentre { margin: 3.0 },
            marking: MarkingConfig {
                clear_to: 6.0,
                object_within: 6.0,
                silence,
                occlusion: Occlusion::None,
                ..MarkingConfig::default()
            },
            trail: TrailConfig { radius: 0.0, ..TrailConfig::default() },
            ..Self::default()
        }
    }

    /// The rules of the grid.
    #[must_use]
    pub fn rules(&self) -> Rules {
        Rules {
            background: self.background,
            edge_background: self.background,
            thresholds: self.thresholds,
            residue_confidence: self.residue_confidence,
        }
    }
}
