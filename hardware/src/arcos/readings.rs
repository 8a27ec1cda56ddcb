//! What a base says of itself, in metres and radians.

use nalgebra::{Rotation2, Vector2};
use orienteer_runtime::{
    geometry::{Pose, Twist},
    time::Time,
    topics::{Echo, Odometry, SonarScan, flags as state},
};

use crate::wire::arcos::{
    information::{Information, flags, touch},
    units::{ANGLE, Units, Unwrapped},
};

/// Scans that wait for a sonar driver; the oldest goes when nobody fetches them.
const WAITING: usize = 16;

/// The base's own cycle, s. What a packet tells of its sonars came in within the cycle before it, nobody knows when: it is taken to
/// have come in the middle.
const CYCLE: f64 = 0.1;

/// Odometry and scans of one base, packet by packet.
///
/// The pose is relative to where the base stood at its first packet, and goes on from there when the base was switched off and on:
/// whatever it was moved in between, nobody knows.
#[derive(Debug, Clone)]
pub struct Readings {
    units: Units,
    unwrapped: Unwrapped,
    /// How far the base's own frame, in which it counts, is turned against ours, in its units; unknown until its next packet.
    frame: Option<i64>,
    odometry: Option<Odometry>,
    scan: SonarScan,
    /// Range of a transducer that hears nothing, m.
    max_range: f32,
    scans: Vec<SonarScan>,
}

impl Readings {
    /// Of a base with so many transducers that hear up to `max_range` m.
    #[must_use]
    pub fn new(units: Units, transducers: usize, max_range: f64) -> Self {
        Self {
            units,
            unwrapped: Unwrapped::default(),
            frame: None,
            odometry: None,
            scan: SonarScan::unfired(transducers),
            max_range: max_range as f32,
            scans: Vec::with_capacity(WAITING),
        }
    }

    /// Takes in a packet that came at `now`.
    pub fn follow(&mut self, now: Time, packet: &Information) {
        let before = self.unwrapped;
        self.unwrapped.follow(packet);
        // The base may begin at any heading.
        let frame = *self.frame.get_or_insert(self.unwrapped.heading - i64::from(packet.heading));
        let metres = |units: i64| units as f64 * self.units.distance;
        let way = Vector2::new(metres(self.unwrapped.x - before.x), metres(self.unwrapped.y - before.y));
        let turned = self.unwrapped.heading as f64 * ANGLE;
        let (from, travelled) = self.odometry.map_or_else(Default::default, |odometry| (odometry.pose, odometry.travelled));
        let at = from.point() + Rotation2::new(frame as f64 * ANGLE) * way;
        self.odometry = Some(Odometry {
            stamp: now,
            pose: Pose::new(at.x, at.y, turned),
            twist: self.twist(packet),
            travelled: travelled + way.norm(),
            turned,
            battery: volts(packet),
            flags: state_of(packet),
        });
        self.hear(now, packet);
    }

    /// The base begins anew: its counters stand somewhere else, and its frame is another. It may even be another base.
    pub fn begin_anew(&mut self, units: Units) {
        self.units = units;
        self.unwrapped.begin_anew();
        self.frame = None;
    }

    /// The newest odometry; `None` before the first packet.
    #[must_use]
    pub fn odometry(&self) -> Option<Odometry> {
        self.odometry
    }

    /// Moves the scans that have come since the last call to the end of a list, oldest first.
    pub fn fetch(&mut self, into: &mut Vec<SonarScan>) {
        into.append(&mut self.scans);
    }

    fn twist(&self, packet: &Information) -> Twist {
        let speed = |units: i16| f64::from(units) * self.units.speed;
        let (left, right) = (speed(packet.left_speed), speed(packet.right_speed));
        let measured = packet.more.and_then(|more| more.turn_rate).map(|rate| (f64::from(rate) / 10.0).to_radians());
        Twist::new((left + right) / 2.0, measured.unwrap_or((right - left) / self.units.tread))
    }

    fn hear(&mut self, now: Time, packet: &Information) {
        if packet.sonars.is_empty() || self.scan.is_empty() {
            return;
        }
        let since = now.secs_since(self.scan.stamp);
        let age = (0.5 * since.clamp(0.0, CYCLE)) as f32;
        self.scan.grow_older(since as f32);
        (self.scan.stamp, self.scan.fired) = (now, 0);
        for reading in &packet.sonars {
            let range = (f64::from(reading.range) * self.units.range) as f32;
            let echo = match range {
                range if range >= self.max_range => Echo::Nothing,
                range if range > 0.0 => Echo::Range(range),
                _ => Echo::TooNear,
            };
            self.scan.set(reading.transducer.into(), echo, age);
        }
        self.scan.seq += 1;
        if self.scans.len() == WAITING {
            self.scans.remove(0);
        }
        self.scans.push(self.scan);
    }
}

fn volts(packet: &Information) -> f32 {
    let tenths = packet.more.and_then(|more| more.battery).unwrap_or(packet.battery.into());
    f32::from(tenths) / 10.0
}

