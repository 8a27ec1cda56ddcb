#![allow(clippy::unwrap_used)]
use std::{f64::consts::PI, time::Duration};

use nalgebra::Point2;
use orienteer_runtime::{
    geometry::Pose,
    topics::{Echo, SonarScan},
};
use proptest::prelude::*;

use super::{
    scene::{Scene, circular_ring, pioneer_ring},
    *,
};
use crate::base::{
    kinematics::{BaseConfig, Kinematics},
    odometry::{Odometer, OdometryConfig},
    presets,
};

/// A base that drives in a scene under protection.
struct Drive {
    base: Kinematics,
    odometer: Odometer,
    protection: Protection,
    ring: Ring,
    scene: Scene,
    pose: Pose,
    now: Time,
    scan: Option<SonarScan>,
    step: u64,
    /// Control periods per scan.
    every: u64,
    period: f64,
    least: f64,
    permitted: Permitted,
}

impl Drive {
    fn new(config: BaseConfig, ring: Ring, scene: Scene, pose: Pose) -> Self {
        let period = 0.05;
        Self {
            protection: Protection::new(config.platform(), &ring, ProtectionConfig { period, ..ProtectionConfig::default() }),
            base: Kinematics::new(config),
            odometer: Odometer::new(OdometryConfig::exact()),
            ring,
            scene,
            pose,
            now: Time::START,
            scan: None,
            step: 0,
            every: 4,
            period,
            least: f64::INFINITY,
            permitted: Permitted { twist: Twist::STOP, reason: None },
        }
    }

    /// Scans as the ring would: half of the transducers are 50 ms older than the other half.
    fn scan(&mut self) -> SonarScan {
        let mut scan = self.scan.unwrap_or_else(|| SonarScan::unfired(self.ring.transducers.len()));
        for (i, transducer) in self.ring.transducers.iter().enumerate() {
            if (i as u64 + self.step).is_multiple_of(2) {
                let echo = self.scene.echo(self.pose.then(transducer.mount), transducer.half_beam, self.ring.max_range);
                scan.set(i, echo, 0.0);
            }
        }
        scan.stamp = self.now;
        scan.seq = self.step + 1;
        scan
    }

    fn step(&mut self, twist: Twist) {
        if self.step % self.every < 2 {
            if let Some(scan) = &mut self.scan {
                scan.grow_older(self.now.secs_since(scan.stamp) as f32);
            }
            self.scan = Some(self.scan());
        }
        let demand = Demand { twist, valid_until: self.now + Duration::from_millis(100), limits: Limits::NONE };
        self.permitted = self.protection.filter(self.now, &demand, self.odometer.state(), self.scan.as_ref(), LinkState::Up);
        // Walk the period in small steps, so that no touch goes unnoticed.
        let (mut distance, mut turn) = (0.0, 0.0);
        for _ in 0..10 {
            let travel = self.base.step(self.pose, self.permitted.twist, self.period / 10.0);
            self.pose = travel.pose;
            distance += travel.distance;
            turn += travel.turn;
            self.least = self.least.min(self.scene.clearance(self.pose.point()) - self.base.config().radius);
        }
        self.now = self.now + Duration::from_secs_f64(self.period);
        let mut rng = orienteer_runtime::random::Streams::new(0).stream("ann", "odometry");
        self.odometer.measure(self.now, distance, turn, self.period, &mut rng);
        self.step += 1;
    }
}

fn huey() -> (BaseConfig, Ring) {
    (presets::b12_huey(), circular_ring(16, 0.08, 12.0))
}

fn one_look(config: BaseConfig, ring: Ring, scene: Scene, pose: Pose, twist: Twist) -> Permitted {
    let mut drive = Drive::new(config, ring, scene, pose);
    // two scans while standing, then at full speed
    drive.step(Twist::STOP);
    drive.step(Twist::STOP);
    let odometry = Odometry { twist, ..*drive.odometer.state() };
    drive.protection.last = twist;
    let demand = Demand { twist, valid_until: Time::FAR, limits: Limits::NONE };
    drive.protection.filter(drive.now, &demand, &odometry, drive.scan.as_ref(), LinkState::Up)
}

