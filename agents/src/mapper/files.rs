//! Maps as files that any ROS `map_server` reads: an image and a YAML file beside it.
//!
//! The image's first row is the top of the map, largest `y`; the YAML gives the metres per pixel and the place of the lower left
//! corner. A reader computes `p = (255 - pixel) / 255` and calls a pixel occupied if `p > occupied_thresh`, free if
//! `p < free_thresh`. Both thresholds are written so that they lie between two grey values, and grey values
//! are chosen on the right side of them: reloading gives exactly the classes of [`Grid::occupancy`], however the reader rounds.
//!
//! In [`Mode::Trinary`] there are three grey values. [`Mode::Scale`] keeps the probabilities, in steps of 1/255; there cells of
//! which nothing is known are transparent, as readers of that mode expect.
//!
//! Files are written beside their final place and renamed when complete. The old YAML file is removed before the image is
//! replaced, so no YAML file ever points to an image it does not fit.

use std::{
    ffi::OsString,
    fmt::Write as _,
    fs::{self, File, OpenOptions},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

use image::{DynamicImage, GrayAlphaImage, GrayImage, ImageError, ImageFormat, Luma, LumaA};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::certainty_grid::{CellIndex, Grid, Occupancy, Window};

/// What the image says of a cell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// Free, occupied or unknown.
    #[default]
    Trinary,
    /// Its probability.
    Scale,
}

/// Why a map could not be written.
#[derive(Debug, Error)]
pub enum MapFileError {
    /// The image or the YAML file could not be written.
    #[error("can't write {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The image could not be encoded.
    #[error("can't encode {path}: {source}")]
    Image {
        /// The file.
        path: PathBuf,
        /// What the encoder says.
        source: ImageError,
    },
}

/// A map that has been written.
#[derive(Debug, Clone, PartialEq)]
pub struct MapFiles {
    /// The image.
    pub image: PathBuf,
    /// The YAML file.
    pub yaml: PathBuf,
    /// What the map holds.
    pub summary: Summary,
}

/// Size and contents of a map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Summary {
    /// Columns of the image.
    pub width: usize,
    /// Rows of the image.
    pub height: usize,
    /// Metres per pixel.
    pub resolution: f64,
    /// Lower left corner, map frame, m.
    pub origin: [f64; 2],
    /// Free cells.
    pub free: usize,
    /// Occupied cells.
    pub occupied: usize,
    /// Cells of which nothing is known, within the image.
    pub unknown: usize,
    /// Area of the free cells, m².
    pub free_area: f64,
    /// Area of the occupied cells, m².
    pub occupied_area: f64,
}

/// Cells of margin around what is known.
const MARGIN: usize = 2;

/// The part of the grid that goes into files: what is known and a little margin, or a single cell if nothing is.
#[must_use]
pub fn printed_window(grid: &Grid) -> Window {
    grid.known_window(MARGIN).unwrap_or(Window { width: 1, height: 1, ..grid.window() })
}

/// Size and contents of what [`save`] writes.
#[must_use]
pub fn summarize(grid: &Grid) -> Summary {
    let window = printed_window(grid);
    // Everything known lies inside the printed window.
    let counts = grid.counts();
    Summary {
        width: window.width,
        height: window.height,
        resolution: grid.cell_size(),
        origin: grid.corner_of(window.first).into(),
        free: counts.free,
        occupied: counts.occupied,
        unknown: (window.width * window.height).saturating_sub(counts.free + counts.occupied),
        free_area: counts.free as f64 * grid.cell_area(),
        occupied_area: counts.occupied as f64 * grid.cell_area(),
    }
}

/// Writes the map to `stem.png` and `stem.yaml`, replacing what is there. Directories must exist.
///
/// # Errors
/// [`MapFileError`] names the file; no half-written file stays behind.
pub fn save(grid: &Grid, stem: &Path, mode: Mode) -> Result<MapFiles, MapFileError> {
    let with = |extension: &str| {
        let mut name = stem.as_os_str().to_owned();
        name.push(extension);
        PathBuf::from(name)
    };
    let (image_path, yaml_path) = (with(".png"), with(".yaml"));
    let name = stem.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let [(_, png), (_, yaml)] = encode_map(grid, &name, mode)?;
    let io_error = |path: &Path| {
        let path = path.to_owned();
        move |source| MapFileError::Io { path, source }
    };
    match fs::remove_file(&yaml_path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(io_error(&yaml_path)(error)),
        _ => {}
    }
    replace(&image_path, &png).map_err(io_error(&image_path))?;
    replace(&yaml_path, &yaml).map_err(io_error(&yaml_path))?;
    Ok(MapFiles { image: image_path, yaml: yaml_path, summary: summarize(grid) })
}

/// The two files of a map, `name.png` and `name.yaml`, as they are to be written.
///
/// # Errors
/// [`MapFileError::Image`] if the map can't be encoded.
pub fn encode_map(grid: &Grid, name: &str, mode: Mode) -> Result<[(String, Vec<u8>); 2], MapFileError> {
    let window = printed_window(grid);
    let scale = GreyScale::of(grid);
    let image: DynamicImage = match mode {
        Mode::Trinary => trinary(grid, window).into(),
        Mode::Scale => scale.image(grid, window).into(),
    };
    let image_name = format!("{name}.png");
    let png = encode(&image, Path::new(&image_name))?;
    let yaml = yaml(&image_name, mode, &summarize(grid), &scale);
    Ok([(image_name, png), (format!("{name}.yaml"), yaml.into_bytes())])
}

