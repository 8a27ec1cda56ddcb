//! The drivers that play a recorded log.

use std::sync::{Arc, Mutex};

use orienteer_runtime::config::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BaseKind, OpenBase, Site, SonarKind};
use crate::{
    base::{executor::ExecutorConfig, protection::ProtectionConfig},
    driver::SonarDriver,
    log::{self, LogSonar, SonarLog},
};

/// A base that repeats a recorded log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LogBaseConfig {
    /// File of the recorded poses, relative to the mission: lines of time (ms), x, y (mm) and heading (0.1°).
    pub poses: String,
    /// File of the recorded sonar readings, relative to the mission: lines of time (ms) and eight ranges (mm).
    pub measurements: String,
}

/// Leaves the sonar's half of a log for the sonar.
type Half = Mutex<Option<LogSonar>>;

pub(super) struct LogBaseKind;

impl BaseKind for LogBaseKind {
    const NAME: &'static str = "log";
    const HELP: &'static str = "repeats the poses of a recorded log; ignores commands";
    type Config = LogBaseConfig;

    fn open(config: LogBaseConfig, site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        let poses = read(site, "poses", &config.poses)?;
        let measurements = read(site, "measurements", &config.measurements)?;
        let log = SonarLog::parse((&config.poses, &poses), (&config.measurements, &measurements)).map_err(|error| {
            site.problem(error.to_string(), "the format is described in the documentation of `hardware::log`")
        })?;
        let (base, sonar) = log::players(Arc::new(log));
        site.shared = Some(Arc::new(Half::new(Some(sonar))));
        let protection = ProtectionConfig { sonar_required: false, ..ProtectionConfig::default() };
        Ok(OpenBase {
            driver: Box::new(base),
            motion: ExecutorConfig::default(),
            protection,
            start: site.start.unwrap_or_default(),
        })
    }
}

fn read(site: &mut Site<'_>, key: &str, path: &str) -> Result<String, Problems> {
    let source = site.sources.read_for(path, &site.span).map_err(|problem| {
        let hint = "logs are data that do not come with Orienteer: see the comments of the mission for where this one comes from";
        site.problem_at(key, problem.message(), format!("{}; {hint}", problem.hint()))
    })?;
    Ok(site.sources.text(source)?.to_owned())
}

/// The sonar of a recorded log.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LogSonarConfig {}

pub(super) struct LogSonarKind;

impl SonarKind for LogSonarKind {
    const NAME: &'static str = "log";
    const HELP: &'static str = "repeats the sonar readings of the log that the robot's base plays";
    type Config = LogSonarConfig;

    fn open(_config: LogSonarConfig, site: &mut Site<'_>) -> Result<Box<dyn SonarDriver>, Problems> {
        let half = site.shared.take().and_then(|shared| shared.downcast::<Half>().ok());
        let sonar = half.and_then(|half| half.lock().ok()?.take());
        match sonar {
            Some(sonar) => Ok(Box::new(sonar)),
            None => Err(site.problem("a sonar can only play the log of its base", "set the base's `driver = \"log\"` as well")),
        }
    }
}