/// The highest speed up to `top` that may be kept on: what protection leaves of it is all of it.
fn kept_speed(config: &BaseConfig, ring: &Ring, scene: &Scene, pose: Pose, top: f64) -> f64 {
    let mut speed = top;
    while speed > 0.0 {
        let twist = Twist::new(speed, 0.0);
        if one_look(config.clone(), ring.clone(), scene.clone(), pose, twist).twist.linear >= speed - 1e-9 {
            return speed;
        }
        speed -= 0.01;
    }
    0.0
}

#[test]
fn a_narrow_corridor_costs_huey_no_speed() {
    let (config, ring) = huey();
    for specular in [15.0f64, 25.0, 40.0, 90.0] {
        let scene = Scene::corridor(1.12, specular.to_radians());
        let mut worst = (1.0, 0, 0);
        for offset in (-20..=20).step_by(2) {
            for heading in -10..=10 {
                let pose = Pose::new(0.0, 0.01 * f64::from(offset), f64::from(heading).to_radians());
                let kept = kept_speed(&config, &ring, &scene, pose, 0.5);
                if kept < worst.0 {
                    worst = (kept, offset, heading);
                }
            }
        }
        assert!(worst.0 >= 0.45, "{worst:?}, walls answering up to {specular}°");
    }
}

/// A Pioneer brakes at 0.3 m/s² only: 40 cm from 0.5 m/s. The corridors that it can keep half a metre per second in are wider.
#[test]
fn a_pioneer_keeps_its_speed_in_the_middle_of_a_corridor() {
    let config = presets::p3dx();
    for (width, heading, least) in [(1.12, 0, 0.45), (1.5, 5, 0.45), (2.46, 10, 0.45)] {
        let scene = Scene::corridor(width, 0.6);
        let pose = Pose::new(0.0, 0.0, f64::from(heading).to_radians());
        let kept = kept_speed(&config, &pioneer_ring(), &scene, pose, 0.5);
        assert!(kept >= least, "{width} m, {heading}°: {kept}");
    }
}

/// The robots of the drives below. The rings look all around without a gap, as rule 9 can only speak of what is seen.
fn robots() -> impl Strategy<Value = (BaseConfig, Ring)> {
    prop::sample::select(vec!["b12-huey", "p3dx", "yamabico", "wheelchair"]).prop_map(|name| {
        let config = presets::by_name(name).unwrap();
        (config, circular_ring(16, 0.08, 12.0))
    })
}

fn demands() -> impl Strategy<Value = Twist> {
    let speeds = prop_oneof![0.05..1.5f64, -1.0..-0.05f64];
    (speeds, prop_oneof![Just(0.0), -1.5..1.5f64]).prop_map(|(v, w)| Twist::new(v, w))
}

