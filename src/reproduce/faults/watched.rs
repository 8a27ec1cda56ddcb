//! A simulated base that notes what it is told and what it does.

use std::time::Instant;

use orienteer_hardware::{
    base::presets,
    driver::{BaseDriver, DriverError},
    drivers::{BaseKind, OpenBase, SimBaseConfig, Site},
    sim::{SimBase, SimBodyConfig},
};
use orienteer_runtime::{
    config::Problems,
    geometry::Twist,
    robot_model::Platform,
    time::Time,
    topics::{Odometry, Truth},
};

use super::{Notebook, lock, notebook};

/// The kind of driver.
pub struct WatchedBase;

impl BaseKind for WatchedBase {
    const NAME: &'static str = "watched";
    const HELP: &'static str = "a simulated base that notes its commands";
    const NEEDS_WORLD: bool = true;
    type Config = SimBaseConfig;

    fn open(config: SimBaseConfig, site: &mut Site<'_>) -> Result<OpenBase, Problems> {
        let (Some(arena), Some(base)) = (site.arena, presets::by_name(&config.platform)) else {
            return Err(site.problem("a watched base needs a world and a platform that there is", "add `[world]`"));
        };
        let (platform, start) = (base.platform(), site.start.unwrap_or_default());
        let body = arena
            .add(site.robot, start, SimBodyConfig { base, odometry: config.odometry })
            .map_err(|error| site.problem(error.to_string(), "choose another `start`"))?;
        let driver = Watched { inner: SimBase::new(body, platform), notes: notebook() };
        Ok(OpenBase { driver: Box::new(driver), motion: config.motion, protection: config.protection, start })
    }
}

struct Watched {
    inner: SimBase,
    notes: Notebook,
}

impl BaseDriver for Watched {
    fn platform(&self) -> &Platform {
        self.inner.platform()
    }

    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError> {
        let done = self.inner.command(now, twist);
        let when = Instant::now();
        lock(&self.notes.base).told.push((when, twist));
        done
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        let odometry = self.inner.poll(now);
        if let Some(truth) = self.inner.truth() {
            lock(&self.notes.base).speeds.push((Instant::now(), truth.twist.linear));
        }
        odometry
    }

    fn truth(&self) -> Option<Truth> {
        self.inner.truth()
    }

    fn stop(&mut self) {
        self.inner.stop();
        lock(&self.notes.base).told.push((Instant::now(), Twist::STOP));
    }
}
