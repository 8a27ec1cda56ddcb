//! Maps of real buildings as worlds.
//!
//! A map of the ROS map server is a picture and a YAML file that says how to read it (`map_server`, ROS wiki; `nav2_map_server`
//! for the present rules). A pixel of brightness `shade` in `[0, 1]` is occupied with `occ = 1 - shade` (`negate: 1`: `shade`):
//!
//! | mode | occupied | free | unknown |
//! |---|---|---|---|
//! | `trinary` | `occ > occupied_thresh` | `occ < free_thresh` | what is left |
//! | `scale` | the same | the same | what is left, and transparent pixels |
//! | `raw` | the byte is 0 … 100, a probability in per cent: above `occupied_thresh` | below `free_thresh` | what is left, and bytes above 100 |
//!
//! In `trinary` mode a picture with an alpha channel counts opacity as a fourth colour, as the map server does. `scale` and
//! `raw` give graded occupancies between the thresholds; a wall either is there or is not, so these cells are unknown here.
//! The origin is the pose of the lower left corner of the lower left pixel; its yaw is respected.
//!
//! What becomes of the cells is in [`Grid::rings`].

mod fit;
mod header;
mod trace;

use std::ops::Range;

use image::{ImageReader, Limits, RgbaImage};
use nalgebra::Point2;
use orienteer_runtime::geometry::Pose;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use header::{Header, Mode};

use super::{plan::FloorPlan, region::Ring};

/// Longest side of a picture, pixels.
const MOST_PIXELS: u32 = 8_192;

/// What a cell is that nobody has looked into.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Unknown {
    /// Open space: nothing echoes that was not seen to be there.
    #[default]
    Free,
    /// Solid: a robot can't leave what has been mapped.
    Solid,
}

/// What is known of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cell {
    /// Nothing there.
    Free,
    /// Not known.
    Unknown,
    /// Something solid.
    Occupied,
}

/// Why a map can't be read.
#[derive(Debug, Error)]
pub enum MapError {
    /// The YAML file is not YAML, lacks a key or has one of the wrong type.
    #[error("{message}")]
    Yaml {
        /// Where, in bytes of the YAML file.
        at: Range<usize>,
        /// What is wrong there.
        message: String,
    },
    /// A number of the YAML file is out of range.
    #[error("{key} is {value}, not within {min} to {max}")]
    Range {
        /// Where its key stands, in bytes of the YAML file.
        at: Range<usize>,
        /// Which key.
        key: &'static str,
        /// What it says.
        value: f64,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
    },
    /// The picture can't be decoded.
    #[error("not a picture that can be read (PNG, PGM, PPM): {0}")]
    Picture(#[from] image::ImageError),
    /// The map reaches too far from the origin.
    #[error("reaches further than {reach} m from the world's origin")]
    TooFar {
        /// Largest coordinate allowed, m.
        reach: f64,
    },
}

impl MapError {
    /// Where in the YAML file it is, in bytes; `None` if it is about the picture.
    #[must_use]
    pub fn place(&self) -> Option<Range<usize>> {
        match self {
            Self::Yaml { at, .. } | Self::Range { at, .. } => Some(at.clone()),
            Self::Picture(_) | Self::TooFar { .. } => None,
        }
    }
}

/// A picture of a building, cell by cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Cells in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Row by row, the lowest first.
    pub cells: Vec<Cell>,
    /// Side of a cell, m.
    pub resolution: f64,
    /// Where the lower left corner of the first cell lies, and how the rows are turned.
    pub origin: Pose,
}

impl Grid {
    /// Reads a plain picture: dark is solid.
    ///
    /// # Errors
    /// [`MapError::Picture`] if it can't be decoded.
    pub fn from_floor_plan(plan: &FloorPlan, picture: &[u8]) -> Result<Self, MapError> {
        let origin = Pose::new(plan.origin.0[0], plan.origin.0[1], plan.rotation_deg.to_radians());
        let cell = |[r, g, b, a]: [u8; 4]| {
            // What is transparent is paper.
            let shade = if a < 128 { 255.0 } else { brightness(r, g, b) };
            let dark = shade < f64::from(plan.threshold);
            if dark != plan.negate { Cell::Occupied } else { Cell::Free }
        };
        Ok(Self::from_picture(&decode(picture)?.0, plan.resolution, origin, cell))
    }

    fn from_picture(picture: &RgbaImage, resolution: f64, origin: Pose, cell: impl Fn([u8; 4]) -> Cell) -> Self {
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let cells = picture.rows().rev().flatten().map(|pixel| cell(pixel.0)).collect();
        Self { width, height, cells, resolution, origin }
    }

    /// The border of what is solid as closed rings in the world frame, matter on the left.
    ///
    /// 1. Patches of less than `min_speck` cells are noise: solid ones vanish, free ones are filled. Solid cells that touch at
    ///    a corner belong together, so that a wall one cell thick is closed at any angle; free cells join by their sides only.
    /// 2. The border is followed along the edges of the cells.
    /// 3. The staircase is cut into straight sides that stay within `tolerance` cells of it (Douglas and Peucker 1973), and
    ///    each side is moved to the line that fits the middles of its cell edges best in the sense of total least squares.
    ///    Neighbouring sides meet where their lines cross. A straight wall at any angle thus becomes one long side with the
    ///    wall's own normal, on which mirror reflection of sonar depends.
    ///
    /// With a tolerance of 0 the result is the exact border of the cells. Otherwise sides of thin walls may cross each other.
    #[must_use]
    pub fn rings(&self, unknown: Unknown, min_speck: u32, tolerance: f64) -> Vec<Vec<Point2<f64>>> {
        let is_solid = |cell: &Cell| match cell {
            Cell::Occupied => true,
            Cell::Unknown => unknown == Unknown::Solid,
            Cell::Free => false,
        };
        let mut bitmap = trace::Bitmap::new(self.width, self.height, self.cells.iter().map(is_solid).collect());
        bitmap.drop_specks(min_speck as usize);
        let to_world = |p: Point2<f64>| self.origin.transform(p * self.resolution);
        let rings = bitmap.borders().into_iter().map(|border| fit::straighten(&border, tolerance));
        rings.map(|ring: Ring| ring.into_iter().map(to_world).collect()).collect()
    }
}

fn brightness(r: u8, g: u8, b: u8) -> f64 {
    (f64::from(r) + f64::from(g) + f64::from(b)) / 3.0
}

/// The picture, and whether it has an alpha channel. Decoding is limited: a small file can describe a huge picture.
fn decode(bytes: &[u8]) -> Result<(RgbaImage, bool), MapError> {
    let mut reader = ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format().map_err(image::ImageError::IoError)?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_PIXELS);
    limits.max_image_height = Some(MOST_PIXELS);
    limits.max_alloc = Some(256 << 20);
    reader.limits(limits);
    let picture = reader.decode()?;
    let has_alpha = picture.color().has_alpha();
    Ok((picture.to_rgba8(), has_alpha))
}

#[cfg(test)]
mod tests;
