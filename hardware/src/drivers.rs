//! The drivers that a configuration may name, and how they are opened.
//!
//! A driver of your own implements [`BaseKind`] or [`SonarKind`] and is added to a set of [`Drivers`]; from then on a
//! configuration can name it, `check` knows its keys, and `list` shows it.

mod arcos;
mod create;
mod log;
mod sim;

use std::{any::Any, cell::RefCell, sync::Arc, time::Duration};

use orienteer_runtime::{
    config::{Problem, Problems, Section, Sources, Span, mission::DriverInfo, validate},
    geometry::Pose,
    random::Streams,
};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;

use crate::{
    base::{executor::ExecutorConfig, kinematics::BaseConfig, presets, protection::ProtectionConfig},
    driver::{BaseDriver, SonarDriver},
    echo::SonarModel,
    line::{Address, AddressError},
    rings::{self, NamedRing, RingConfig, RingError},
    sim::Arena,
};

pub use arcos::{ArcosBaseConfig, ArcosSonarConfig};
pub use create::CreateBaseConfig;
pub use log::{LogBaseConfig, LogSonarConfig};
pub use sim::{SimBaseConfig, SimSonarConfig};

/// The lines that robots of a mission have.
#[derive(Debug, Default)]
pub struct Lines {
    /// Each with its robot.
    taken: RefCell<Vec<(Address, String)>>,
}

/// What a driver may need to know of the mission and the robot for which it is opened.
pub struct Site<'a> {
    /// The robot's name.
    pub robot: &'a str,
    /// Where the robot starts, if the configuration says so.
    pub start: Option<Pose>,
    /// The simulated world, if the mission has one.
    pub arena: Option<&'a Arc<Arena>>,
    /// The control period.
    pub period: Duration,
    /// Source of random numbers.
    pub streams: Streams,
    /// The files of the mission; those read through this are carried by the recording.
    pub sources: &'a mut Sources,
    /// Where the configuration names the driver.
    pub span: Span,
    /// The driver's own keys, each with its place.
    pub keys: Section,
    /// Where it says where the robot starts, if it does.
    pub start_span: Option<Span>,
    /// What drivers of one robot share, such as a log or a serial line: left by the base for the sonar.
    pub shared: Option<Arc<dyn Any + Send + Sync>>,
    /// The lines that robots of this mission have, and which; see [`Site::line`].
    pub lines: &'a Lines,
    /// What a person should know before anything moves, each at its place: see [`Site::remark`].
    pub remarks: Vec<Problem>,
}

