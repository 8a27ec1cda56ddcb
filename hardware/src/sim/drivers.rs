//! The drivers through which a simulated body is commanded and heard.

use std::sync::{Arc, Mutex};

use orienteer_runtime::{
    geometry::Twist,
    robot_model::{Platform, Ring},
    time::Time,
    topics::{FiringProgram, Odometry, SonarScan, Truth},
};
use rand_pcg::Pcg64;

use super::{Arena, SimBody, arena::lock, bodies::Others};
use crate::{
    driver::{BaseDriver, DriverError, SonarDriver},
    echo::{self, Pinger, PingerError, SonarModel},
};

/// Drives a simulated body.
#[derive(Debug)]
pub struct SimBase {
    body: Arc<Mutex<SimBody>>,
    platform: Platform,
}

impl SimBase {
    /// A driver of this body, which is described as `platform`.
    #[must_use]
    pub fn new(body: Arc<Mutex<SimBody>>, platform: Platform) -> Self {
        Self { body, platform }
    }

    /// Where the body touches something: see [`SimBody::touched_at`].
    #[must_use]
    pub fn touched_at(&self) -> Option<f64> {
        lock(&self.body).touched_at()
    }
}

impl BaseDriver for SimBase {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, _now: Time, twist: Twist) -> Result<(), DriverError> {
        lock(&self.body).set_demand(twist);
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        let mut body = lock(&self.body);
        body.advance(now);
        Ok(body.odometry())
    }

    fn truth(&self) -> Option<Truth> {
        Some(lock(&self.body).truth())
    }

    fn stop(&mut self) {
        lock(&self.body).set_demand(Twist::STOP);
    }
}

/// Listens from a simulated body.
#[derive(Debug)]
pub struct SimSonar {
    arena: Arc<Arena>,
    body: Arc<Mutex<SimBody>>,
    pinger: Pinger,
    random: Pcg64,
    others: Others<echo::Disc>,
    /// All firings up to this time have been heard.
    until: Time,
}

impl SimSonar {
    /// The ring of this body, with a model of how it hears.
    ///
    /// # Errors
    /// If ring or model make no sense.
    pub fn new(
        arena: Arc<Arena>,
        name: &str,
        body: Arc<Mutex<SimBody>>,
        ring: Ring,
        model: &SonarModel,
    ) -> Result<Self, PingerError> {
        let random = arena.streams().stream(name, "sonar");
        Ok(Self {
            arena,
            body,
            pinger: Pinger::new(ring, model, Time::START)?,
            random,
            others: Others::default(),
            until: Time::START,
        })
    }

    /// Gives a scan with every slot, not only at the end of a pass.
    #[must_use]
    pub fn telling_every_slot(mut self) -> Self {
        self.pinger = self.pinger.telling_every_slot();
        self
    }
}

impl SonarDriver for SimSonar {
    fn ring(&self) -> &Ring {
        self.pinger.ring()
    }

    fn set_program(&mut self, _now: Time, program: &FiringProgram) {
        self.pinger.set_program(program);
    }

    fn poll(&mut self, now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        let mut body = lock(&self.body);
        body.advance(now);
        let reach = self.pinger.ring().max_range + body.radius();
        self.arena.with_bodies(|bodies| self.others.listen(bodies, body.number(), body.pose().point(), reach));
        // At wall time the base's own thread moves the body on, so it may be a little ahead.
        let (from, to) = (self.until, now.max(body.now()));
        let (walls, others) = (self.arena.walls(), self.others.found());
        self.pinger.poll(from, to, |time| body.pose_at(time), walls, others, &mut self.random, scans);
        self.until = to;
        Ok(())
    }
}
