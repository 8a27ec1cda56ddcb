//! What an ARCOS base says of itself ten times a second.

use std::time::Duration;

use orienteer_runtime::{
    geometry::{Pose, angle::wrap},
    time::Time,
    topics::{Echo, Odometry, SonarScan, flags as state},
};

use super::{Make, motors::Motors};
use crate::wire::arcos::{
    information::{Information, SonarReading, SonarReadings, flags, touch},
    units::{ANGLE, Units},
};

/// A lead battery that is neither full nor empty, 0.1 V.
const BATTERY: u8 = 125;
/// Newer models count positions with all 16 bits.
const NEWER: &str = "-sh";
/// A base that is slower than this does not move, m/s.
const CREEPS: f64 = 0.01;
/// What a transducer says that hears nothing, m.
const FARTHEST: f64 = 5.0;

/// What sonars and wheels have felt since they were told of last.
#[derive(Debug, Clone)]
pub(super) struct Feelings {
    units: Units,
    cycle: Duration,
    /// The bits of a position that are sent.
    mask: u16,
    listens: bool,
    /// What was heard since the last packet.
    heard: SonarReadings,
    next: Time,
}

impl Feelings {
    pub fn new(make: &Make) -> Self {
        Self {
            units: make.units,
            cycle: Duration::from_millis(make.settings.cycle.into()),
            mask: if make.units.model.ends_with(NEWER) { u16::MAX } else { u16::MAX >> 1 },
            listens: false,
            heard: SonarReadings::new(),
            next: Time::START,
        }
    }

    /// Switches the sonars on or off.
    pub fn listen(&mut self, on: bool) {
        self.listens = on;
        self.heard.clear();
    }

    /// Remembers what was heard until it is told; of each transducer the newest.
    pub fn hear(&mut self, scan: &SonarScan) {
        for transducer in (0..scan.len()).filter(|i| self.listens && scan.fired & 1 << i != 0) {
            let metres = match scan.echo(transducer) {
                Echo::Range(range) => f64::from(range),
                Echo::Nothing => FARTHEST,
                Echo::TooNear => 0.0,
                Echo::NotFired => continue,
            };
            // There are 32 at most.
            let transducer = u8::try_from(transducer).unwrap_or(u8::MAX);
            let reading = SonarReading { transducer, range: whole(metres / self.units.range).cast_unsigned() };
            self.heard.retain(|older| older.transducer != transducer);
            self.heard.push(reading);
        }
    }

    /// Appends a packet if it is time for one. The base is `here` in the session's frame.
    pub fn tell(&mut self, now: Time, odometry: &Odometry, here: Pose, motors: &Motors, into: &mut Vec<u8>) {
        if now >= self.next {
            self.next = now + self.cycle;
            self.packet(odometry, here, motors).emit(into);
        }
    }

    fn packet(&mut self, odometry: &Odometry, here: Pose, motors: &Motors) -> Information {
        let position = |metres: f64| whole(metres / self.units.distance).cast_unsigned() & self.mask;
        let speed = |metres: f64| whole(metres / self.units.speed);
        let half = odometry.twist.angular * self.units.tread / 2.0;
        // A wheel stalls that is driven and does not turn; one that rests against a wall feels nothing.
        let touching = odometry.flags & (state::CONTACT | state::STALLED) != 0;
        let stall = if touching && motors.are_driven() && odometry.twist.linear.abs() < CREEPS { touch::STALL } else { 0 };
        let (motors_on, sonars_on) = (u16::from(motors.are_on()) * flags::MOTORS, u16::from(self.listens) * flags::SONARS);
        Information {
            moving: !odometry.twist.is_stop(),
            x: position(here.x),
            y: position(here.y),
            heading: whole(wrap(here.heading) / ANGLE),
            left_speed: speed(odometry.twist.linear - half),
            right_speed: speed(odometry.twist.linear + half),
            battery: BATTERY,
            left: stall,
            right: stall,
            control: whole(wrap(motors.control()) / ANGLE),
            flags: motors_on | sonars_on,
            sonars: std::mem::take(&mut self.heard),
            ..Information::default()
        }
    }
}

/// The nearest whole number, of which the lower 16 bits go over the wire.
#[allow(clippy::cast_possible_truncation)]
fn whole(number: f64) -> i16 {
    number.round() as i64 as i16
}
