//! What a floor shall be like.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::super::plan::FAR;

/// Largest number of columns or rows of a grid.
pub const MOST_LINES: u32 = 40;
/// Room that walls, rooms and furniture may take beyond the outermost centre lines, m.
const MARGIN: f64 = 12.0;
/// A box is at least this deep, m.
pub(super) const SHALLOWEST_BOX: f64 = 0.1;

/// What a floor shall be like. Lengths are in metres; shares are between 0 and 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FloorSpec {
    /// At least so many places: the grid grows from two crossings until it has them. Instead of `columns` and `rows`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub places: Option<u32>,
    /// Corridors side by side from north to south, 1 to 40.
    pub columns: u32,
    /// Corridors side by side from east to west, 1 to 40.
    pub rows: u32,
    /// Widths of corridors, from wall to wall, 0.8 to 5; each straight corridor gets one of these.
    pub corridor_width: Vec<Width>,
    /// From one centre line of the grid to the next, 3 to 100.
    pub pitch: f64,
    /// The pitch is at most so much more or less.
    pub jitter: f64,
    /// Least length of wall between the mouths of two neighbouring places, 2 to 50.
    pub gap: f64,
    /// Share of edges kept though the floor would be connected without them; 0 gives a tree, 1 the whole grid.
    pub loops: f64,
    /// Share of crossings that may become dead ends.
    pub dead_ends: f64,
    /// Share of doorways that are there, of all that corridors have room for.
    pub doors: f64,
    /// Clear width of doorways, 0.6 to 3. Randazza's hypotheses take 1.12.
    pub door_width: f64,
    /// Share of corridors, from place to place, in which a box stands.
    pub boxes: f64,
    /// No box is nearer to the centre line of its corridor, 0.2 to 2.5. A robot of 0.3 m radius that keeps to the middle goes
    /// straight past at 0.42.
    pub berth: f64,
    /// No box stands nearer to the mouth of a place, 0 to 20.
    pub clear: f64,
    /// People, each with a corridor of their own, who walk round the floor through it; to and fro in it where no way leads round.
    pub people: u32,
}

impl Default for FloorSpec {
    /// Corridors as Randazza (1989) had them, 1.12 m wide, five by four, without boxes and people.
    fn default() -> Self {
        Self {
            places: None,
            columns: 5,
            rows: 4,
            corridor_width: vec![Width::Exactly(1.12)],
            pitch: 9.0,
            jitter: 1.0,
            gap: 6.0,
            loops: 0.5,
            dead_ends: 0.3,
            doors: 0.8,
            door_width: 1.12,
            boxes: 0.0,
            berth: 0.42,
            clear: 2.0,
            people: 0,
        }
    }
}

/// A width, or any width between two.
///
/// ```
/// use orienteer_hardware::world::floors::Width;
/// assert_eq!("1.12".parse(), Ok(Width::Exactly(1.12)));
/// assert_eq!("1-1.5".parse(), Ok(Width::Between([1.0, 1.5])));
/// assert!("wide".parse::<Width>().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Width {
    /// This width, m.
    Exactly(f64),
    /// From the smaller to the larger, m.
    Between([f64; 2]),
}

impl Width {
    /// Smallest and largest, m.
    #[must_use]
    pub fn range(self) -> [f64; 2] {
        match self {
            Self::Exactly(width) => [width, width],
            Self::Between(range) => range,
        }
    }
}

impl FromStr for Width {
    type Err = String;

    /// Reads `1.12`, or `1-1.5` for any width between.
    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.parse::<f64>().map_err(|_| "metres are needed: 1.12, or 1-1.5 for any between".to_owned());
        match text.split_once('-').filter(|(from, _)| !from.is_empty()) {
            Some((from, to)) => Ok(Self::Between([number(from)?, number(to)?])),
            None => Ok(Self::Exactly(number(text)?)),
        }
    }
}

