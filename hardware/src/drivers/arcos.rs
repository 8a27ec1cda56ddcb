//! The drivers of Pioneer, AmigoBot and other bases that speak ARCOS.

use std::sync::Arc;

use orienteer_runtime::config::Problems;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BaseKind, OpenBase, Site, SonarKind};
use crate::{
    arcos::{ArcosBase, ArcosSonar, Client, Mailbox, Profile},
    base::{executor::ExecutorConfig, kinematics::BaseConfig, protection::ProtectionConfig},
    driver::SonarDriver,
    rings::RingConfig,
    wire::arcos::units::Units,
};

/// A base that speaks ARCOS, as Pioneers and AmigoBots do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArcosBaseConfig {
    /// Where it is: a serial port (`/dev/ttyUSB0`) or a port of the network (`tcp://host:8101`).
    pub port: String,
    /// Speed of a serial port, baud. Without it 9600, 19200, 38400, 57600 and 115200 are tried in turn.
    #[serde(default)]
    #[schemars(range(min = 300, max = 4_000_000))]
    pub baud: Option<u32>,
    /// The kind of base: its size, its limits and how hard it may brake. The base is told to keep to these accelerations.
    #[serde(default = "usual_platform")]
    #[schemars(extend("x-names" = "platform"))]
    pub platform: String,
    /// A base of your own, instead of a platform with a name; what it leaves out is as for `b12-huey`.
    #[serde(default)]
    #[schemars(extend("x-instead-of" = "platform"))]
    pub custom: Option<BaseConfig>,
    /// The model, by which its units are known. Without it, the base's own word is taken.
    #[serde(default)]
    #[schemars(extend("x-names" = "arcos-model"))]
    pub model: Option<String>,
    /// How relative motions are carried out.
    #[serde(default)]
    pub motion: ExecutorConfig,
    /// How it protects itself.
    #[serde(default)]
    pub protection: ProtectionConfig,
}

fn usual_platform() -> String {
    "p3dx".to_owned()
}

/// Whose body it is, and the platforms that have it: of this model, or of any that speaks ARCOS.
fn bodies(model: Option<&str>) -> (String, &'static [&'static str]) {
    let of = |model| format!("the model `{model}`");
    match model {
        None => ("a base that speaks ARCOS".to_owned(), &["p3dx", "amigobot"]),
        Some(model) if model.starts_with("amigo") => (of(model), &["amigobot"]),
        // Four wheels, and larger.
        Some(model) if model.contains("at") => (of(model), &[]),
        Some(model) => (of(model), &["p3dx"]),
    }
}

/// The least way and turn that can be asked for at the end of a motion, m and rad: velocities are whole mm/s and °/s.
const STEPS: (f64, f64) = (0.0005, 0.0026);
/// A base says where it is ten times a second, and has been told in between, s.
const LATENCY: f64 = 0.15;
/// It may heed a command only in its next cycle, and what it told of its sonars may be half a cycle older than is assumed, s.
const HEEDS: f64 = 0.15;

pub(super) struct ArcosBaseKind;

impl BaseKind for ArcosBaseKind {
    const NAME: &'static str = "arcos";
    const HELP: &'static str = "a Pioneer, AmigoBot or other base that speaks ARCOS, over a serial port or TCP";
    const REAL_TIME: bool = true;
    const HAS_LINE: bool = true;
    type Config = ArcosBaseConfig;

    fn open(config: ArcosBaseConfig, site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        let address = site.line(&config.port, config.baud)?;
        let custom = config.custom.is_some();
        let base = site.base(&config.platform, config.custom)?;
        let units = match &config.model {
            None => None,
            Some(model) => Some(Units::of(model).ok_or_else(|| {
                site.problem_at(
                    "model",
                    format!("there is no model `{model}`"),
                    "leave it out, and the base says itself what it is",
                )
            })?),
        };
        if !custom {
            let (of, bodies) = bodies(units.map(|units| units.model));
            site.expect_body(&config.platform, &of, bodies);
        }
        let platform = base.platform();
        let profile = Profile {
            units,
            acceleration: platform.acceleration,
            angular_acceleration: platform.angular_acceleration,
            transducers: 0,
            max_range: 0.0,
        };
        let driver = ArcosBase::new(Client::new(address, config.baud, profile), platform);
        site.shared = Some(Arc::new(driver.mailbox()));
        Ok(OpenBase {
            driver: Box::new(driver),
            motion: config.motion.for_a_base(STEPS.0, STEPS.1, LATENCY),
            protection: config.protection.for_a_base(HEEDS),
            start: site.start.unwrap_or_default(),
        })
    }
}

/// The sonars of a base that speaks ARCOS.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ArcosSonarConfig {
    /// The ring.
    #[schemars(extend("x-names" = "ring"))]
    pub ring: String,
    /// A ring of your own, instead of one with a name.
    #[schemars(extend("x-instead-of" = "ring"))]
    pub custom: Option<RingConfig>,
}

impl Default for ArcosSonarConfig {
    fn default() -> Self {
        Self { ring: "p3dx-16".to_owned(), custom: None }
    }
}

pub(super) struct ArcosSonarKind;

impl SonarKind for ArcosSonarKind {
    const NAME: &'static str = "arcos";
    const HELP: &'static str = "the sonars of the robot's base, if that speaks ARCOS";
    const REAL_TIME: bool = true;
    type Config = ArcosSonarConfig;

    fn open(config: ArcosSonarConfig, site: &mut Site<'_>) -> Result<Box<dyn SonarDriver>, Problems> {
        let mailbox = site.shared.take().and_then(|shared| shared.downcast::<Mailbox>().ok());
        let Some(mailbox) = mailbox else {
            return Err(site.problem("these sonars hang on their base", "set the base's `driver = \"arcos\"` as well"));
        };
        let ring = site.ring(&config.ring, config.custom.as_ref())?.ring;
        Ok(Box::new(ArcosSonar::new((*mailbox).clone(), ring)))
    }
}
