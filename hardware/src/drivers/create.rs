//! The driver of Create, Roomba and other bases that speak iRobot's Open Interface.

use orienteer_runtime::config::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BaseKind, OpenBase, Site};
use crate::{
    base::{executor::ExecutorConfig, kinematics::BaseConfig, protection::ProtectionConfig},
    oi::{Client, CreateBase, Profile},
    wire::oi::units::Model,
};

/// A Create or Roomba. It carries no sonars: without any, set `sonar_required = false` in its `protection`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CreateBaseConfig {
    /// Where it is: a serial port (`/dev/ttyUSB0`) or a port of the network (`tcp://host:8102`).
    pub port: String,
    /// Speed of a serial port, baud. Without it the model's own and 19200 are tried in turn.
    #[serde(default)]
    #[schemars(range(min = 300, max = 4_000_000))]
    pub baud: Option<u32>,
    /// The kind of base: its size, its limits and how hard it may brake. The driver keeps to these accelerations.
    #[serde(default = "usual_name")]
    #[schemars(extend("x-names" = "platform"))]
    pub platform: String,
    /// A base of your own, instead of a platform with a name; what it leaves out is as for `b12-huey`.
    #[serde(default)]
    #[schemars(extend("x-instead-of" = "platform"))]
    pub custom: Option<BaseConfig>,
    /// The model: `create2`, `create1`, or `roomba` for the series 500 to 700.
    #[serde(default = "usual_name")]
    #[schemars(extend("x-names" = "create-model"))]
    pub model: String,
    /// How relative motions are carried out.
    #[serde(default)]
    pub motion: ExecutorConfig,
    /// How it protects itself.
    #[serde(default)]
    pub protection: ProtectionConfig,
}

/// Of the model, and of the platform that goes with it.
fn usual_name() -> String {
    Model::CREATE_2.name.to_owned()
}

/// From a command to the first frame that shows what came of it, and half of the time over which a velocity is measured, s.
const LATENCY: f64 = 0.08;
/// The part of it that goes by before it heeds a command, s.
const HEEDS: f64 = 0.05;

pub(super) struct CreateBaseKind;

impl BaseKind for CreateBaseKind {
    const NAME: &'static str = "create";
    const HELP: &'static str = "a Create or Roomba, over a serial port or TCP";
    const REAL_TIME: bool = true;
    const HAS_LINE: bool = true;
    type Config = CreateBaseConfig;

    fn open(config: CreateBaseConfig, site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        let address = site.line(&config.port, config.baud)?;
        let custom = config.custom.is_some();
        let platform = site.base(&config.platform, config.custom)?.platform();
        let model = Model::of(&config.model).ok_or_else(|| {
            site.problem_at(
                "model",
                format!("there is no model `{}`", config.model),
                "`create2`, `create1` and `roomba` are known",
            )
        })?;
        if platform.turning_radius > 0.0 {
            return Err(site.problem_at(
                if custom { "custom" } else { "platform" },
                format!("`{}` can't turn on the spot, as a Create does", platform.name),
                "leave `platform` out, or describe a differential drive in `custom`",
            ));
        }
        if !custom {
            site.expect_body(&config.platform, "a Create or Roomba", &["create2"]);
        }
        let (way, turn) = model.steps();
        let client = Client::new(address, config.baud, Profile::new(model, &platform));
        Ok(OpenBase {
            driver: Box::new(CreateBase::new(client, platform)),
            motion: config.motion.for_a_base(way, turn, LATENCY),
            protection: config.protection.for_a_base(HEEDS),
            start: site.start.unwrap_or_default(),
        })
    }
}
