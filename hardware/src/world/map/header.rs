//! The YAML file of a map, and how it says to read the picture.

use std::{ops::Range, path::PathBuf};

use orienteer_runtime::{config::suggest, geometry::Pose};
use serde::Deserialize;
use serde_saphyr::{MessageFormatter, UserMessageFormatter};

use super::{Cell, Grid, MapError, brightness, decode};

/// How pixels become cells; see the [module](super).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Occupied, free or unknown.
    #[default]
    Trinary,
    /// The same with probabilities in between.
    Scale,
    /// The bytes are the cells.
    Raw,
}

/// The YAML file of a ROS map. Keys that other tools add are ignored, as the map server does, but not slips of the pen.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Header {
    /// The picture, relative to the YAML file.
    pub image: PathBuf,
    /// Metres per pixel.
    pub resolution: f64,
    /// Pose of the lower left pixel: x (m), y (m), yaw (rad).
    pub origin: [f64; 3],
    /// 1 if bright is occupied.
    #[serde(default)]
    pub negate: i64,
    /// What is more likely than this is occupied.
    pub occupied_thresh: f64,
    /// What is less likely than this is free.
    pub free_thresh: f64,
    /// How pixels become cells.
    #[serde(default)]
    pub mode: Mode,
}

impl Header {
    /// Reads the YAML file.
    ///
    /// # Errors
    /// [`MapError::Yaml`] if it lacks a key or is no YAML, [`MapError::Range`] if a number makes no sense.
    pub fn parse(yaml: &[u8]) -> Result<Self, MapError> {
        let text = str::from_utf8(yaml).map_err(|error| {
            let at = error.valid_up_to()..error.valid_up_to() + 1;
            MapError::Yaml { at, message: "this is no text (UTF-8)".to_owned() }
        })?;
        let header: Self = serde_saphyr::from_str(text).map_err(|error| {
            let message = UserMessageFormatter.format_message(error.without_snippet()).into_owned();
            MapError::Yaml { at: place_of(&error), message }
        })?;
        slips(text)?;
        let within = |key: &'static str, value: f64, min, max| {
            let at = key_of(text, key.split(' ').next().unwrap_or_default());
            if (min..=max).contains(&value) { Ok(()) } else { Err(MapError::Range { at, key, value, min, max }) }
        };
        within("resolution", header.resolution, 0.001, 5.0)?;
        within("negate", header.negate as f64, 0.0, 1.0)?;
        within("occupied_thresh", header.occupied_thresh, 0.0, 1.0)?;
        within("free_thresh", header.free_thresh, 0.0, header.occupied_thresh)?;
        within("origin x", header.origin[0], -1000.0, 1000.0)?;
        within("origin y", header.origin[1], -1000.0, 1000.0)?;
        within("origin yaw", header.origin[2], -7.0, 7.0)?;
        Ok(header)
    }

    /// Reads the picture as this header says.
    ///
    /// # Errors
    /// [`MapError::Picture`] if it can't be decoded.
    pub fn grid(&self, picture: &[u8]) -> Result<Grid, MapError> {
        let (picture, has_alpha) = decode(picture)?;
        let [x, y, yaw] = self.origin;
        Ok(Grid::from_picture(&picture, self.resolution, Pose::new(x, y, yaw), |pixel| self.cell(pixel, has_alpha)))
    }

    fn cell(&self, [r, g, b, a]: [u8; 4], has_alpha: bool) -> Cell {
        let mut shade = brightness(r, g, b);
        if self.mode == Mode::Trinary && has_alpha {
            shade = (3.0 * shade + f64::from(a)) / 4.0;
        }
        let occupancy = match self.mode {
            Mode::Scale if a < u8::MAX => return Cell::Unknown,
            Mode::Raw if shade.round() > 100.0 => return Cell::Unknown,
            Mode::Raw => shade.round() / 100.0,
            _ if self.negate == 1 => shade / 255.0,
            _ => 1.0 - shade / 255.0,
        };
        if occupancy > self.occupied_thresh {
            Cell::Occupied
        } else if occupancy < self.free_thresh {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }
}

/// Keys without which a map can be read, so that nobody would miss them.
const OPTIONAL: [&str; 2] = ["negate", "mode"];

/// A key that looks like one of those that may be missing, and is not there, was meant for it.
fn slips(text: &str) -> Result<(), MapError> {
    let keys = || text.lines().filter_map(|line| line.split_once(':')).map(|(key, _)| key.trim_end());
    let missing = || OPTIONAL.into_iter().filter(|optional| !keys().any(|key| key == *optional));
    // Indented lines belong to another table.
    for key in keys().filter(|key| key.chars().all(|c| c.is_alphanumeric() || c == '_') && !OPTIONAL.contains(key)) {
        if let Some(question) = suggest::did_you_mean(key, missing()) {
            return Err(MapError::Yaml { at: key_of(text, key), message: format!("unknown key `{key}`: {question}") });
        }
    }
    Ok(())
}

fn place_of(error: &serde_saphyr::Error) -> Range<usize> {
    let place = error.location().and_then(|location| {
        let span = location.span();
        Some((usize::try_from(span.byte_offset()?).ok()?, usize::try_from(span.byte_len()?).ok()?))
    });
    place.map_or(0..0, |(start, length)| start..start + length)
}

/// Where a key of the outermost table stands.
fn key_of(text: &str, key: &str) -> Range<usize> {
    let is_key = |line: &&str| line.strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with(':'));
    let line = text.lines().find(is_key).map_or(0, |line| line.as_ptr() as usize - text.as_ptr() as usize);
    line..line + key.len()
}
