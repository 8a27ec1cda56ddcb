//! The simulated drivers.

use orienteer_runtime::config::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BaseKind, OpenBase, Site, SonarKind};
use crate::{
    base::{executor::ExecutorConfig, kinematics::BaseConfig, odometry::OdometryConfig, protection::ProtectionConfig},
    driver::SonarDriver,
    echo::SonarModel,
    fault::{BaseFaults, FaultInjector, SonarFaults},
    rings::{NamedRing, RingConfig},
    sim::{SimBase, SimBodyConfig, SimSonar},
};

/// A simulated base.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SimBaseConfig {
    /// The kind of base.
    #[schemars(extend("x-names" = "platform"))]
    pub platform: String,
    /// A base of your own, instead of a platform with a name; what it leaves out is as for `b12-huey`.
    #[schemars(extend("x-instead-of" = "platform"))]
    pub custom: Option<BaseConfig>,
    /// How its odometry errs.
    pub odometry: OdometryConfig,
    /// How relative motions are carried out.
    pub motion: ExecutorConfig,
    /// How it protects itself.
    pub protection: ProtectionConfig,
    /// Faults to inject, for experiments.
    pub faults: BaseFaults,
}

impl Default for SimBaseConfig {
    fn default() -> Self {
        Self {
            platform: "b12-huey".to_owned(),
            custom: None,
            odometry: OdometryConfig::default(),
            motion: ExecutorConfig::default(),
            protection: ProtectionConfig::default(),
            faults: BaseFaults::default(),
        }
    }
}

pub(super) struct SimBaseKind;

impl BaseKind for SimBaseKind {
    const NAME: &'static str = "sim";
    const HELP: &'static str = "a simulated base in the mission's world";
    const NEEDS_WORLD: bool = true;
    type Config = SimBaseConfig;

    fn open(config: SimBaseConfig, site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        let Some(arena) = site.arena else {
            return Err(site.problem("a simulated base needs a world", "add `[world]` with `file = \"worlds/….toml\"`"));
        };
        let base = site.base(&config.platform, config.custom)?;
        let platform = base.platform();
        let start = site.start.unwrap_or_default();
        let body = arena
            .add(site.robot, start, SimBodyConfig { base, odometry: config.odometry })
            .map_err(|error| site.start_problem(error.to_string(), start_hint(site)))?;
        let driver = FaultInjector::new(
            SimBase::new(body, platform),
            config.faults.into(),
            site.streams.stream(site.robot, "base faults"),
        );
        Ok(OpenBase { driver: Box::new(driver), motion: config.motion, protection: config.protection, start })
    }
}

fn start_hint(site: &Site<'_>) -> String {
    let places = site.arena.map_or(&[][..], |arena| &arena.world().places[..]);
    let names: Vec<_> = places.iter().take(MOST_PLACES).map(|place| format!("`{}`", place.name)).collect();
    let what = if site.start_span.is_some() { "choose another `start`" } else { "give a `start`: without one it is the origin" };
    if names.is_empty() { what.to_owned() } else { format!("{what}; places of this world are {}", names.join(", ")) }
}

/// More places would make no hint.
const MOST_PLACES: usize = 8;

/// A simulated sonar ring.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SimSonarConfig {
    /// The ring.
    #[schemars(extend("x-names" = "ring"))]
    pub ring: String,
    /// A ring of your own, instead of one with a name.
    #[schemars(extend("x-instead-of" = "ring"))]
    pub custom: Option<RingConfig>,
    /// How it hears; without it, as the ring of that name does.
    pub model: Option<SonarModel>,
    /// Faults to inject, for experiments.
    pub faults: SonarFaults,
}

impl Default for SimSonarConfig {
    fn default() -> Self {
        Self { ring: "denning-16".to_owned(), custom: None, model: None, faults: SonarFaults::default() }
    }
}

pub(super) struct SimSonarKind;

impl SonarKind for SimSonarKind {
    const NAME: &'static str = "sim";
    const HELP: &'static str = "a simulated ring of transducers on a simulated base";
    const NEEDS_WORLD: bool = true;
    type Config = SimSonarConfig;

    fn open(config: SimSonarConfig, site: &mut Site<'_>) -> Result<Box<dyn SonarDriver>, Problems> {
        let body = site.arena.and_then(|arena| Some((arena.clone(), arena.find(site.robot)?)));
        let Some((arena, body)) = body else {
            return Err(site.problem("a simulated sonar needs a simulated base", "set the base's `driver = \"sim\"` as well"));
        };
        let NamedRing { ring, model, .. } = site.ring(&config.ring, config.custom.as_ref())?;
        let model = config.model.unwrap_or(model);
        let sonar = SimSonar::new(arena, site.robot, body, ring, &model)
            .map_err(|error| site.problem(error.to_string(), "correct the ring or its model"))?;
        Ok(Box::new(FaultInjector::new(sonar, config.faults.into(), site.streams.stream(site.robot, "sonar faults"))))
    }
}