/// Why there is no such floor.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FloorError {
    /// A number is out of range.
    #[error("{key} is {value}, not within {min} to {max}")]
    Range {
        /// Which number.
        key: &'static str,
        /// What it is.
        value: f64,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
    },
    /// A range of widths begins above its end.
    #[error("the range of corridor widths from {from} to {to} m is empty")]
    EmptyRange {
        /// Where it begins, m.
        from: f64,
        /// Where it ends, m.
        to: f64,
    },
    /// A list of widths without any.
    #[error("there is no corridor width")]
    NoWidth,
    /// A grid of one crossing.
    #[error("a single crossing makes no floor")]
    TooSmall,
    /// Crossings are too near to each other.
    #[error(
        "a pitch of {pitch} m, less a jitter of {jitter} m and a corridor of {widest} m, leaves less than {gap} m between places"
    )]
    Pitch {
        /// The pitch, m.
        pitch: f64,
        /// How much less it may be, m.
        jitter: f64,
        /// Width of the widest corridor, m.
        widest: f64,
        /// How much is to be left, m.
        gap: f64,
    },
    /// The floor would reach beyond the largest coordinates of a world.
    #[error("{lines} corridors side by side, {pitch} m apart, reach further than a world does, which is {FAR} m")]
    TooFar {
        /// Number of columns or rows.
        lines: u32,
        /// The pitch with its jitter, m.
        pitch: f64,
    },
    /// The largest grid still has too few places.
    #[error("{wanted} places are too many: the largest floor of this kind has {most}")]
    TooFewPlaces {
        /// How many there shall be.
        wanted: u32,
        /// How many there are.
        most: usize,
    },
    /// No box is shallow enough.
    #[error("no corridor is wide enough for a box: half of {widest} m, less a berth of {berth} m, leaves less than 0.1 m")]
    NoRoomForBoxes {
        /// Width of the widest corridor, m.
        widest: f64,
        /// How far off the centre line a box is to be, m.
        berth: f64,
    },
    /// More people than corridors.
    #[error("{people} people need a corridor each, and this floor has {corridors} from place to place")]
    Crowded {
        /// How many people there shall be.
        people: u32,
        /// How many corridors there are.
        corridors: usize,
    },
}

impl FloorError {
    /// What to do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Range { key, min, max, .. } => format!("give {key} a value from {min} to {max}"),
            Self::EmptyRange { .. } => "write the smaller width first".to_owned(),
            Self::NoWidth => "1.12 m is usual".to_owned(),
            Self::TooSmall => "give it two columns or two rows at least".to_owned(),
            Self::Pitch { jitter, widest, gap, .. } => {
                // Up to the next centimetre, whatever the sum's last bits are.
                let least = (100.0 * (gap + widest + jitter) - 1e-6).ceil() / 100.0;
                format!("a pitch of {least} m would do, or a smaller gap, jitter or corridor width")
            }
            Self::TooFar { .. } => "take fewer columns or rows, or a smaller pitch".to_owned(),
            Self::TooFewPlaces { .. } => "ask for fewer places, or take a smaller pitch".to_owned(),
            Self::NoRoomForBoxes { .. } => "take a wider corridor or a smaller berth".to_owned(),
            Self::Crowded { .. } => "ask for fewer people, or for a larger floor".to_owned(),
        }
    }
}

impl FloorSpec {
    /// Checks every number, and that they go together.
    ///
    /// # Errors
    /// [`FloorError`] says which does not.
    pub fn check(&self) -> Result<(), FloorError> {
        within("the number of places", f64::from(self.places.unwrap_or(2)), 2.0, f64::from(MOST_LINES * MOST_LINES))?;
        within("the number of columns", f64::from(self.columns), 1.0, f64::from(MOST_LINES))?;
        within("the number of rows", f64::from(self.rows), 1.0, f64::from(MOST_LINES))?;
        within("the pitch", self.pitch, 3.0, 100.0)?;
        within("the jitter", self.jitter, 0.0, 100.0)?;
        within("the gap", self.gap, 2.0, 50.0)?;
        within("the share of loops", self.loops, 0.0, 1.0)?;
        within("the share of dead ends", self.dead_ends, 0.0, 1.0)?;
        within("the share of doors", self.doors, 0.0, 1.0)?;
        within("the door width", self.door_width, 0.6, 3.0)?;
        within("the share of boxes", self.boxes, 0.0, 1.0)?;
        within("the berth", self.berth, 0.2, 2.5)?;
        within("the clear zone", self.clear, 0.0, 20.0)?;
        self.check_widths()?;
        self.check_size()
    }