impl Site<'_> {
    /// A problem at the place where the configuration says where the robot starts, or else where it names the driver.
    #[must_use]
    pub fn start_problem(&self, message: impl Into<String>, hint: impl Into<String>) -> Problems {
        Problem::new(self.sources, self.start_span.as_ref().unwrap_or(&self.span), message, hint).into()
    }

    /// The base that a configuration describes, or names.
    fn base(&self, platform: &str, custom: Option<BaseConfig>) -> Result<BaseConfig, Problems> {
        custom.or_else(|| presets::by_name(platform)).ok_or_else(|| {
            self.problem_at(
                "platform",
                format!("there is no platform `{platform}`"),
                "`orienteer list platforms` shows those that there are",
            )
        })
    }

    /// The ring that a configuration describes, or names.
    fn ring(&self, name: &str, custom: Option<&RingConfig>) -> Result<NamedRing, Problems> {
        if let Some(custom) = custom {
            let wrong = |error: RingError| self.problem_at("custom", error.to_string(), "correct the ring's table");
            let ring = custom.ring("custom").map_err(wrong)?;
            return Ok(NamedRing { ring, model: SonarModel::default(), help: "a ring of one's own" });
        }
        rings::find(name).ok_or_else(|| {
            self.problem_at("ring", format!("there is no ring `{name}`"), "`orienteer list rings` shows those that there are")
        })
    }

    /// The address of a device on a line, which no other robot of the mission may have. Only a serial port has a speed.
    ///
    /// # Errors
    /// What is wrong with it, where the configuration gives the keys `port` and `baud`.
    pub fn line(&self, port: &str, baud: Option<u32>) -> Result<Address, Problems> {
        let address: Address = port.parse().map_err(|error: AddressError| {
            self.problem_at("port", error.to_string(), "for instance `/dev/ttyUSB0` or `tcp://192.168.0.7:8101`")
        })?;
        if let (Address::Tcp { .. }, Some(_)) = (&address, baud) {
            let message = format!("`baud` means nothing at `{address}`: only a serial port has a speed");
            return Err(self.problem_at("baud", message, "remove `baud`; whoever passes a serial line on has a setting for it"));
        }
        let mut lines = self.lines.taken.borrow_mut();
        if let Some((_, robot)) = lines.iter().find(|(taken, robot)| *taken == address && robot != self.robot) {
            let message = format!("`{robot}` has the base at `{address}` already");
            return Err(self.problem_at("port", message, "give each robot a port of its own"));
        }
        lines.push((address.clone(), self.robot.to_owned()));
        Ok(address)
    }

    /// A problem at the place where the configuration names the driver.
    #[must_use]
    pub fn problem(&self, message: impl Into<String>, hint: impl Into<String>) -> Problems {
        Problem::new(self.sources, &self.span, message, hint).into()
    }

    /// A problem with the value of one of the driver's keys; where the configuration names the driver if it does not give that key.
    #[must_use]
    pub fn problem_at(&self, key: &str, message: impl Into<String>, hint: impl Into<String>) -> Problems {
        Problem::new(self.sources, &self.place_of(key), message, hint).into()
    }

    /// Remembers something that is allowed, but that a person should know before anything moves, at the value of one of the driver's keys.
    pub fn remark(&mut self, key: &str, message: impl Into<String>, hint: impl Into<String>) {
        self.remarks.push(Problem::new(self.sources, &self.place_of(key), message, hint));
    }

    /// Remarks on a platform that is not the body of this robot, which is one of these.
    fn expect_body(&mut self, platform: &str, of: &str, bodies: &[&str]) {
        if bodies.contains(&platform) {
            return;
        }
        let key = if self.keys.table().contains_key("platform") { "platform" } else { "model" };
        let message = format!("`{platform}` is not the body of {of}: its size, its speed and how it brakes are another robot's");
        let hint = match bodies {
            [] => "describe it in `custom`".to_owned(),
            bodies => format!("set `platform` to `{}`, or describe it in `custom`", bodies.join("` or `")),
        };
        self.remark(key, message, hint);
    }

    fn place_of(&self, key: &str) -> Span {
        if self.keys.table().contains_key(key) { self.keys.span_of(key) } else { self.span.clone() }
    }
}

/// A base that has been opened.
pub struct OpenBase {
    /// Its driver.
    pub driver: Box<dyn BaseDriver>,
    /// How relative motions are carried out.
    pub motion: ExecutorConfig,
    /// How it protects itself.
    pub protection: ProtectionConfig,
    /// Where the robot starts, map frame.
    pub start: Pose,
}

/// A kind of base driver.
pub trait BaseKind {
    /// Its name in a configuration.
    const NAME: &'static str;
    /// One line of help.
    const HELP: &'static str;
    /// True if it needs a simulated world.
    const NEEDS_WORLD: bool = false;
    /// True if it drives a device that knows only real time. A mission on any other clock is refused: it would rush through, and
    /// no guard would stop the base when commands stop coming.
    const REAL_TIME: bool = false;
    /// True if its drivers are at the end of a line, and tell of it with [`BaseDriver::line`].
    const HAS_LINE: bool = false;
    /// Its keys, beside `driver`.
    type Config: DeserializeOwned + JsonSchema;

    /// Opens the driver. `orienteer check` does so, too: a driver of a real device goes to it no sooner than when it is first polled.
    ///
    /// # Errors
    /// If it can't be opened, with the place in the configuration.
    fn open(config: Self::Config, site: &mut Site<'_>) -> Result<OpenBase, Problems>;
}

/// A kind of sonar driver.
pub trait SonarKind {
    /// Its name in a configuration.
    const NAME: &'static str;
    /// One line of help.
    const HELP: &'static str;
    /// True if it needs a simulated world.
    const NEEDS_WORLD: bool = false;
    /// True if it fires a device that knows only real time. A mission on any other clock is refused.
    const REAL_TIME: bool = false;
    /// Its keys, beside `driver`.
    type Config: DeserializeOwned + JsonSchema;

