//! What a Create senses: its wheels, its bumper, and itself.

use std::{f64::consts::FRAC_PI_2, time::Duration};

use orienteer_runtime::{
    geometry::{Pose, Twist},
    time::Time,
    topics::Odometry,
};

use super::wheels::Wheels;
use crate::wire::oi::{
    packet::Id,
    sensors::{Mode, Sensors, bumps, overcurrents, stasis},
    units::{Model, Way},
};

/// What presses the bumper within this angle of straight ahead, rad, presses both halves.
const MIDDLE: f64 = 0.35;
/// A base that is slower than this does not move, m/s.
const CREEPS: f64 = 0.01;
/// On a sharper curve than this, rad/s, the caster does not turn.
const STRAIGHT: f64 = 0.2;
/// A motor that is held for so long draws too much: not every touch does.
const STRAINS: Duration = Duration::from_millis(300);
/// Counts of a wheel, whose circumference Create 2 tells: on Create 1 nobody asks for them.
const COUNT: f64 = match Model::CREATE_2.way {
    Way::Encoders(count) => count,
    Way::Sums => 1.0,
};

/// What a base has sensed since it was switched on.
#[derive(Debug, Clone)]
pub(super) struct Senses {
    sensors: Sensors,
    /// In which direction something is touched, rad.
    touched: Option<f64>,
    /// Since when the wheels are held by that.
    held: Option<Time>,
    /// Where the base was when it was looked at last, and what it had turned by.
    last: Option<(Pose, f64)>,
    /// Ways of the left and the right wheel, in counts.
    counts: [f64; 2],
    /// Way, mm, and turn, °, of which nothing was told yet.
    untold: (f64, f64),
}

impl Senses {
    /// Of a base that stands on the floor, with a battery that is neither full nor empty.
    pub fn new() -> Self {
        let sensors = Sensors {
            voltage: 14_400,
            current: -200,
            temperature: 25,
            charge: 1800,
            capacity: 2700,
            cliff_signals: [2500; 4],
            ..Sensors::default()
        };
        Self { sensors, touched: None, held: None, last: None, counts: [0.0; 2], untold: (0.0, 0.0) }
    }

    /// What is sensed now.
    pub fn sensors(&self) -> &Sensors {
        &self.sensors
    }

    /// Something is touched in this direction, rad, or nothing. The bumper goes round the front half of the body, and is felt on either
    /// side.
    pub fn touch(&mut self, at: Option<f64>) {
        self.touched = at;
        let pressed = match at.filter(|at| at.abs() <= FRAC_PI_2) {
            None => 0,
            Some(at) if at.abs() <= MIDDLE => bumps::LEFT | bumps::RIGHT,
            Some(at) if at > 0.0 => bumps::LEFT,
            Some(_) => bumps::RIGHT,
        };
        self.sensors.bumps_and_drops = self.sensors.bumps_and_drops & bumps::DROPS | pressed;
    }

    /// The wheels, which stand so far apart, have taken the base to where it is now.
    pub fn follow(&mut self, odometry: &Odometry, tread: f64) {
        let (from, turned) = self.last.replace((odometry.pose, odometry.turned)).unwrap_or((odometry.pose, odometry.turned));
        let (way, turn) = (from.between(odometry.pose).x, odometry.turned - turned);
        for (counts, side) in self.counts.iter_mut().zip([-0.5, 0.5]) {
            *counts += (way + side * tread * turn) / COUNT;
        }
        self.untold = (self.untold.0 + way * 1000.0, self.untold.1 + turn.to_degrees());
        [self.sensors.left_encoder, self.sensors.right_encoder] = self.counts.map(wrapped);
        (self.sensors.distance, self.sensors.angle) = (whole(self.untold.0), whole(self.untold.1));
    }

    /// What the base does, and whether something is in its way.
    pub fn note(&mut self, now: Time, mode: Mode, wheels: &Wheels, moves: Twist) {
        let (right, left) = wheels.speeds();
        (self.sensors.requested_velocity, self.sensors.requested_radius) = wheels.circle();
        (self.sensors.requested_right, self.sensors.requested_left) = (right, left);
        self.sensors.mode = mode;
        // Wheels that only begin to turn strain no more than they ever do.
        let ahead = f64::from(i32::from(right) + i32::from(left));
        let held = moves.linear.abs() < CREEPS && self.touched.is_some_and(|at| at.cos() * ahead > 0.0);
        self.held = held.then(|| self.held.unwrap_or(now));
        let blocked = self.held.is_some_and(|since| now.since(since) >= STRAINS);
        // Roughly what is measured of a Create on a level floor, and of one that is held.
        let current = |speed: i16| if speed == 0 { 0 } else { if blocked { 1200 } else { 150 } };
        let strains = |speed: i16, bit: u8| if blocked && speed != 0 { bit } else { 0 };
        self.sensors.overcurrents = strains(right, overcurrents::RIGHT) | strains(left, overcurrents::LEFT);
        self.sensors.motor_currents = [current(left), current(right), 0, 0];
        let goes_ahead = moves.linear > CREEPS && moves.angular.abs() < STRAIGHT;
        self.sensors.stasis = if goes_ahead { stasis::GOES_AHEAD } else { 0 };
    }

    /// Whether it stands on its wheels, and whether there is floor before it.
    pub fn ground(&mut self, lifted: bool, at_edge: bool) {
        let drops = if lifted { bumps::LEFT_DROP | bumps::RIGHT_DROP } else { 0 };
        self.sensors.bumps_and_drops = self.sensors.bumps_and_drops & !bumps::DROPS | drops;
        // Who hangs in the air has no floor ahead either.
        let missing = lifted || at_edge;
        self.sensors.cliffs = [missing; 4];
        self.sensors.cliff_signals = [if missing { 0 } else { 2500 }; 4];
    }

    /// So many packets are streamed.
    pub fn streams(&mut self, packets: usize) {
        self.sensors.stream_packets = u8::try_from(packets).unwrap_or(u8::MAX);
    }

    /// A packet has been told: way and turn count from there. What is less than a whole one is told the next time.
    pub fn told(&mut self, id: Id) {
        match id {
            Id::Distance => {
                self.untold.0 -= f64::from(self.sensors.distance);
                self.sensors.distance = 0;
            }
            Id::Angle => {
                self.untold.1 -= f64::from(self.sensors.angle);
                self.sensors.angle = 0;
            }
            _ => {}
        }
    }
}

/// Whole counts, as far as 16 bits go.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn wrapped(counts: f64) -> u16 {
    (counts.floor() as i64).rem_euclid(1 << 16) as u16
}

/// The whole part, no greater than 16 bits can tell.
#[allow(clippy::cast_possible_truncation)]
fn whole(number: f64) -> i16 {
    number.clamp(f64::from(i16::MIN), i16::MAX.into()) as i16
}
