//! Draws one reading into the grid: an empty cone up to the echo and an arc of occupied cells where it came from
//! (Good 1992, §2.3.1).
//!
//! The cone is narrower than the beam, since surfaces that the edge of the beam meets at a grazing angle are the
//! least likely to answer. The arc is one cell thick; cone and arc share a circle, so no cell gets both from one reading.
//!
//! What ruins sonar maps is the *false empty*: a wall met at a grazing angle throws the sound away, and the transducer
//! hears nothing, or the echo of something that the sound met after a bounce. The cone then reaches through the wall. Four
//! remedies, each of them to be had alone:
//!
//! * silence clears no farther than [`SilenceConfig::clear_to`], and its weight is capped ([`SilenceConfig::most_weight`]);
//! * silence leaves cells alone that are firmly occupied ([`SilenceConfig::spare_at`]): such cells have been seen again
//!   and again, mostly from nearby and head-on, and a transducer that hears nothing is the weaker witness;
//! * a reading does not see through walls ([`Occlusion`]): where its axis first meets a firmly occupied cell, silence ends
//!   its cone before the wall. An echo from behind the wall wears the wall down (it may have been a person who left), but
//!   neither clears nor marks anything behind it until the wall is gone;
//! * echoes from afar mark wide arcs of doubtful use, and in corridors many of them come by way of a wall:
//!   [`MarkingConfig::object_within`] and [`MarkingConfig::clear_to`] cut them off.
//!
//! The source has none of these but the narrow cone. The defaults suit corridors; in halls larger than twice
//! `object_within` raise it.

use nalgebra::{Point2, Vector2};
use orienteer_runtime::geometry::{Pose, angle};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    Grid, level,
    ray::first_wall,
    sector::{Coverage, Lattice, Sector},
    update::Update,
};

/// How readings are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MarkingConfig {
    /// Half the opening angle of the empty cone and of the arc, degrees. Narrower than the beam on purpose; a transducer whose
    /// beam is narrower still keeps its own.
    #[schemars(range(min = 0.5, max = 45.0))]
    pub half_angle_deg: f64,
    /// Which cells count as lying in a cone.
    pub coverage: Coverage,
    /// An echo clears the cone before it no farther than this, m. (The source: the sonars' reach, 6 m.)
    #[schemars(range(min = 0.0, max = 30.0))]
    pub clear_to: f64,
    /// An echo from farther away than this, m, marks no object: its arc would be too wide to mean anything. (The source: 6 m.)
    #[schemars(range(min = 0.0, max = 30.0))]
    pub object_within: f64,
    /// What silence may do.
    pub silence: SilenceConfig,
    /// Which readings are stopped by walls that the map already knows.
    pub occlusion: Occlusion,
    /// Confidence from which on an occupied cell counts as a wall that readings can't pass.
    #[schemars(range(min = 1.0, max = 6.0))]
    pub wall_confidence: f32,
}

/// What a transducer that heard nothing may do to the map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SilenceConfig {
    /// Silence clears its cone no farther than this, m. (The source: 6.)
    #[schemars(range(min = 0.0, max = 30.0))]
    pub clear_to: f64,
    /// The greatest weight of silence. (The source: 6.)
    #[schemars(range(min = 1, max = 6))]
    pub most_weight: u8,
    /// Silence leaves cells alone whose confidence is at least this; more than 6 spares none. (The source: none.)
    #[schemars(range(min = 1.0, max = 7.0))]
    pub spare_at: f32,
}

/// Which readings are stopped by cells that are firmly occupied.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Occlusion {
    /// None: as in the source.
    None,
    /// Silence only.
    Silence,
    /// Silence, and echoes from behind a wall.
    #[default]
    All,
}

impl Default for MarkingConfig {
    fn default() -> Self {
        Self {
            half_angle_deg: 8.0,
            coverage: Coverage::default(),
            clear_to: 3.0,
            object_within: 3.0,
            silence: SilenceConfig::default(),
            occlusion: Occlusion::default(),
            wall_confidence: 3.0,
        }
    }
}

impl Default for SilenceConfig {
    fn default() -> Self {
        Self { clear_to: 1.5, most_weight: 1, spare_at: 2.0 }
    }
}

