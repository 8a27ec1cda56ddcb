//! The two files of a sonar log.

use std::path::Path;

use orienteer_runtime::{geometry::Pose, time::Time, topics::Echo};
use thiserror::Error;

/// Name of the file of readings in a log's folder.
pub const MEASUREMENTS: &str = "measurement.txt";
/// Name of the file of poses in a log's folder.
pub const POSES: &str = "poses.txt";
/// Readings per entry.
pub const SONARS: usize = 8;

/// A reading of this many millimetres means that nothing answered.
const NO_ECHO: f64 = 5110.0;

/// One entry of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Since the first entry.
    pub time: Time,
    /// Recorded pose, m and rad.
    pub pose: Pose,
    /// Recorded readings, metres.
    pub echoes: [Echo; SONARS],
}

/// A whole log, in order of time.
#[derive(Debug, Clone, PartialEq)]
pub struct SonarLog {
    entries: Vec<Entry>,
}

/// Why a log could not be read.
#[derive(Debug, Error)]
pub enum LogError {
    /// A file could not be read.
    #[error("{file}: {source}")]
    Io {
        /// The file.
        file: String,
        /// The operating system's answer.
        source: std::io::Error,
    },
    /// A line makes no sense.
    #[error("{file}:{line}: {what}")]
    Line {
        /// The file.
        file: String,
        /// Counted from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
    },
    /// A file holds nothing.
    #[error("{file}: no entries")]
    Empty {
        /// The file.
        file: String,
    },
}

/// One line: its number, the time in ms and `N` more numbers.
struct Row<const N: usize> {
    line: usize,
    millis: u64,
    numbers: [f64; N],
}

impl SonarLog {
    /// Reads `poses.txt` and `measurement.txt` of a folder.
    ///
    /// # Errors
    /// [`LogError`] with file and line.
    pub fn load(folder: &Path) -> Result<Self, LogError> {
        let read = |name: &str| {
            let path = folder.join(name);
            let file = path.display().to_string();
            std::fs::read_to_string(&path).map(|text| (file.clone(), text)).map_err(|source| LogError::Io { file, source })
        };
        let (poses_file, poses) = read(POSES)?;
        let (measurements_file, measurements) = read(MEASUREMENTS)?;
        Self::parse((&poses_file, &poses), (&measurements_file, &measurements))
    }

    /// Parses the two files, each given as its name and its text.
    ///
    /// # Errors
    /// [`LogError`] with file and line.
    pub fn parse(poses: (&str, &str), measurements: (&str, &str)) -> Result<Self, LogError> {
        let pose_rows = rows::<3>(poses.0, poses.1)?;
        let reading_rows = rows::<SONARS>(measurements.0, measurements.1)?;
        let start = pose_rows.first().map_or(0, |row| row.millis);
        let mut entries = Vec::with_capacity(pose_rows.len());
        for (pose, readings) in pose_rows.iter().zip(&reading_rows) {
            if pose.millis != readings.millis {
                let what = format!("time {} does not match {} at {}:{}", readings.millis, pose.millis, poses.0, pose.line);
                return Err(wrong(measurements.0, readings.line, what));
            }
            let time = Time::from_nanos((pose.millis - start).saturating_mul(1_000_000));
            entries.push(Entry { time, pose: to_pose(pose), echoes: to_echoes(measurements.0, readings)? });
        }
        let lonely = |file: &str, row: usize, other: &str| wrong(file, row, format!("has no counterpart in {other}"));
        if let Some(row) = pose_rows.get(entries.len()) {
            return Err(lonely(poses.0, row.line, measurements.0));
        }
        if let Some(row) = reading_rows.get(entries.len()) {
            return Err(lonely(measurements.0, row.line, poses.0));
        }
        Ok(Self { entries })
    }

    /// All entries, in order of time; at least one.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Time of the last entry.
    #[must_use]
    pub fn end(&self) -> Time {
        self.entries.last().map_or(Time::START, |entry| entry.time)
    }
}

fn wrong(file: &str, line: usize, what: String) -> LogError {
    LogError::Line { file: file.into(), line, what }
}

fn rows<const N: usize>(file: &str, text: &str) -> Result<Vec<Row<N>>, LogError> {
    let mut rows: Vec<Row<N>> = Vec::new();
    for (index, text) in text.lines().enumerate().filter(|(_, text)| !text.trim().is_empty()) {
        let row = row(file, index + 1, text)?;
        if rows.last().is_some_and(|last| row.millis <= last.millis) {
            return Err(wrong(file, row.line, format!("time {} is not later than the time before", row.millis)));
        }
        rows.push(row);
    }
    if rows.is_empty() { Err(LogError::Empty { file: file.into() }) } else { Ok(rows) }
}

fn row<const N: usize>(file: &str, line: usize, text: &str) -> Result<Row<N>, LogError> {
    let mut words = text.split_whitespace();
    let found = words.clone().count();
    if found != N + 1 {
        return Err(wrong(file, line, format!("expected {} numbers, found {found}", N + 1)));
    }
    let time = words.next().unwrap_or_default();
    let millis = time.parse().map_err(|_| wrong(file, line, format!("\"{time}\" is not a time in milliseconds")))?;
    let mut numbers = [0.0; N];
    for (number, word) in numbers.iter_mut().zip(words) {
        *number = match word.parse::<f64>() {
            Ok(value) if value.abs() < 1e9 => value,
            _ => return Err(wrong(file, line, format!("\"{word}\" is not a number that makes sense here"))),
        };
    }
    Ok(Row { line, millis, numbers })
}

fn to_pose(row: &Row<3>) -> Pose {
    let [x, y, heading] = row.numbers;
    Pose::new(x * 1e-3, y * 1e-3, (heading * 0.1).to_radians())
}

fn to_echoes(file: &str, row: &Row<SONARS>) -> Result<[Echo; SONARS], LogError> {
    let mut echoes = [Echo::Nothing; SONARS];
    for (echo, millimetres) in echoes.iter_mut().zip(row.numbers) {
        *echo = match millimetres {
            0.0 => Echo::TooNear,
            z if z == NO_ECHO => Echo::Nothing,
            z if z > 0.0 && z < NO_ECHO => Echo::Range((z * 1e-3) as f32),
            z => return Err(wrong(file, row.line, format!("{z} mm is not a range from 0 to {NO_ECHO}"))),
        };
    }
    Ok(echoes)
}
