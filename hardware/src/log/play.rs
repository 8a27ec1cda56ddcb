//! A log as the drivers of a base and a ring.

use std::sync::Arc;

use orienteer_runtime::{
    geometry::{Limits, Twist, angle},
    robot_model::{Platform, Ring},
    time::Time,
    topics::{FiringProgram, Odometry, SonarScan, flags},
};

use super::{Entry, SonarLog};
use crate::{
    driver::{BaseDriver, DriverError, SonarDriver},
    rings::robond_8,
};

/// The base that the log was recorded on, as far as it is known: nothing but what the log itself shows. It drove at up to 0.62 m/s;
/// radius and accelerations are our choice and matter to nobody, for a log can't be commanded.
#[must_use]
pub fn platform() -> Platform {
    Platform {
        name: "robond-log".into(),
        radius: 0.25,
        limits: Limits { linear: 1.0, angular: 2.0 },
        acceleration: 1.0,
        angular_acceleration: 2.0,
        turning_radius: 0.0,
    }
}

/// The ring that the log was recorded with.
#[must_use]
pub fn ring() -> Ring {
    robond_8().ring
}

/// A base and a sonar that play the same log.
#[must_use]
pub fn players(log: Arc<SonarLog>) -> (LogBase, LogSonar) {
    let base = LogBase { log: Arc::clone(&log), platform: platform(), next: 0, travelled: 0.0, turned: 0.0 };
    (base, LogSonar { log, ring: ring(), next: 0 })
}

/// Plays the poses of a log as odometry.
///
/// Between two entries the pose moves along the arc that joins them, so that odometry is smooth and exact at the times of the
/// scans. Commands are taken and have no effect. After the last entry every poll is [`DriverError::EndOfLog`].
#[derive(Debug, Clone)]
pub struct LogBase {
    log: Arc<SonarLog>,
    platform: Platform,
    /// The entry that comes next; what lies before it has been added up.
    next: usize,
    travelled: f64,
    turned: f64,
}

/// Plays the readings of a log as scans. After the last entry every poll is [`DriverError::EndOfLog`].
#[derive(Debug, Clone)]
pub struct LogSonar {
    log: Arc<SonarLog>,
    ring: Ring,
    next: usize,
}

/// From one entry to the next.
struct Leg {
    from: Entry,
    to: Entry,
    way: f64,
    turn: f64,
    seconds: f64,
}

impl Leg {
    fn new(from: Entry, to: Entry) -> Self {
        let turn = angle::turn(from.pose.heading, to.pose.heading);
        let half = 0.5 * turn;
        let stretch = if half.abs() < 1e-6 { 1.0 } else { half / half.sin() };
        let ahead = from.pose.between(to.pose).x;
        let way = (from.pose.distance(&to.pose) * stretch).copysign(ahead);
        Self { from, to, way, turn, seconds: to.time.secs_since(from.time) }
    }

    fn share(&self, now: Time) -> f64 {
        (now.secs_since(self.from.time) / self.seconds).clamp(0.0, 1.0)
    }
}

impl LogBase {
    fn leg(&self, next: usize) -> Option<Leg> {
        let entries = self.log.entries();
        Some(Leg::new(*entries.get(next.checked_sub(1)?)?, *entries.get(next)?))
    }
}

impl BaseDriver for LogBase {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, _: Time, _: Twist) -> Result<(), DriverError> {
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        if now > self.log.end() {
            return Err(DriverError::EndOfLog { at: self.log.end() });
        }
        while self.log.entries().get(self.next).is_some_and(|entry| entry.time <= now) {
            if let Some(leg) = self.leg(self.next) {
                self.travelled += leg.way.abs();
                self.turned += leg.turn;
            }
            self.next += 1;
        }
        let mut odometry =
            Odometry { stamp: now, travelled: self.travelled, turned: self.turned, flags: flags::ENABLED, ..Odometry::default() };
        if let Some(leg) = self.leg(self.next) {
            let share = leg.share(now);
            odometry.pose = leg.from.pose.interpolate(leg.to.pose, share);
            odometry.twist = Twist::new(leg.way / leg.seconds, leg.turn / leg.seconds);
            odometry.travelled += share * leg.way.abs();
            odometry.turned += share * leg.turn;
        } else if let Some(last) = self.log.entries().last() {
            odometry.pose = last.pose;
        }
        Ok(odometry)
    }

    fn stop(&mut self) {}
}

impl SonarDriver for LogSonar {
    fn ring(&self) -> &Ring {
        &self.ring
    }

    fn set_program(&mut self, _: Time, _: &FiringProgram) {}

    fn poll(&mut self, now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        while let Some(entry) = self.log.entries().get(self.next).filter(|entry| entry.time <= now) {
            self.next += 1;
            scans.push(SonarScan::from_echoes(entry.time, self.next as u64, &entry.echoes));
        }
        if now > self.log.end() { Err(DriverError::EndOfLog { at: self.log.end() }) } else { Ok(()) }
    }
}
