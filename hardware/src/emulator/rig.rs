//! An emulator on a simulated body.

use std::{sync::Arc, time::Duration};

use orienteer_runtime::{
    time::Time,
    topics::{Odometry, SonarScan, Truth},
};

use super::Emulator;
use crate::{
    driver::{BaseDriver, SonarDriver},
    sim::{Arena, SimBase, SimSonar},
};

/// Time between two looks at the wire and at the motors.
const BEAT: Duration = Duration::from_millis(10);

/// A simulated robot in its world, driven by an emulator.
pub struct Rig<E> {
    emulator: E,
    arena: Arc<Arena>,
    base: SimBase,
    sonar: Option<SimSonar>,
    now: Time,
    odometry: Odometry,
    scans: Vec<SonarScan>,
}

impl<E: Emulator> Rig<E> {
    /// How long one [`beat`](Self::beat) takes.
    pub const BEAT: Duration = BEAT;

    /// Puts an emulator on a body in this arena, with or without sonar.
    #[must_use]
    pub fn new(emulator: E, arena: Arc<Arena>, base: SimBase, sonar: impl Into<Option<SimSonar>>) -> Self {
        let sonar = sonar.into().map(SimSonar::telling_every_slot);
        Self { emulator, arena, base, sonar, now: Time::START, odometry: Odometry::default(), scans: Vec::with_capacity(16) }
    }

    /// Moves on by one beat: hears what the client has sent, drives, listens, and appends what is to be sent back.
    pub fn beat(&mut self, received: &[u8], into: &mut Vec<u8>) {
        self.now = self.now + BEAT;
        self.emulator.receive(self.now, received);
        // A simulated base always knows where it is, and obeys.
        if let Ok(odometry) = self.base.poll(self.now) {
            self.odometry = odometry;
        }
        self.emulator.feel(self.base.touched_at());
        let twist = self.emulator.drive(self.now, &self.odometry);
        let _ = self.base.command(self.now, twist);
        self.listen();
        self.emulator.transmit(self.now, &self.odometry, into);
        self.arena.advance(BEAT);
    }

    fn listen(&mut self) {
        let Some(sonar) = &mut self.sonar else { return };
        if let Some(mut program) = self.emulator.firing() {
            if program.slots.is_empty() {
                program = sonar.ring().program;
            }
            sonar.set_program(self.now, &program);
        }
        self.scans.clear();
        let _ = sonar.poll(self.now, &mut self.scans);
        for scan in &self.scans {
            self.emulator.hear(scan);
        }
    }

    /// The time in the world, and in the protocol.
    #[must_use]
    pub fn now(&self) -> Time {
        self.now
    }

    /// Where the body truly is, and what it has run into.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.base.truth().unwrap_or_default()
    }

    /// The emulator.
    #[must_use]
    pub fn emulator(&self) -> &E {
        &self.emulator
    }

    /// The emulator, to do something to the robot that no client can.
    pub fn emulator_mut(&mut self) -> &mut E {
        &mut self.emulator
    }
}
