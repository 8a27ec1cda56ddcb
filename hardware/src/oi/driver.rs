//! The base as a driver.

use orienteer_runtime::{
    geometry::Twist,
    robot_model::Platform,
    time::Time,
    topics::{LineState, Odometry},
};

use super::Client;
use crate::driver::{BaseDriver, DriverError};

/// The base at the end of a line.
pub struct CreateBase {
    client: Client,
    platform: Platform,
}

impl CreateBase {
    /// A base, which is described as `platform`.
    #[must_use]
    pub fn new(client: Client, platform: Platform) -> Self {
        Self { client, platform }
    }
}

impl BaseDriver for CreateBase {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError> {
        self.client.drive(now, twist);
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        self.client.poll(now)
    }

    fn line(&self) -> Option<LineState> {
        Some(self.client.line_state())
    }

    fn stop(&mut self) {
        self.client.halt();
    }
}