    /// Opens the driver, and leaves its device alone until it is first polled. The robot's base is open by then.
    ///
    /// # Errors
    /// If it can't be opened, with the place in the configuration.
    fn open(config: Self::Config, site: &mut Site<'_>) -> Result<Box<dyn SonarDriver>, Problems>;
}

type Open<T> = fn(&Section, &mut Site<'_>) -> Result<T, Problems>;

/// One kind of driver of a device of type `T`.
pub struct Kind<T> {
    /// Its name in a configuration.
    pub name: &'static str,
    /// What the configuration has to know.
    pub info: DriverInfo,
    /// True if it needs `clock = "wall"`.
    pub real_time: bool,
    /// True if its drivers are at the end of a line.
    pub has_line: bool,
    open: Open<T>,
}

impl<T> Kind<T> {
    /// Opens the driver with these keys.
    ///
    /// # Errors
    /// If the keys do not fit, or it can't be opened.
    pub fn open(&self, keys: &Section, site: &mut Site<'_>) -> Result<T, Problems> {
        site.keys = keys.clone();
        (self.open)(keys, site)
    }
}

/// A set of drivers, in the order in which people should see them.
#[derive(Default)]
pub struct Drivers {
    bases: Vec<Kind<OpenBase>>,
    sonars: Vec<Kind<Box<dyn SonarDriver>>>,
}

impl Drivers {
    /// The drivers that come with Orienteer.
    #[must_use]
    pub fn standard() -> Self {
        let mut drivers = Self::default();
        drivers.add_base::<sim::SimBaseKind>().add_base::<log::LogBaseKind>();
        drivers.add_base::<arcos::ArcosBaseKind>().add_base::<create::CreateBaseKind>();
        drivers.add_sonar::<sim::SimSonarKind>().add_sonar::<log::LogSonarKind>().add_sonar::<arcos::ArcosSonarKind>();
        drivers
    }

    /// Adds a base driver. One of the same name is replaced.
    pub fn add_base<K: BaseKind>(&mut self) -> &mut Self {
        let open: Open<OpenBase> = |keys, site| K::open(validate::read(keys, site.sources)?, site);
        let line = if K::HAS_LINE { LINE_TOPICS } else { &[] };
        let info = info::<K::Config>(K::HELP, K::NEEDS_WORLD, &[BASE_TOPICS, line].concat());
        put(&mut self.bases, Kind { name: K::NAME, info, real_time: K::REAL_TIME, has_line: K::HAS_LINE, open });
        self
    }

    /// Adds a sonar driver. One of the same name is replaced.
    pub fn add_sonar<K: SonarKind>(&mut self) -> &mut Self {
        let open: Open<Box<dyn SonarDriver>> = |keys, site| K::open(validate::read(keys, site.sources)?, site);
        let info = info::<K::Config>(K::HELP, K::NEEDS_WORLD, SONAR_TOPICS);
        put(&mut self.sonars, Kind { name: K::NAME, info, real_time: K::REAL_TIME, has_line: false, open });
        self
    }

    /// The base driver of this name.
    #[must_use]
    pub fn base(&self, name: &str) -> Option<&Kind<OpenBase>> {
        self.bases.iter().find(|kind| kind.name == name)
    }

    /// The sonar driver of this name.
    #[must_use]
    pub fn sonar(&self, name: &str) -> Option<&Kind<Box<dyn SonarDriver>>> {
        self.sonars.iter().find(|kind| kind.name == name)
    }

    /// All base drivers.
    #[must_use]
    pub fn bases(&self) -> &[Kind<OpenBase>] {
        &self.bases
    }

    /// All sonar drivers.
    #[must_use]
    pub fn sonars(&self) -> &[Kind<Box<dyn SonarDriver>>] {
        &self.sonars
    }
}

const BASE_TOPICS: &[&str] = &["base/odometry", "base/motion", "truth"];
const LINE_TOPICS: &[&str] = &["base/line"];
const SONAR_TOPICS: &[&str] = &["sonar/scan"];

fn info<C: JsonSchema>(help: &str, needs_world: bool, writes: &[&str]) -> DriverInfo {
    DriverInfo {
        schema: validate::schema_of::<C>(),
        help: help.to_owned(),
        writes: writes.iter().map(ToString::to_string).collect(),
        needs_world,
    }
}

fn put<T>(kinds: &mut Vec<Kind<T>>, kind: Kind<T>) {
    match kinds.iter_mut().find(|other| other.name == kind.name) {
        Some(other) => *other = kind,
        None => kinds.push(kind),
    }
}
