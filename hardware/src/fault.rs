//! A driver that misbehaves on purpose.
//!
//! [`FaultInjector`] goes around any base or sonar driver and spoils what comes out of it, by a seeded plan. The device behind it
//! is always moved on, so that a fault hides the world and does not stop it.
//!
//! | fault | a base | a sonar |
//! |---|---|---|
//! | `drop` | the reading is missed: the one before comes again, with its old stamp | the scan never comes |
//! | `delay` | readings come late, with the stamp of when they were taken | scans come late |
//! | `freeze` | the values stand still, the stamps go on (a stuck encoder) | the ranges stand still, the stamps go on |
//! | `not_a_number` | pose and velocity are NaN | – |
//! | `link_lost` | polls and commands fail; the base's own firmware stops it after a while | polls fail, scans are lost |
//! | `silent` | – | no scan comes, and no error |

mod config;

use std::{collections::VecDeque, time::Duration};

use orienteer_runtime::{
    geometry::{Pose, Twist},
    robot_model::{Platform, Ring},
    time::Time,
    topics::{FiringProgram, LineState, Odometry, SonarScan, Truth},
};
use rand::RngExt;
use rand_pcg::Pcg64;

use self::config::in_any;
pub use self::config::{BaseFaults, FaultConfig, Interval, SonarFaults};
use crate::driver::{BaseDriver, DriverError, SonarDriver};

/// A driver with faults. Works around a [`BaseDriver`] and around a [`SonarDriver`].
#[derive(Debug, Clone)]
pub struct FaultInjector<D> {
    inner: D,
    config: FaultConfig,
    rng: Pcg64,
    /// Readings on their way, by when they were taken.
    late_odometry: VecDeque<(Time, Odometry)>,
    late_scans: VecDeque<(Time, SonarScan)>,
    last_odometry: Option<Odometry>,
    last_scan: Option<SonarScan>,
    fetched: Vec<SonarScan>,
    heard: Time,
    /// When the driver was last asked for anything.
    asked: Time,
}

impl<D> FaultInjector<D> {
    /// Puts faults around `inner`. Give each driver a random stream of its own.
    pub fn new(inner: D, config: FaultConfig, rng: Pcg64) -> Self {
        Self {
            inner,
            config,
            rng,
            late_odometry: VecDeque::new(),
            late_scans: VecDeque::new(),
            last_odometry: None,
            last_scan: None,
            fetched: Vec::new(),
            heard: Time::START,
            asked: Time::START,
        }
    }

    /// The driver inside.
    pub fn into_inner(self) -> D {
        self.inner
    }

    fn link(&self, now: Time, device: &str) -> Result<(), DriverError> {
        if in_any(&self.config.link_lost, now) {
            return Err(DriverError::LinkLost { device: device.into(), why: "injected fault".into() });
        }
        Ok(())
    }

    fn is_dropped(&mut self) -> bool {
        // drawn even when nothing is dropped, so that one fault does not shift another
        self.rng.random::<f64>() < self.config.drop
    }

    fn delay(&self) -> Duration {
        Duration::from_secs_f64(self.config.delay.clamp(0.0, 1e6))
    }
}

impl<D: BaseDriver> BaseDriver for FaultInjector<D> {
    fn platform(&self) -> &Platform {
        self.inner.platform()
    }

    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError> {
        self.asked = now;
        self.link(now, "the base")?;
        self.heard = now;
        self.inner.command(now, twist)
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        self.asked = now;
        let fresh = self.inner.poll(now);
        if let Err(lost) = self.link(now, "the base") {
            if now.secs_since(self.heard) >= self.config.firmware_timeout {
                self.inner.stop();
            }
            return Err(lost);
        }
        let mut odometry = fresh?;
        if in_any(&self.config.freeze, now) {
            let stamp = odometry.stamp;
            odometry = Odometry { stamp, ..self.last_odometry.unwrap_or(odometry) };
        }
        if self.is_dropped() && self.last_odometry.is_some() {
            odometry = self.last_odometry.unwrap_or(odometry);
        }
        self.last_odometry = Some(odometry);
        let mut odometry = self.late(now, odometry);
        if in_any(&self.config.not_a_number, now) {
            odometry.pose = Pose { x: f64::NAN, y: f64::NAN, heading: f64::NAN };
            odometry.twist = Twist::new(f64::NAN, f64::NAN);
        }
        Ok(odometry)
    }

    fn truth(&self) -> Option<Truth> {
        self.inner.truth()
    }

    fn line(&self) -> Option<LineState> {
        self.inner.line()
    }

    /// A stop takes the same way as any command: with the link lost, only the base's own firmware can stop it.
    fn stop(&mut self) {
        if !in_any(&self.config.link_lost, self.asked) {
            self.inner.stop();
        }
    }
}

impl<D> FaultInjector<D> {
    /// The newest reading that has arrived; the first one if none has.
    fn late(&mut self, now: Time, odometry: Odometry) -> Odometry {
        if self.config.delay <= 0.0 {
            return odometry;
        }
        self.late_odometry.push_back((now + self.delay(), odometry));
        while self.late_odometry.get(1).is_some_and(|(due, _)| *due <= now) {
            self.late_odometry.pop_front();
        }
        self.late_odometry.front().map_or(odometry, |(_, arrived)| *arrived)
    }
}

impl<D: SonarDriver> SonarDriver for FaultInjector<D> {
    fn ring(&self) -> &Ring {
        self.inner.ring()
    }

    fn set_program(&mut self, now: Time, program: &FiringProgram) {
        if self.link(now, "the sonar").is_ok() {
            self.inner.set_program(now, program);
        }
    }

    fn poll(&mut self, now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        let mut fetched = std::mem::take(&mut self.fetched);
        fetched.clear();
        let polled = self.inner.poll(now, &mut fetched);
        let link = self.link(now, "the sonar");
        let is_silent = link.is_err() || in_any(&self.config.silent, now);
        for scan in &fetched {
            if self.is_dropped() || is_silent {
                continue;
            }
            let scan = self.frozen(now, *scan);
            self.late_scans.push_back((now + self.delay(), scan));
        }
        self.fetched = fetched;
        link?;
        while !is_silent && self.late_scans.front().is_some_and(|(due, _)| *due <= now) {
            scans.extend(self.late_scans.pop_front().map(|(_, scan)| scan));
        }
        polled
    }
}

impl<D> FaultInjector<D> {
    fn frozen(&mut self, now: Time, scan: SonarScan) -> SonarScan {
        if in_any(&self.config.freeze, now)
            && let Some(old) = self.last_scan
        {
            let mut frozen = old;
            (frozen.stamp, frozen.seq, frozen.fired) = (scan.stamp, scan.seq, scan.fired);
            return frozen;
        }
        self.last_scan = Some(scan);
        scan
    }
}

#[cfg(test)]
mod tests;