/// What a reading says about an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Probability that the arc's cells are given.
    pub value: f32,
    /// Half the arc's opening angle, rad.
    pub half_angle: f64,
    /// Bearing of the arc's middle as seen from the axis, rad.
    pub aside: f64,
}

/// One reading, of one transducer or of a pair, ready to be drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Where the sound left and which way, map frame.
    pub face: Pose,
    /// How far away the echo came from; the maximum range for silence, m.
    pub range: f64,
    /// True if nothing was heard.
    pub silent: bool,
    /// Weight, 1 to 6.
    pub weight: f32,
    /// Half the opening angle of the empty cone, rad; `None` leaves it out.
    pub cone: Option<f64>,
    /// The object; ignored for silence.
    pub object: Option<Arc>,
}

/// Draws readings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Marker {
    config: MarkingConfig,
}

/// A reading and how far it reaches in the map as it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Cells nearer than this are cleared, m.
    clear_to: f64,
    /// Whether the object is where the reading says.
    object: bool,
}

impl Marker {
    /// A marker with these settings.
    #[must_use]
    pub fn new(config: MarkingConfig) -> Self {
        Self { config }
    }

    /// How far a reading reaches, given the walls in the map. Ask for all readings of a scan before drawing any of them, so that
    /// their order does not matter.
    #[must_use]
    pub fn sight(&self, grid: &Grid, reading: &Reading) -> Sight {
        let MarkingConfig { occlusion, silence, .. } = self.config;
        let cell = grid.cell_size();
        let nominal = if reading.silent {
            reading.range.min(silence.clear_to)
        } else {
            (reading.range - 0.5 * thickness(reading, cell)).min(self.config.clear_to)
        };
        let open = Sight { clear_to: nominal, object: reading.range <= self.config.object_within };
        let stopped = match occlusion {
            Occlusion::None => false,
            Occlusion::Silence => reading.silent,
            Occlusion::All => true,
        };
        let wall = if stopped { first_wall(grid, &reading.face, nominal - cell, self.config.wall_confidence) } else { None };
        match wall {
            Some(wall) if reading.silent => Sight { clear_to: wall, object: false },
            // Two cells on reach through a wall that is one cell thick, at any angle.
            Some(wall) => Sight { clear_to: nominal.min(wall + 2.0 * cell), object: false },
            None => open,
        }
    }

    /// Draws the empty cone of a reading. Draw all cones of a scan before its objects, so that no cone wipes out the object
    /// that another transducer has just seen.
    pub fn clear(&self, grid: &mut Grid, reading: &Reading, sight: Sight) {
        let Some(half_angle) = reading.cone else { return };
        let sector = Sector {
            apex: reading.face.point(),
            bearing: reading.face.heading,
            half_angle,
            inner: 0.0,
            outer: sight.clear_to,
            coverage: self.config.coverage,
        };
        let update = Update::new(level::HIGH_EMPTY, reading.weight, grid.rules());
        let update = if reading.silent { update.sparing(self.config.silence.spare_at) } else { update };
        draw(grid, &sector, update);
    }

    /// Draws the object of a reading. An echo marks at least one cell.
    pub fn mark(&self, grid: &mut Grid, reading: &Reading, sight: Sight) {
        let Some(arc) = reading.object.filter(|_| sight.object && !reading.silent) else { return };
        let half = 0.5 * thickness(reading, grid.cell_size());
        let sector = Sector {
            apex: reading.face.point(),
            bearing: angle::wrap(reading.face.heading + arc.aside),
            half_angle: arc.half_angle,
            inner: (reading.range - half).max(0.0),
            outer: reading.range + half,
            coverage: self.config.coverage,
        };
        let update = Update::new(arc.value, reading.weight, grid.rules());
        if draw(grid, &sector, update) == 0
            && let Some(point) = behind(grid, &sector)
        {
            let index = grid.index_of(point);
            if let Some(slot) = grid.slot(index) {
                update.apply(&mut grid.probabilities[slot..=slot], &mut grid.confidences[slot..=slot]);
            }
        }
    }
}

