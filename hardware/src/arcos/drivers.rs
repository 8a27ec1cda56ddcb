//! Base and sonar of one robot as drivers.

use orienteer_runtime::{
    geometry::Twist,
    robot_model::{Platform, Ring},
    time::Time,
    topics::{FiringProgram, LineState, Odometry, SonarScan},
};

use super::client::{Client, SharedClient};
use crate::driver::{BaseDriver, DriverError, SonarDriver};

/// The base at the end of a line.
pub struct ArcosBase {
    client: SharedClient,
    platform: Platform,
}

/// The sonars of the same robot.
pub struct ArcosSonar {
    client: SharedClient,
    ring: Ring,
    order: Vec<u8>,
}

impl ArcosBase {
    /// A base, which is described as `platform`.
    #[must_use]
    pub fn new(client: Client, platform: Platform) -> Self {
        Self { client: SharedClient::new(client), platform }
    }

    /// The driver of its sonars, which are described as `ring`.
    #[must_use]
    pub fn sonar(&self, ring: Ring) -> ArcosSonar {
        ArcosSonar::new(self.client.clone(), ring)
    }

    pub(crate) fn client(&self) -> SharedClient {
        self.client.clone()
    }
}

impl BaseDriver for ArcosBase {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError> {
        self.client.lock().drive(now, twist);
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        self.client.lock().poll(now)
    }

    fn line(&self) -> Option<LineState> {
        Some(self.client.lock().line_state())
    }

    fn stop(&mut self) {
        self.client.lock().halt();
    }
}

impl Drop for ArcosBase {
    /// The sonar may keep the client for a while; the session ends now.
    fn drop(&mut self) {
        self.client.lock().close();
    }
}

impl ArcosSonar {
    pub(crate) fn new(client: SharedClient, ring: Ring) -> Self {
        client.lock().session().equip(ring.transducers.len(), ring.max_range);
        Self { client, order: order(&ring.program), ring }
    }
}

impl SonarDriver for ArcosSonar {
    fn ring(&self) -> &Ring {
        &self.ring
    }

    fn set_program(&mut self, _now: Time, program: &FiringProgram) {
        let order = order(program);
        // The base begins with the order of its ring.
        if order != self.order {
            self.client.lock().session().fire(order.iter().copied());
            self.order = order;
        }
    }

    fn poll(&mut self, _now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        self.client.lock().scans(scans)
    }
}

/// A base has one list for all its arrays, and fires each array by what the list has of it.
fn order(program: &FiringProgram) -> Vec<u8> {
    let transducers = |slot: u32| (0..32).filter(move |transducer| slot & 1 << transducer != 0);
    program.slots.iter().flat_map(|slot| transducers(*slot)).collect()
}
