//! What a recording says about its mission as a whole.

use std::{collections::BTreeMap, time::Duration};

use serde::{Deserialize, Serialize};

/// Version of what recordings contain: names of metadata, topics and encodings. A reader refuses any other.
pub const LAYOUT: u32 = 1;

/// Name of the metadata record that holds the mission.
pub(super) const METADATA: &str = "orienteer";

/// The mission that a recording is of.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mission {
    /// Version of the program that ran it.
    pub version: String,
    /// Seed of all random streams.
    pub seed: u64,
    /// Planned length in simulated time.
    pub duration: Duration,
    /// Length of one control step.
    pub control_period: Duration,
    /// All robots; a robot's place here is its number.
    pub robots: Vec<RobotInfo>,
    /// The source files of the configuration, the mission file first.
    pub sources: Vec<Source>,
}

/// A robot of a mission.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotInfo {
    /// Its name, the first level of its topics.
    pub name: String,
    /// Names of its nodes, in the order of [`ClientId`](crate::topics::ClientId).
    pub clients: Vec<String>,
}

impl RobotInfo {
    /// A robot and its nodes.
    #[must_use]
    pub fn new<S: Into<String>>(name: &str, clients: impl IntoIterator<Item = S>) -> Self {
        Self { name: name.to_owned(), clients: clients.into_iter().map(Into::into).collect() }
    }
}

/// A source file of the configuration.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Source {
    /// Name as given in the configuration. Keep machine-specific directories out of it, or recordings of two
    /// machines differ.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

impl Mission {
    /// The metadata of the recording's file.
    pub(super) fn to_metadata(&self) -> Result<BTreeMap<String, String>, serde_json::Error> {
        let entries = [
            ("layout", LAYOUT.to_string()),
            ("version", self.version.clone()),
            ("seed", self.seed.to_string()),
            ("duration_ns", self.duration.as_nanos().to_string()),
            ("control_period_ns", self.control_period.as_nanos().to_string()),
            ("sources", self.sources.len().to_string()),
            ("robots", serde_json::to_string(&self.robots)?),
        ];
        Ok(entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
    }

    /// The mission without its sources, and how many sources belong to it. The error names the entry that is missing or
    /// makes no sense.
    pub(super) fn from_metadata(entries: &BTreeMap<String, String>) -> Result<(Self, usize), String> {
        let text = |key: &str| entries.get(key).ok_or_else(|| format!("its entry `{key}` is missing"));
        let number = |key: &str| {
            let value = text(key)?;
            value.parse::<u64>().map_err(|_| format!("its entry `{key}` is `{value}`, not a number"))
        };
        let robots = serde_json::from_str(text("robots")?).map_err(|error| format!("its entry `robots` is damaged: {error}"))?;
        let mission = Self {
            version: text("version")?.clone(),
            seed: number("seed")?,
            duration: Duration::from_nanos(number("duration_ns")?),
            control_period: Duration::from_nanos(number("control_period_ns")?),
            robots,
            sources: Vec::new(),
        };
        let sources = usize::try_from(number("sources")?).map_err(|error| error.to_string())?;
        Ok((mission, sources))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn metadata_brings_the_mission_back() {
        let mission = Mission {
            version: "0.1.0".into(),
            seed: u64::MAX,
            duration: Duration::from_secs(600),
            control_period: Duration::from_millis(50),
            robots: vec![RobotInfo::new("a \"b\"", ["x"]), RobotInfo::new("c", [""; 0])],
            sources: Vec::new(),
        };
        let mut entries = mission.to_metadata().unwrap();
        assert_eq!(Mission::from_metadata(&entries).unwrap(), (mission, 0));
        entries.insert("seed".into(), "x7".into());
        assert_eq!(Mission::from_metadata(&entries).unwrap_err(), "its entry `seed` is `x7`, not a number");
        entries.remove("robots");
        assert_eq!(Mission::from_metadata(&entries).unwrap_err(), "its entry `robots` is missing");
    }
}