/// Radial thickness of the arc, m: thin enough for a line of cells joined at least by their corners; a short arc is
/// thicker, so that it does not slip between cell centres.
fn thickness(reading: &Reading, cell: f64) -> f64 {
    let (half_angle, aside) = reading.object.map_or((0.0, 0.0), |arc| (arc.half_angle, arc.aside));
    let (sin, cos) = (reading.face.heading + aside).sin_cos();
    let short = reading.range * half_angle < 1.5 * cell;
    cell * if short { sin.abs() + cos.abs() } else { sin.abs().max(cos.abs()) }
}

/// A point on or shortly behind the arc's middle whose cell the cone can't have cleared.
fn behind(grid: &Grid, arc: &Sector) -> Option<Point2<f64>> {
    let axis = Vector2::new(arc.bearing.cos(), arc.bearing.sin());
    let middle = 0.5 * (arc.inner + arc.outer);
    let along = |quarter: i32| arc.apex + axis * (middle + 0.25 * f64::from(quarter) * grid.cell_size());
    (0..8).map(along).find(|point| (grid.centre_of(grid.index_of(*point)) - arc.apex).norm() >= arc.inner)
}

/// Applies an update to all cells of a sector and returns how many there are.
fn draw(grid: &mut Grid, sector: &Sector, update: Update) -> usize {
    let (lattice, width) = (Lattice::of(grid), grid.width());
    let mut cells = 0;
    sector.for_each_run(&lattice, |row, run| {
        let run = row * width + run.start..row * width + run.end;
        cells += run.len();
        update.apply(&mut grid.probabilities[run.clone()], &mut grid.confidences[run]);
    });
    cells
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;
    use crate::certainty_grid::{CellIndex, Layout, Rules};

    fn grid(cell: f64) -> Grid {
        Grid::new(Layout::around(Point2::origin(), cell, 8.0, 8.0), Rules::default()).unwrap()
    }

    fn reading(face: Pose, range: f64) -> Reading {
        let half_angle = 8f64.to_radians();
        let object = Some(Arc { value: level::HIGH_OCCUPIED, half_angle, aside: 0.0 });
        Reading { face, range, silent: false, weight: 1.0, cone: Some(half_angle), object }
    }

    /// The defaults, with the full reach of the sonars.
    fn far() -> MarkingConfig {
        MarkingConfig { clear_to: 6.0, object_within: 6.0, ..MarkingConfig::default() }
    }

    fn draw_reading(config: MarkingConfig, grid: &mut Grid, reading: &Reading) {
        let marker = Marker::new(config);
        let sight = marker.sight(grid, reading);
        marker.clear(grid, reading, sight);
        marker.mark(grid, reading, sight);
    }

    proptest! {
        #[test]
        fn a_reading_changes_a_cell_once_and_marks_its_object(
            x in -1.0..1.0f64, y in -1.0..1.0f64, heading in -3.1..3.1f64, range in 0.02..2.5f64, half_deg in 1.0..30.0f64, cell in 0.05..0.3f64,
        ) {
            let mut grid = grid(cell);
            let half_angle = half_deg.to_radians();
            let object = Some(Arc { value: 1.0, half_angle, aside: 0.0 });
            let reading = Reading { cone: Some(half_angle), object, ..reading(Pose::new(x, y, heading), range) };
            draw_reading(MarkingConfig::default(), &mut grid, &reading);
            // |F| counts the updates
            prop_assert!(grid.confidences().iter().all(|f| f.abs() <= 1.0));
            let arc: Vec<_> = (0..grid.height() as i32)
                .flat_map(|row| (0..grid.width() as i32).map(move |column| CellIndex::new(column, row)))
                .filter(|index| grid.confidence(*index) > 0.0)
                .collect();
            prop_assert!(!arc.is_empty());
            for index in arc {
                let seen = grid.centre_of(index) - reading.face.point();
                let off = (seen.norm() - range).abs();
                prop_assert!(off < 2.5 * cell, "{off}");
                let aside = angle::turn(heading, seen.y.atan2(seen.x)).abs();
                prop_assert!(aside <= half_angle || seen.norm() * (aside - half_angle).sin() < 1.5 * cell);
            }
        }
    }

    #[test]
    fn the_cone_is_empty_and_the_arc_occupied() {
        let mut grid = grid(0.1);
        draw_reading(far(), &mut grid, &reading(Pose::new(0.05, 0.05, 0.0), 2.0));
        let at = |x: f64, y: f64| grid.confidence(grid.index_of(Point2::new(x, y)));
        for i in 0..19 {
            assert_eq!(at(0.15 + 0.1 * f64::from(i), 0.05), -1.0, "{i}");
        }
        for y in [-0.25, -0.15, -0.05, 0.05, 0.15, 0.25] {
            assert_eq!(at(2.05, y), 1.0);
            assert_eq!(at(2.15, y), 0.0);
        }
        assert_eq!(at(1.0, 0.25), 0.0);
        assert_eq!(at(-0.05, 0.05), 0.0);
    }

    #[test]
    fn silence_clears_a_little_and_marks_nothing() {
        let mut grid = grid(0.1);
        let config = far();
        let silent = Reading { silent: true, ..reading(Pose::new(0.05, 0.05, 0.0), 3.9) };
        draw_reading(config, &mut grid, &silent);
        assert!(grid.confidences().iter().all(|f| *f <= 0.0));
        let reach = config.silence.clear_to;
        assert_eq!(grid.confidence(grid.index_of(Point2::new(reach - 0.1, 0.05))), -1.0);
        assert_eq!(grid.confidence(grid.index_of(Point2::new(reach + 0.2, 0.05))), 0.0);
    }

    fn with_wall(confidence: f32) -> Grid {
        let mut grid = grid(0.1);
        for row in -10..10 {
            let middle = grid.index_of(Point2::new(1.05, 0.05));
            grid.restore(middle.offset(0, row), 1.0, confidence);
        }
        grid
    }

    #[test]
    fn silence_spares_what_is_firm() {
        let face = Pose::new(0.05, 0.05, 0.0);
        let silent = Reading { silent: true, ..reading(face, 3.9) };
        let config = MarkingConfig { occlusion: Occlusion::None, ..far() };
        for (confidence, after) in [(6.0, 6.0), (config.silence.spare_at, config.silence.spare_at), (1.0, 0.0)] {
            let mut grid = with_wall(confidence);
            draw_reading(config, &mut grid, &silent);
            assert_eq!(grid.confidence(grid.index_of(Point2::new(1.05, 0.05))), after);
            assert_eq!(grid.confidence(grid.index_of(Point2::new(1.25, 0.05))), -1.0);
        }
    }

    #[test]
    fn readings_do_not_pass_walls() {
        let face = Pose::new(0.05, 0.05, 0.0);
        let mut grid = with_wall(6.0);
        let silent = Reading { silent: true, ..reading(face, 3.9) };
        draw_reading(far(), &mut grid, &silent);
        let at = |grid: &Grid, x: f64| grid.confidence(grid.index_of(Point2::new(x, 0.05)));
        assert_eq!([0.5, 0.95, 1.05, 1.15, 1.5].map(|x| at(&grid, x)), [-1.0, -1.0, 6.0, 0.0, 0.0]);
        // an echo from behind wears the wall down
        draw_reading(far(), &mut grid, &reading(face, 3.0));
        assert_eq!([0.95, 1.05, 1.55, 3.05].map(|x| at(&grid, x)), [-2.0, 5.0, 0.0, 0.0]);
        // until it gets through
        for _ in 0..12 {
            draw_reading(far(), &mut grid, &reading(face, 3.0));
        }
        assert!(at(&grid, 1.05) < 0.0 && at(&grid, 1.55) < 0.0 && at(&grid, 3.05) > 0.0);
        // the wall's own echo is not stopped by the wall
        let mut grid = with_wall(4.0);
        draw_reading(far(), &mut grid, &reading(face, 1.0));
        assert_eq!([0.95, 1.05].map(|x| at(&grid, x)), [-1.0, 5.0]);
    }

    #[test]
    fn far_objects_can_be_left_out() {
        let mut grid = grid(0.1);
        let config = MarkingConfig { object_within: 1.5, clear_to: 1.0, ..MarkingConfig::default() };
        draw_reading(config, &mut grid, &reading(Pose::new(0.05, 0.05, 0.0), 2.0));
        assert!(grid.confidences().iter().all(|f| *f <= 0.0));
        assert_eq!(grid.confidence(grid.index_of(Point2::new(0.9, 0.05))), -1.0);
        assert_eq!(grid.confidence(grid.index_of(Point2::new(1.25, 0.05))), 0.0);
    }
}