fn assert_untouched(mut drive: Drive, demands: &[Twist]) -> Result<(), TestCaseError> {
    // the first scans come while it stands
    for _ in 0..4 {
        drive.step(Twist::STOP);
    }
    for demand in demands {
        for _ in 0..80 {
            drive.step(*demand);
            prop_assert!(drive.least >= -1e-6, "touches by {} at {:?}, {:?}", -drive.least, drive.pose, drive.permitted);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn a_wall_is_never_touched(
        (config, ring) in robots(), bearing in -PI..PI, room in 0.05..2.5f64,
        demand in prop::collection::vec(demands(), 1..4), specular in prop::sample::select(vec![12.5f64, 25.0, 60.0])
    ) {
        let normal = nalgebra::Vector2::new(bearing.cos(), bearing.sin());
        let foot = Point2::from(normal * (config.radius + room));
        let along = nalgebra::Vector2::new(-normal.y, normal.x) * 30.0;
        let scene = Scene { walls: vec![(foot - along, foot + along)], people: vec![], specular: specular.to_radians() };
        assert_untouched(Drive::new(config, ring, scene, Pose::default()), &demand)?;
    }

    #[test]
    fn a_person_is_never_touched(
        (config, ring) in robots(), bearing in -PI..PI, room in 0.05..2.5f64, demand in prop::collection::vec(demands(), 1..4)
    ) {
        let centre = Point2::from(nalgebra::Vector2::new(bearing.cos(), bearing.sin()) * (config.radius + room + 0.25));
        let scene = Scene { walls: vec![], people: vec![(centre, 0.25)], specular: 0.4 };
        assert_untouched(Drive::new(config, ring, scene, Pose::default()), &demand)?;
    }

    #[test]
    fn a_crowded_corridor_is_never_touched(
        (config, ring) in robots(), heading in -PI..PI, offset in -0.2..0.2f64, width in 1.6..2.5f64,
        people in prop::collection::vec((0.9..4.0f64, -0.8..0.8f64, prop::bool::ANY), 0..4), demand in prop::collection::vec(demands(), 1..4)
    ) {
        let mut scene = Scene::corridor(width, 0.44);
        scene.people = people.iter().map(|(x, y, ahead)| (Point2::new(if *ahead { *x } else { -x }, *y), 0.25)).collect();
        let pose = Pose::new(0.0, offset, heading);
        assert_untouched(Drive::new(config, ring, scene, pose), &demand)?;
    }
}

/// Drives until it stands or `seconds` have passed; where it is then.
fn drive_on(drive: &mut Drive, demand: Twist, seconds: f64) -> Pose {
    for _ in 0..4 {
        drive.step(Twist::STOP);
    }
    for _ in 0..(seconds / drive.period) as u64 {
        drive.step(demand);
    }
    drive.pose
}

/// Randazza's detectors come down to 40 cm from a wall ahead (sonar face; 48 cm from the centre) and to 31 cm from a doorjamb, at 8 cm/s.
#[test]
fn detectors_come_as_near_as_they_need() {
    let (config, ring) = huey();
    let wall = Scene { walls: vec![(Point2::new(1.0, -5.0), Point2::new(1.0, 5.0))], people: vec![], specular: 0.4 };
    let mut drive = Drive::new(config, ring, wall, Pose::default());
    for _ in 0..4 {
        drive.step(Twist::STOP);
    }
    while drive.pose.x < 1.0 - 0.39 {
        let before = drive.pose.x;
        drive.step(Twist::new(0.08, 0.0));
        assert_eq!(drive.permitted, Permitted { twist: Twist::new(0.08, 0.0), reason: None }, "{:?}", drive.pose);
        assert!(drive.pose.x > before);
    }
    let end = drive_on(&mut drive, Twist::new(0.08, 0.0), 10.0);
    assert!((0.64..0.67).contains(&end.x), "comes to rest at the margin, {end:?}");
    assert_eq!(drive.permitted.reason, Some(Reason::FreeDistance));
}

#[test]
fn a_doorway_lets_huey_through() {
    let (config, ring) = huey();
    for (width, offset, speed) in [(0.88, 0.0, 0.2), (0.88, 0.05, 0.08), (0.78, 0.0, 0.08), (0.78, 0.03, 0.08)] {
        let half = 0.5 * width;
        let jamb = |side: f64| {
            let corner = |x: f64| Point2::new(x, side * half);
            let far = |x: f64| Point2::new(x, side * 4.0);
            [(corner(1.0), corner(1.14)), (corner(1.0), far(1.0)), (corner(1.14), far(1.14))]
        };
        let scene = Scene { walls: [jamb(1.0), jamb(-1.0)].concat(), people: vec![], specular: 0.6 };
        let mut drive = Drive::new(config.clone(), ring.clone(), scene, Pose::new(0.0, offset, 0.0));
        let end = drive_on(&mut drive, Twist::new(speed, 0.0), 2.2 / speed);
        assert!(end.x > 2.1 && drive.least > 0.0, "width {width}, offset {offset}: {end:?}");
    }
}

#[test]
fn it_drives_on_as_near_as_it_may_and_away_from_anything() {
    let (config, ring) = huey();
    // a person stands 2 cm behind: forward is free, backward is not
    let scene = Scene { walls: vec![], people: vec![(Point2::new(-0.57, 0.0), 0.25)], specular: 0.4 };
    let mut drive = Drive::new(config, ring, scene, Pose::default());
    let end = drive_on(&mut drive, Twist::new(-0.3, 0.0), 1.0);
    assert!(end.x.abs() < 1e-9);
    let end = drive_on(&mut drive, Twist::new(0.5, 0.0), 2.0);
    assert!(end.x > 0.8, "{end:?}");
}

/// The stop that free distance commands can be braked: the base is where protection thought it would be.
#[test]
fn the_braking_that_it_commands_is_within_the_platform() {
    for name in ["b12-huey", "p3dx", "yamabico"] {
        let config = presets::by_name(name).unwrap();
        let ring = circular_ring(16, 0.08, 12.0);
        let wall = Scene { walls: vec![(Point2::new(4.0, -5.0), Point2::new(4.0, 5.0))], people: vec![], specular: 0.4 };
        let mut drive = Drive::new(config.clone(), ring, wall, Pose::default());
        drive_on(&mut drive, Twist::STOP, 0.0);
        for _ in 0..400 {
            let before = drive.base.twist().linear;
            drive.step(Twist::new(1.0, 0.0));
            let drop = before - drive.permitted.twist.linear;
            assert!(drop <= config.acceleration * drive.period + 1e-9, "{name}: from {before} by {drop}");
        }
        let gap = 4.0 - config.radius - drive.pose.x;
        assert!((0.025..0.06).contains(&gap), "{name}: {gap}");
    }
}

mod rules {
    use super::*;

    fn setup() -> (Protection, Odometry, SonarScan, Demand) {
        let (config, ring) = huey();
        let scan = SonarScan::from_echoes(Time::START, 1, &[Echo::Range(3.0); 16]);
        let odometry = Odometry { flags: flags::ENABLED, ..Odometry::default() };
        let demand = Demand { twist: Twist::new(0.3, 0.1), valid_until: Time::from_secs_f64(0.1), limits: Limits::NONE };
        (Protection::new(config.platform(), &ring, ProtectionConfig::default()), odometry, scan, demand)
    }

    fn reason(
        change: impl FnOnce(&mut Odometry, &mut SonarScan, &mut Demand, &mut LinkState, &mut Time),
    ) -> (Twist, Option<Reason>) {
        let (mut protection, mut odometry, mut scan, mut demand) = setup();
        let (mut link, mut now) = (LinkState::Up, Time::START);
        change(&mut odometry, &mut scan, &mut demand, &mut link, &mut now);
        let permitted = protection.filter(now, &demand, &odometry, Some(&scan), link);
        (permitted.twist, permitted.reason)
    }

    #[test]
    fn nothing_wrong_means_nothing_changed() {
        assert_eq!(reason(|_, _, _, _, _| ()), (Twist::new(0.3, 0.1), None));
    }

    #[test]
    fn each_fault_stops_and_says_why() {
        let stop = |why| (Twist::STOP, Some(why));
        assert_eq!(reason(|_, _, demand, _, _| demand.twist.angular = f64::NAN), stop(Reason::BadDemand));
        assert_eq!(reason(|_, _, demand, _, _| demand.twist.linear = f64::INFINITY), stop(Reason::BadDemand));
        assert_eq!(reason(|_, _, _, link, _| *link = LinkState::Lost), stop(Reason::LinkLost));
        assert_eq!(reason(|odometry, _, _, _, _| odometry.pose.x = f64::NAN), stop(Reason::BadOdometry));
        assert_eq!(reason(|odometry, _, _, _, _| odometry.twist.linear = f64::NAN), stop(Reason::BadOdometry));
        let late = |odometry: &mut Odometry, _: &mut SonarScan, demand: &mut Demand, _: &mut LinkState, now: &mut Time| {
            *now = Time::from_secs_f64(1.0);
            demand.valid_until = Time::FAR;
            odometry.stamp = Time::START;
        };
        assert_eq!(reason(late), stop(Reason::BadOdometry));
        assert_eq!(reason(|odometry, _, _, _, _| odometry.flags = flags::EMERGENCY_STOP), stop(Reason::EmergencyStop));
        assert_eq!(reason(|_, _, _, _, now| *now = Time::from_secs_f64(0.11)), stop(Reason::StaleCommand));
        assert_eq!(reason(|_, scan, _, _, _| *scan = SonarScan::unfired(16)).1, Some(Reason::StaleSonar));
        assert_eq!(reason(|_, scan, _, _, _| *scan = SonarScan::default()).0.linear, 0.0);
    }

    #[test]
    fn the_first_rule_gives_the_reason() {
        let all = |odometry: &mut Odometry, _: &mut SonarScan, demand: &mut Demand, link: &mut LinkState, now: &mut Time| {
            demand.twist.linear = f64::NAN;
            *link = LinkState::Lost;
            odometry.flags = flags::EMERGENCY_STOP | flags::CONTACT;
            *now = Time::from_secs_f64(9.0);
        };
        assert_eq!(reason(all).1, Some(Reason::BadDemand));
    }

    #[test]
    fn limits_keep_the_curve() {
        let (twist, why) = reason(|_, _, demand, _, _| demand.twist = Twist::new(2.0, 0.4));
        assert_eq!((twist, why), (Twist::new(1.0, 0.2), Some(Reason::Platform)));
        assert!(!Reason::Platform.is_protective());
        let (twist, why) = reason(|_, _, demand, _, _| demand.limits = Limits { linear: 0.15, angular: 1.0 });
        assert_eq!((twist, why), (Twist::new(0.15, 0.05), None));
        assert_eq!(reason(|_, _, demand, _, _| demand.limits.linear = f64::NAN).0.linear, 0.0);
    }

    #[test]
    fn a_silent_sonar_stops_translation_but_not_a_turn_on_the_spot() {
        let (mut protection, mut odometry, scan, mut demand) = setup();
        demand.valid_until = Time::FAR;
        let mut stopped_at = None;
        for i in 0..40 {
            let now = Time::from_secs_f64(0.05 * f64::from(i));
            odometry.stamp = now;
            let permitted = protection.filter(now, &demand, &odometry, Some(&scan), LinkState::Up);
            if permitted.reason == Some(Reason::StaleSonar) {
                assert_eq!(permitted.twist, Twist::new(0.0, 0.1));
                stopped_at = stopped_at.or(Some(now));
            }
        }
        // half a second and two passes of 0.1 s
        assert_eq!(stopped_at, Some(Time::from_secs_f64(0.75)));
    }

    #[test]
    fn where_no_transducer_looks_it_creeps() {
        let (config, mut ring) = huey();
        ring.transducers.truncate(5);
        let mut protection = Protection::new(config.platform(), &ring, ProtectionConfig::default());
        let (_, odometry, scan, mut demand) = setup();
        demand.twist = Twist::new(-0.5, 0.0);
        let permitted = protection.filter(Time::START, &demand, &odometry, Some(&scan), LinkState::Up);
        assert_eq!(permitted, Permitted { twist: Twist::new(-0.1, 0.0), reason: Some(Reason::Blind) });
    }

    #[test]
    fn after_a_contact_it_may_only_back_off() {
        let (mut protection, mut odometry, scan, mut demand) = setup();
        let mut filter = |odometry: &Odometry, demand: &Demand| {
            let permitted = protection.filter(Time::START, demand, odometry, Some(&scan), LinkState::Up);
            (permitted.twist, permitted.reason)
        };
        assert_eq!(filter(&odometry, &demand).1, None);
        odometry.flags |= flags::CONTACT;
        assert_eq!(filter(&odometry, &demand), (Twist::STOP, Some(Reason::Contact)));
        demand.twist = Twist::new(0.0, 0.5);
        assert_eq!(filter(&odometry, &demand), (Twist::STOP, Some(Reason::Contact)));
        demand.twist = Twist::new(-0.5, 0.3);
        assert_eq!(filter(&odometry, &demand), (Twist::new(-0.1, 0.0), Some(Reason::Contact)));
        demand.twist = Twist::new(0.3, 0.0);
        assert_eq!(filter(&odometry, &demand).0, Twist::STOP);
        odometry.flags = flags::ENABLED;
        assert_eq!(filter(&odometry, &demand), (Twist::new(0.3, 0.0), None));
    }

    #[test]
    fn pushed_while_standing_it_moves_only_away_from_what_it_sees() {
        for (echoes_behind, forward_allowed) in [(0.25, true), (3.0, false)] {
            let (mut protection, mut odometry, _, mut demand) = setup();
            let mut echoes = [Echo::Range(3.0); 16];
            echoes[8] = Echo::Range(echoes_behind);
            let scan = SonarScan::from_echoes(Time::START, 1, &echoes);
            odometry.flags |= flags::CONTACT;
            demand.twist = Twist::new(0.3, 0.0);
            let permitted = protection.filter(Time::START, &demand, &odometry, Some(&scan), LinkState::Up);
            assert_eq!(permitted.twist.linear > 0.0, forward_allowed);
            demand.twist = Twist::new(-0.3, 0.0);
            let permitted = protection.filter(Time::START, &demand, &odometry, Some(&scan), LinkState::Up);
            assert!(permitted.twist.is_stop());
        }
    }

    #[test]
    fn too_near_ahead_stops_and_behind_does_not() {
        for (index, stops) in [(0, true), (1, true), (8, false)] {
            let (mut protection, odometry, _, demand) = setup();
            let mut echoes = [Echo::Nothing; 16];
            echoes[index] = Echo::TooNear;
            let scan = SonarScan::from_echoes(Time::START, 1, &echoes);
            let permitted = protection.filter(Time::START, &demand, &odometry, Some(&scan), LinkState::Up);
            assert_eq!(permitted.twist.linear == 0.0, stops, "{index}");
        }
    }
}

#[test]
fn zz_time() {
    let (config, ring) = huey();
    for (label, scene, pose) in [
        ("open", Scene::corridor(6.0, 0.5), Pose::default()),
        ("corridor", Scene::corridor(1.12, 0.5), Pose::default()),
        ("near", Scene::corridor(1.12, 0.5), Pose::new(0.0, 0.2, 0.17)),
        ("blocked", Scene::corridor(1.12, 0.5), Pose::new(0.0, 0.2, 0.9)),
    ] {
        let mut drive = Drive::new(config.clone(), ring.clone(), scene, pose);
        for _ in 0..4 { drive.step(Twist::STOP); }
        let odometry = Odometry { twist: Twist::new(0.5, 0.0), ..*drive.odometer.state() };
        let demand = Demand { twist: Twist::new(0.5, 0.1), valid_until: Time::FAR, limits: Limits::NONE };
        let start = std::time::Instant::now();
        for _ in 0..20000 { std::hint::black_box(drive.protection.filter(drive.now, &demand, &odometry, drive.scan.as_ref(), LinkState::Up)); }
        println!("TIME {label} {:?}", start.elapsed() / 20000);
    }
}
