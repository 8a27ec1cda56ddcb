//! Drivers: what every base and every sonar ring looks like from outside.
//!
//! A driver is **polled**, never blocks and has no clock of its own: it is told the time. Simulated, recorded and real devices
//! look alike, and wrappers such as [`FaultInjector`](crate::fault::FaultInjector) go around any of them.
//!
//! A device that can only be waited for needs a thread of its driver's own to wait. While a call to a driver blocks, nobody can tell
//! the base to stop: not even the guard that does so when commands stop coming, for it has to call the driver, too.
//!
//! In each control period whoever runs a base calls, in this order: [`BaseDriver::poll`] for the newest odometry,
//! [`SonarDriver::poll`] for finished scans, and, once all is decided, [`BaseDriver::command`].
//!
//! ```
//! use orienteer_hardware::driver::{BaseDriver, DriverError};
//! use orienteer_runtime::{geometry::Twist, robot_model::Platform, time::Time, topics::Odometry};
//!
//! /// A base on a shelf.
//! struct Shelved(Platform);
//!
//! impl BaseDriver for Shelved {
//!     fn platform(&self) -> &Platform {
//!         &self.0
//!     }
//!     fn command(&mut self, _: Time, twist: Twist) -> Result<(), DriverError> {
//!         if twist.is_stop() { Ok(()) } else { Err(DriverError::Refused { what: "this base has no wheels".into() }) }
//!     }
//!     fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
//!         Ok(Odometry { stamp: now, ..Odometry::default() })
//!     }
//!     fn stop(&mut self) {}
//! }
//! ```

use orienteer_runtime::{
    geometry::Twist,
    robot_model::{Platform, Ring},
    time::Time,
    topics::{FiringProgram, LineState, Odometry, SonarScan, Truth},
};
use thiserror::Error;

/// Why a driver could not do what it was asked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DriverError {
    /// Nothing gets through to the device. It may come back; go on polling.
    #[error("the link to {device} is lost: {why}")]
    LinkLost {
        /// The device.
        device: String,
        /// What was noticed.
        why: String,
    },
    /// The device has not been there yet. It may come; go on polling.
    #[error("{device} is not there yet: {why}")]
    Waiting {
        /// The device.
        device: String,
        /// What was noticed.
        why: String,
    },
    /// The device got the command and does not do it. It will not do it the next time either.
    #[error("refused: {what}")]
    Refused {
        /// What was refused and why.
        what: String,
    },
    /// The device sent something that makes no sense. It may make sense again.
    #[error("{device} sent nonsense: {what}")]
    Garbled {
        /// The device.
        device: String,
        /// What was wrong with it.
        what: String,
    },
    /// A port or a file failed.
    #[error("{what}")]
    Io {
        /// Which port or file, and what was tried.
        what: String,
        /// The operating system's answer.
        source: std::io::Error,
    },
    /// A recorded log is at its end; there is nothing more to come.
    #[error("the log ended at {at}")]
    EndOfLog {
        /// The time of its last entry.
        at: Time,
    },
}

impl DriverError {
    /// True if polling again later makes sense.
    #[must_use]
    pub fn may_recover(&self) -> bool {
        matches!(self, DriverError::LinkLost { .. } | DriverError::Waiting { .. } | DriverError::Garbled { .. })
    }
}

/// A mobile base.
pub trait BaseDriver: Send {
    /// What the base is and can do.
    fn platform(&self) -> &Platform;

    /// Sets the velocity from `now` on. It holds until the next command; the caller sees to it that it does not hold for too long.
    ///
    /// # Errors
    /// [`DriverError`]; the base may then still carry out the command before.
    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError>;

    /// Moves the device on to `now` and reads its newest odometry, which may be older than `now`.
    ///
    /// # Errors
    /// [`DriverError`] if there is none.
    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError>;

    /// Where the base truly is, for a simulated base; for recordings and experiments only.
    fn truth(&self) -> Option<Truth> {
        None
    }

    /// How well the line to the base carries, if it is at the end of one. See [`BaseKind::HAS_LINE`](crate::drivers::BaseKind::HAS_LINE).
    fn line(&self) -> Option<LineState> {
        None
    }

    /// Comes to rest by all means that are left, whatever was commanded. Must not fail or wait; called when everything else has.
    fn stop(&mut self);
}

/// A sonar ring.
pub trait SonarDriver: Send {
    /// The transducers.
    fn ring(&self) -> &Ring;

    /// Fires by this program from the next pass on. Transducers that the ring does not have are left out.
    fn set_program(&mut self, now: Time, program: &FiringProgram);

    /// Moves the device on to `now` and appends the scans completed since the last poll, oldest first. `scans` is not cleared, so
    /// that a caller can reuse it.
    ///
    /// # Errors
    /// [`DriverError`]; scans that were complete are appended all the same.
    fn poll(&mut self, now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError>;
}

impl<D: BaseDriver + ?Sized> BaseDriver for Box<D> {
    fn platform(&self) -> &Platform {
        (**self).platform()
    }

    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError> {
        (**self).command(now, twist)
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        (**self).poll(now)
    }

    fn truth(&self) -> Option<Truth> {
        (**self).truth()
    }

    fn line(&self) -> Option<LineState> {
        (**self).line()
    }

    fn stop(&mut self) {
        (**self).stop();
    }
}

impl<D: SonarDriver + ?Sized> SonarDriver for Box<D> {
    fn ring(&self) -> &Ring {
        (**self).ring()
    }

    fn set_program(&mut self, now: Time, program: &FiringProgram) {
        (**self).set_program(now, program);
    }

    fn poll(&mut self, now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        (**self).poll(now, scans)
    }
}