/// A picture as PNG.
///
/// # Errors
/// [`MapFileError::Image`] if it can't be encoded.
pub fn encode_png(image: &DynamicImage) -> Result<Vec<u8>, MapFileError> {
    encode(image, Path::new("picture.png"))
}

pub(super) fn encode(image: &DynamicImage, path: &Path) -> Result<Vec<u8>, MapFileError> {
    let mut png = io::Cursor::new(Vec::new());
    image.write_to(&mut png, ImageFormat::Png).map_err(|source| MapFileError::Image { path: path.to_owned(), source })?;
    Ok(png.into_inner())
}

/// Writes a file so that at any moment there is either the old one or the whole new one.
pub(super) fn replace(path: &Path, contents: &[u8]) -> io::Result<()> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let mut draft_name = OsString::from(".");
    draft_name.push(name);
    draft_name.push(format!(".{}.part", std::process::id()));
    let draft = path.with_file_name(draft_name);
    let written = write_whole(&draft, contents).and_then(|()| fs::rename(&draft, path));
    if written.is_err() {
        // The first error is the one to tell of.
        let _ = fs::remove_file(&draft);
    }
    written
}

fn write_whole(path: &Path, contents: &[u8]) -> io::Result<()> {
    let mut file: File = OpenOptions::new().write(true).create(true).truncate(true).open(path)?;
    file.write_all(contents)?;
    file.sync_all()
}

/// Grey values of the three kinds of cells. Unknown lies far from both thresholds.
const FREE: u8 = 254;
const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 127;

fn trinary(grid: &Grid, window: Window) -> GrayImage {
    GrayImage::from_fn(window.width as u32, window.height as u32, |x, y| {
        Luma([match grid.occupancy(cell_at(window, x, y)) {
            Occupancy::Free => FREE,
            Occupancy::Occupied => OCCUPIED,
            Occupancy::Unknown => UNKNOWN,
        }])
    })
}

/// The cell behind a pixel of the image of a window.
pub(super) fn cell_at(window: Window, x: u32, y: u32) -> CellIndex {
    window.first.offset(x as i32, window.height as i32 - 1 - y as i32)
}

/// How probabilities become grey values: which of them are free and which occupied.
struct GreyScale {
    /// The lightest grey of an occupied cell.
    occupied: u8,
    /// The darkest grey of a free cell.
    free: u8,
}

impl GreyScale {
    fn of(grid: &Grid) -> Self {
        let thresholds = grid.rules().thresholds;
        let occupied = grey(thresholds.occupied).min(126);
        Self { occupied, free: grey(thresholds.empty).max(128) }
    }

    /// The pixel value halfway between two greys, as the probability that a reader computes.
    fn threshold(lighter: u8, darker: u8) -> f64 {
        (255.0 - 0.5 * (f64::from(lighter) + f64::from(darker))) / 255.0
    }

    fn occupied_threshold(&self) -> f64 {
        Self::threshold(self.occupied + 1, self.occupied)
    }

    fn free_threshold(&self) -> f64 {
        Self::threshold(self.free, self.free - 1)
    }

    fn image(&self, grid: &Grid, window: Window) -> GrayAlphaImage {
        GrayAlphaImage::from_fn(window.width as u32, window.height as u32, |x, y| {
            let index = cell_at(window, x, y);
            let shade = grey(grid.probability(index));
            LumaA(match grid.occupancy(index) {
                Occupancy::Occupied => [shade.min(self.occupied), 255],
                Occupancy::Free => [shade.max(self.free), 255],
                Occupancy::Unknown if grid.is_unknown(index) => [UNKNOWN, 0],
                Occupancy::Unknown => [shade.clamp(self.occupied + 1, self.free - 1), 255],
            })
        })
    }
}

fn grey(probability: f32) -> u8 {
    (255.0 * (1.0 - probability)).round() as u8
}

fn yaml(image: &str, mode: Mode, summary: &Summary, scale: &GreyScale) -> String {
    let (mode, free, occupied) = match mode {
        Mode::Trinary => ("trinary", 0.25, 0.65),
        Mode::Scale => ("scale", scale.free_threshold(), scale.occupied_threshold()),
    };
    let Summary { resolution, origin, .. } = summary;
    let mut text = format!("image: {}\nmode: {mode}\n", quoted(image));
    // Writing to a string can't fail.
    let _ = writeln!(text, "resolution: {}\norigin: [{}, {}, 0.0]", decimal(*resolution), decimal(origin[0]), decimal(origin[1]));
    let _ = writeln!(text, "negate: 0\noccupied_thresh: {}\nfree_thresh: {}", decimal(occupied), decimal(free));
    text
}

/// A number rounded to a nanometre, always with a point, so that no reader takes it for an integer.
fn decimal(number: f64) -> String {
    let text = format!("{number:.9}");
    let short = text.trim_end_matches('0');
    let short = if short.ends_with('.') { &text[..=short.len()] } else { short };
    if short == "-0.0" { "0.0".to_owned() } else { short.to_owned() }
}

/// A file name as a YAML scalar: as it is if it can't be mistaken for anything else, else in double quotes.
fn quoted(name: &str) -> String {
    let plain = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-'));
    if plain {
        return name.to_owned();
    }
    let mut text = String::from("\"");
    for c in name.chars() {
        match c {
            '"' | '\\' => text.extend(['\\', c]),
            c if c.is_control() => {
                let _ = write!(text, "\\u{:04x}", u32::from(c));
            }
            c => text.push(c),
        }
    }
    text + "\""
}

#[cfg(test)]
#[path = "files_tests.rs"]
mod tests;