/// Motors that somebody has switched off are an emergency stop: it is not for a program to switch them on again.
fn state_of(packet: &Information) -> u32 {
    let motors = packet.flags & flags::MOTORS != 0;
    let stopped = !motors || packet.flags & flags::STOP_BUTTON != 0;
    [
        (motors, state::ENABLED),
        (packet.stalls(), state::STALLED),
        (packet.bumps(), state::CONTACT),
        (packet.right & touch::BUMPERS != 0, state::CONTACT_AHEAD),
        (packet.left & touch::BUMPERS != 0, state::CONTACT_BEHIND),
        (stopped, state::EMERGENCY_STOP),
    ]
    .into_iter()
    .filter_map(|(is, flag)| is.then_some(flag))
    .sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::wire::arcos::information::{More, SonarReading};

    fn readings(model: &str) -> Readings {
        Readings::new(Units::of(model).unwrap(), 16, 5.0)
    }

    fn at(seconds: f64) -> Time {
        Time::from_secs_f64(seconds)
    }

    /// A P3-DX that faces along its own y axis drives a metre: 2062 units, 0.485 mm each.
    #[test]
    fn the_pose_is_relative_to_the_first_packet() {
        let mut readings = readings("p3dx");
        let packet = Information { x: 5, y: 32_000, heading: 1024, flags: flags::MOTORS, ..Information::default() };
        readings.follow(at(1.0), &packet);
        assert_eq!(readings.odometry().unwrap().pose, Pose::default());
        let moved = Information { y: (32_000 + 2062) % 32_768, left_speed: 300, right_speed: 300, ..packet.clone() };
        readings.follow(at(4.0), &moved);
        let odometry = readings.odometry().unwrap();
        assert!((odometry.pose.x - 1.0).abs() < 1e-3 && odometry.pose.y.abs() < 1e-9 && odometry.pose.heading.abs() < 1e-9);
        assert!((odometry.travelled - 1.0).abs() < 1e-3 && (odometry.twist.linear - 0.3).abs() < 1e-12);
        let turned = Information { heading: 2048 - 4096, left_speed: -100, right_speed: 100, ..moved };
        readings.follow(at(5.0), &turned);
        let odometry = readings.odometry().unwrap();
        assert!((odometry.turned - FRAC_PI_2).abs() < 1e-9 && (odometry.pose.heading - FRAC_PI_2).abs() < 1e-9);
        assert!((odometry.twist.angular - 0.56).abs() < 1e-9, "{:?}", odometry.twist);
    }

    /// It counts from nothing again, and its x axis lies where it faces now.
    #[test]
    fn a_base_that_begins_anew_goes_on_from_where_it_was() {
        let mut readings = readings("p3dx-sh");
        let at_rest = Information { flags: flags::MOTORS, ..Information::default() };
        for packet in [Information { x: 2000, ..at_rest.clone() }, Information { x: 3000, heading: 1024, ..at_rest.clone() }] {
            readings.follow(at(1.0), &packet);
        }
        readings.begin_anew(Units::of("p3dx-sh").unwrap());
        for packet in [at_rest.clone(), Information { x: 500, ..at_rest }] {
            readings.follow(at(2.0), &packet);
        }
        let odometry = readings.odometry().unwrap();
        let off = odometry.pose.distance(&Pose::new(1.0, 0.5, 0.0));
        assert!(off < 1e-9 && (odometry.pose.heading - FRAC_PI_2).abs() < 1e-9, "{:?}", odometry.pose);
        assert!((odometry.travelled - 1.5).abs() < 1e-9 && (odometry.turned - FRAC_PI_2).abs() < 1e-9);
    }

    #[test]
    fn motors_that_are_off_are_an_emergency_stop() {
        let mut readings = readings("p3dx-sh");
        let mut flags_of = |flags, right| {
            readings.follow(at(1.0), &Information { flags, right, battery: 125, ..Information::default() });
            readings.odometry().unwrap().flags
        };
        assert_eq!(flags_of(flags::MOTORS, 0), state::ENABLED);
        assert_eq!(flags_of(0, 0), state::EMERGENCY_STOP);
        assert_eq!(flags_of(flags::MOTORS | flags::STOP_BUTTON, 0), state::ENABLED | state::EMERGENCY_STOP);
        assert_eq!(flags_of(flags::MOTORS, 1), state::ENABLED | state::STALLED);
        assert_eq!(flags_of(flags::MOTORS, 2), state::ENABLED | state::CONTACT | state::CONTACT_AHEAD);
        assert_eq!(readings.odometry().unwrap().battery, 12.5);
        let more = Some(More { battery: Some(480), turn_rate: Some(-900), ..More::default() });
        readings.follow(at(2.0), &Information { more, ..Information::default() });
        let odometry = readings.odometry().unwrap();
        assert!(odometry.battery == 48.0 && (odometry.twist.angular + FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn each_packet_with_readings_is_a_scan_in_which_the_others_grow_older() {
        let mut readings = readings("p3dx-sh");
        let packet = |sonars: &[(u8, u16)]| Information {
            sonars: sonars.iter().map(|(transducer, range)| SonarReading { transducer: *transducer, range: *range }).collect(),
            ..Information::default()
        };
        readings.follow(at(1.0), &packet(&[(0, 1500), (9, 5000), (3, 0), (200, 77)]));
        readings.follow(at(1.1), &packet(&[]));
        readings.follow(at(1.25), &packet(&[(1, 300)]));
        let mut scans = Vec::new();
        readings.fetch(&mut scans);
        let [first, second] = &scans[..] else { panic!("{scans:?}") };
        assert_eq!((first.seq, first.fired, second.seq, second.fired), (1, 1 | 1 << 3 | 1 << 9, 2, 1 << 1));
        assert_eq!([0, 9, 3, 1].map(|i| first.echo(i)), [Echo::Range(1.5), Echo::Nothing, Echo::TooNear, Echo::NotFired]);
        assert_eq!((second.echo(0), second.echo(1)), (Echo::Range(1.5), Echo::Range(0.3)));
        // Half a cycle before its packet, and 0.25 s since.
        assert!((second.age(0) - 0.30).abs() < 1e-6 && (second.age(1) - 0.05).abs() < 1e-6);
        readings.fetch(&mut scans);
        assert_eq!(scans.len(), 2, "a scan is fetched once");
    }
}
