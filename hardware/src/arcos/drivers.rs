//! Base and sonar of one robot as drivers.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use orienteer_runtime::{
    geometry::Twist,
    robot_model::{Platform, Ring},
    time::Time,
    topics::{FiringProgram, LineState, Odometry, SonarScan},
};

use super::Client;
use crate::driver::{BaseDriver, DriverError, SonarDriver};

/// Scans that wait for a sonar driver; the oldest go when nobody fetches them.
const WAITING: usize = 16;

/// The base at the end of a line.
///
/// It speaks for its sonars, too: what they have heard and how they fire goes through a mailbox. A base is polled by a thread that must
/// never wait, its sonars by one that may be held up at any moment, also in the middle of a look into the mailbox.
pub struct ArcosBase {
    client: Client,
    platform: Platform,
    mailbox: Mailbox,
}

/// The sonars of the same robot.
pub struct ArcosSonar {
    mailbox: Mailbox,
    ring: Ring,
    order: Vec<u8>,
}

/// What passes between a base and its sonars.
#[derive(Clone, Default)]
pub(crate) struct Mailbox(Arc<Mutex<Mail>>);

#[derive(Default)]
struct Mail {
    scans: Vec<SonarScan>,
    /// Why there are none.
    trouble: Option<DriverError>,
    /// The number of transducers and their range, to be told to the session.
    equipment: Option<(usize, f64)>,
    /// The order in which they fire, to be told to the base.
    order: Option<Vec<u8>>,
}

impl Mailbox {
    fn lock(&self) -> MutexGuard<'_, Mail> {
        // Whoever has panicked with it has left it whole: it is filled and emptied in single steps.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The mail, unless the other side has its hand in the box: it is there again in a moment, and nothing is lost by then.
    fn peek(&self) -> Option<MutexGuard<'_, Mail>> {
        match self.0.try_lock() {
            Ok(mail) => Some(mail),
            Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

impl ArcosBase {
    /// A base, which is described as `platform`.
    #[must_use]
    pub fn new(client: Client, platform: Platform) -> Self {
        Self { client, platform, mailbox: Mailbox::default() }
    }

    /// The driver of its sonars, which are described as `ring`.
    #[must_use]
    pub fn sonar(&self, ring: Ring) -> ArcosSonar {
        ArcosSonar::new(self.mailbox(), ring)
    }

    pub(crate) fn mailbox(&self) -> Mailbox {
        self.mailbox.clone()
    }

    /// Takes what the sonars want, before the base is spoken to.
    fn take_orders(&mut self) {
        let Some(mut mail) = self.mailbox.peek() else { return };
        let (equipment, order) = (mail.equipment.take(), mail.order.take());
        drop(mail);
        if let Some((transducers, max_range)) = equipment {
            self.client.session().equip(transducers, max_range);
        }
        if let Some(order) = order {
            self.client.session().fire(order);
        }
    }

    /// Leaves what they have heard, after the base has spoken.
    fn deliver(&mut self, polled: &Result<Odometry, DriverError>) {
        let Some(mut mail) = self.mailbox.peek() else { return };
        self.client.scans(&mut mail.scans);
        let late = mail.scans.len().saturating_sub(WAITING);
        mail.scans.drain(..late);
        mail.trouble = polled.as_ref().err().map(again);
    }
}

impl BaseDriver for ArcosBase {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError> {
        self.client.drive(now, twist);
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        self.take_orders();
        let polled = self.client.poll(now);
        self.deliver(&polled);
        polled
    }

    fn line(&self) -> Option<LineState> {
        Some(self.client.line_state())
    }

    fn stop(&mut self) {
        self.client.halt();
    }
}

impl Drop for ArcosBase {
    fn drop(&mut self) {
        self.mailbox.lock().trouble = Some(DriverError::LinkLost {
            device: self.platform.name.clone(),
            why: "the driver of the base has ended".to_owned(),
        });
    }
}

impl ArcosSonar {
    pub(crate) fn new(mailbox: Mailbox, ring: Ring) -> Self {
        let mut mail = mailbox.lock();
        mail.equipment = Some((ring.transducers.len(), ring.max_range));
        mail.trouble =
            Some(DriverError::Waiting { device: ring.name.clone(), why: "its base has not been asked yet".to_owned() });
        drop(mail);
        Self { mailbox, order: order(&ring.program), ring }
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
            self.mailbox.lock().order = Some(order.clone());
            self.order = order;
        }
    }

    fn poll(&mut self, _now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        let mut mail = self.mailbox.lock();
        scans.append(&mut mail.scans);
        mail.trouble.as_ref().map_or(Ok(()), |error| Err(again(error)))
    }
}

/// A base has one list for all its arrays, and fires each array by what the list has of it.
fn order(program: &FiringProgram) -> Vec<u8> {
    let transducers = |slot: u32| (0..32).filter(move |transducer| slot & 1 << transducer != 0);
    program.slots.iter().flat_map(|slot| transducers(*slot)).collect()
}

/// The same error for somebody else: a base's are its sonars'.
fn again(error: &DriverError) -> DriverError {
    match error {
        DriverError::LinkLost { device, why } => DriverError::LinkLost { device: device.clone(), why: why.clone() },
        DriverError::Waiting { device, why } => DriverError::Waiting { device: device.clone(), why: why.clone() },
        DriverError::Refused { what } => DriverError::Refused { what: what.clone() },
        other => DriverError::Garbled { device: "its base".to_owned(), what: other.to_string() },
    }
}
