#![allow(clippy::unwrap_used)]

use std::f64::consts::FRAC_PI_2;

use orienteer_runtime::geometry::Pose;

use super::*;
use crate::wire::oi::sensors::{Mode, bumps, overcurrents};

/// Readings whose frames come each 15 ms.
struct Base {
    readings: Readings,
    now: Time,
    sensors: Sensors,
}

impl Base {
    fn new(model: &str) -> Self {
        let sensors = Sensors { mode: Mode::Safe, ..Sensors::default() };
        let mut base = Self { readings: Readings::new(Model::of(model).unwrap()), now: Time::START, sensors };
        base.frame(Twist::STOP);
        base
    }

    fn frame(&mut self, told: Twist) -> Odometry {
        self.now = self.now + PERIOD;
        self.readings.follow(self.now, &self.sensors, told);
        self.readings.odometry().unwrap()
    }

    /// So many counts more on each wheel.
    fn counts(&mut self, left: i16, right: i16) -> Odometry {
        self.sensors.left_encoder = self.sensors.left_encoder.wrapping_add_signed(left);
        self.sensors.right_encoder = self.sensors.right_encoder.wrapping_add_signed(right);
        self.frame(Twist::STOP)
    }
}

#[test]
fn counts_become_metres_however_they_wrap() {
    let mut base = Base::new("create2");
    // Backward first, so that both counters wrap at once.
    let mut odometry = Odometry::default();
    for _ in 0..100 {
        odometry = base.counts(-10, -10);
    }
    assert!((odometry.pose.x + 0.44457).abs() < 1e-4, "{:?}", odometry.pose);
    assert!((odometry.twist.linear + 10.0 * 0.000_444_57 / 0.015).abs() < 1e-4, "{:?}", odometry.twist);
    for _ in 0..20_000 {
        odometry = base.counts(10, 10);
    }
    assert!((odometry.pose.x - 19_900.0 * 0.004_445_65).abs() < 1e-2 && odometry.pose.y == 0.0, "{:?}", odometry.pose);
    assert!((odometry.travelled - 20_100.0 * 0.004_445_65).abs() < 1e-2, "{}", odometry.travelled);
    // A quarter turn to the left on the spot: π/4 · 0.235 m back on the left, and ahead on the right.
    for _ in 0..415 {
        odometry = base.counts(-1, 1);
    }
    assert!((odometry.turned - FRAC_PI_2).abs() < 0.004, "{}", odometry.turned);
    for _ in 0..10 {
        odometry = base.counts(0, 0);
    }
    assert!(odometry.twist.is_stop());
}

#[test]
fn create_1_says_its_way_itself() {
    let mut base = Base::new("create1");
    (base.sensors.distance, base.sensors.angle) = (5, 1);
    let odometry = (0..90).map(|_| base.frame(Twist::STOP)).last().unwrap();
    // A quarter of a circle with a radius of 0.45 m · 2/π.
    let radius = 0.45 / FRAC_PI_2;
    assert!(odometry.pose.distance(&Pose::new(radius, radius, 0.0)) < 1e-9, "{:?}", odometry.pose);
    assert!((odometry.travelled - 0.45).abs() < 1e-9 && (odometry.turned - FRAC_PI_2).abs() < 1e-9);
    assert!((odometry.twist.linear - 1.0 / 3.0).abs() < 1e-9, "{:?}", odometry.twist);
}

#[test]
fn a_base_that_was_away_goes_on_where_it_was() {
    let mut base = Base::new("create2");
    let before = base.counts(1000, 1000);
    base.readings.begin_anew();
    (base.sensors.left_encoder, base.sensors.right_encoder) = (40_000, 7);
    let after = base.frame(Twist::STOP);
    assert_eq!((after.pose, after.travelled, after.twist), (before.pose, before.travelled, Twist::STOP));
    assert!(base.counts(1000, 1000).pose.x > 1.9 * before.pose.x);
}

#[test]
fn after_a_pause_velocity_is_measured_anew() {
    let mut base = Base::new("create2");
    (0..6).for_each(|_| _ = base.counts(10, 10));
    base.now = base.now + 2 * PAUSE;
    // What was gone in the pause is way, but the speed is only of the last frame, which is better than a sixth of it.
    assert!((base.counts(10, 10).twist.linear - 0.2964).abs() < 1e-3);
}

#[test]
fn what_is_felt_is_told() {
    let mut base = Base::new("create2");
    let mut told = |change: fn(&mut Sensors)| {
        base.sensors = Sensors { mode: Mode::Safe, voltage: 14_400, ..Sensors::default() };
        change(&mut base.sensors);
        base.frame(Twist::STOP).flags
    };
    let enabled = flags::ENABLED;
    assert_eq!(told(|_| {}), enabled);
    assert_eq!(told(|sensors| sensors.mode = Mode::Full), enabled);
    assert_eq!(told(|sensors| sensors.mode = Mode::Passive), flags::EMERGENCY_STOP);
    assert_eq!(told(|sensors| sensors.bumps_and_drops = bumps::LEFT), enabled | flags::CONTACT | flags::CONTACT_AHEAD);
    assert_eq!(told(|sensors| sensors.cliffs[2] = true), enabled | flags::CONTACT | flags::CONTACT_AHEAD);
    assert_eq!(told(|sensors| sensors.bumps_and_drops = bumps::RIGHT_DROP), enabled | flags::EMERGENCY_STOP);
    assert_eq!(told(|sensors| sensors.overcurrents = overcurrents::RIGHT), enabled | flags::STALLED);
    assert_eq!(told(|sensors| sensors.overcurrents = 1), enabled, "a brush is no wheel");
    assert_eq!(base.readings.odometry().unwrap().battery, 14.4);
}

#[test]
fn a_caster_that_ceases_to_turn_is_a_stall_if_it_ever_turned() {
    let stalls = |base: &mut Base, told: Twist| (0..100).any(|_| base.frame(told).flags & flags::STALLED != 0);
    let ahead = Twist::new(0.2, 0.0);
    let mut base = Base::new("create2");
    assert!(!stalls(&mut base, ahead), "it was never seen to turn");
    base.sensors.stasis = stasis::GOES_AHEAD;
    assert!(!stalls(&mut base, ahead));
    base.sensors.stasis = 0;
    for told in [Twist::STOP, Twist::new(-0.2, 0.0), Twist::new(0.2, 1.0)] {
        assert!(!stalls(&mut base, told), "{told:?}");
    }
    assert!(stalls(&mut base, ahead));
    base.sensors.stasis = stasis::DIRTY;
    assert!(!stalls(&mut base, ahead));
}