    fn check_widths(&self) -> Result<(), FloorError> {
        if self.corridor_width.is_empty() {
            return Err(FloorError::NoWidth);
        }
        for [from, to] in self.corridor_width.iter().map(|width| width.range()) {
            within("the corridor width", from, 0.8, 5.0)?;
            within("the corridor width", to, 0.8, 5.0)?;
            if from > to {
                return Err(FloorError::EmptyRange { from, to });
            }
        }
        let (widest, berth) = (self.widest(), self.berth);
        if self.boxes > 0.0 && 0.5 * widest - berth < SHALLOWEST_BOX {
            return Err(FloorError::NoRoomForBoxes { widest, berth });
        }
        Ok(())
    }

    fn check_size(&self) -> Result<(), FloorError> {
        let Self { pitch, jitter, gap, .. } = *self;
        let widest = self.widest();
        // Lengths are rounded to centimetres.
        if pitch - jitter - widest < gap - 1e-6 {
            return Err(FloorError::Pitch { pitch, jitter, widest, gap });
        }
        if self.places.is_none() {
            if self.columns * self.rows < 2 {
                return Err(FloorError::TooSmall);
            }
            let lines = self.columns.max(self.rows);
            if lines > self.most_lines() {
                return Err(FloorError::TooFar { lines, pitch: pitch + jitter });
            }
        }
        Ok(())
    }

    /// Width of the widest corridor there may be, m.
    pub(super) fn widest(&self) -> f64 {
        self.corridor_width.iter().map(|width| width.range()[1]).fold(0.0, f64::max)
    }

    /// How many columns or rows a world has room for.
    pub(super) fn most_lines(&self) -> u32 {
        let steps = ((FAR - MARGIN) / (self.pitch + self.jitter)).floor();
        (steps as u32 + 1).min(MOST_LINES)
    }
}

pub(super) fn within(key: &'static str, value: f64, min: f64, max: f64) -> Result<(), FloorError> {
    if (min..=max).contains(&value) { Ok(()) } else { Err(FloorError::Range { key, value, min, max }) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn refused(change: impl FnOnce(&mut FloorSpec)) -> String {
        let mut spec = FloorSpec::default();
        change(&mut spec);
        let error = spec.check().unwrap_err();
        assert!(!error.hint().is_empty());
        error.to_string()
    }

    #[test]
    fn what_does_not_go_together_is_named() {
        assert_eq!(FloorSpec::default().check(), Ok(()));
        assert!(refused(|spec| spec.loops = f64::NAN).contains("loops"));
        assert!(refused(|spec| spec.pitch = 8.0).contains("less than 6 m"));
        assert!(refused(|spec| spec.corridor_width.clear()).contains("no corridor width"));
        assert!(refused(|spec| spec.corridor_width = vec![Width::Between([1.5, 1.0])]).contains("empty"));
        assert!(refused(|spec| spec.corridor_width = vec![Width::Exactly(f64::INFINITY)]).contains("inf"));
        assert!(refused(|spec| (spec.columns, spec.rows) = (1, 1)).contains("single crossing"));
        assert!(refused(|spec| (spec.columns, spec.pitch) = (40, 60.0)).contains("500 m"));
        assert!(refused(|spec| (spec.boxes, spec.berth) = (0.5, 0.5)).contains("box"));
    }

    #[test]
    fn the_pitch_that_a_hint_names_would_do() {
        let mut spec = FloorSpec { pitch: 5.0, corridor_width: vec![Width::Exactly(2.46)], ..FloorSpec::default() };
        let hint = spec.check().unwrap_err().hint();
        spec.pitch = hint.split(' ').find_map(|word| word.parse().ok()).unwrap();
        assert_eq!(spec.check(), Ok(()), "{hint}");
    }
}
