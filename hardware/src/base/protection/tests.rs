#![allow(clippy::unwrap_used)]
use std::{collections::VecDeque, f64::consts::PI, time::Duration};

use nalgebra::Point2;
use orienteer_runtime::{
    geometry::Pose,
    random::Streams,
    topics::{Echo, SonarScan},
};
use proptest::prelude::*;
use rand::RngExt;

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
    /// Readings are wrong by up to this much, m.
    noise: f32,
    /// Commands that the base has not heeded yet, oldest first.
    underway: VecDeque<Twist>,
    /// Control periods from one word of the base about where it is to the next.
    tells: u64,
    /// What it has driven and turned since the last one, m and rad.
    untold: (f64, f64),
    rng: rand_pcg::Pcg64,
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
            noise: 0.0,
            underway: VecDeque::new(),
            tells: 1,
            untold: (0.0, 0.0),
            rng: Streams::new(5).stream("ann", "sonar"),
        }
    }

    /// Scans as the ring would: half of the transducers are 50 ms older than the other half.
    fn scan(&mut self) -> SonarScan {
        let mut scan = self.scan.unwrap_or_else(|| SonarScan::unfired(self.ring.transducers.len()));
        for (i, transducer) in self.ring.transducers.iter().enumerate() {
            if (i as u64 + self.step).is_multiple_of(2) {
                let echo = self.scene.echo(self.pose.then(transducer.mount), transducer.half_beam, self.ring.max_range);
                let noise = self.noise * self.rng.random_range(-1.0..1.0);
                let echo = match echo {
                    Echo::Range(range) if f64::from(range) < self.ring.min_range => Echo::TooNear,
                    Echo::Range(range) => Echo::Range(range + noise),
                    echo => echo,
                };
                scan.set(i, echo, 0.0);
            }
        }
        scan.stamp = self.now;
        scan.seq = self.step + 1;
        scan
    }

    /// The same base, if it heeds a command only so many periods later, and says only every so many periods where it is.
    fn slow_of_hearing(mut self, heeds: usize, tells: u64) -> Self {
        self.underway = vec![Twist::STOP; heeds].into();
        self.tells = tells;
        let config = ProtectionConfig { period: self.period, ..ProtectionConfig::default() };
        let config = config.for_a_base(heeds as f64 * self.period);
        self.protection = Protection::new(self.base.config().platform(), &self.ring, config);
        self
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
        self.underway.push_back(self.permitted.twist);
        let heeded = self.underway.pop_front().unwrap_or(Twist::STOP);
        // Walk the period in small steps, so that no touch goes unnoticed.
        for _ in 0..10 {
            let travel = self.base.step(self.pose, heeded, self.period / 10.0);
            self.pose = travel.pose;
            self.untold = (self.untold.0 + travel.distance, self.untold.1 + travel.turn);
            self.least = self.least.min(self.scene.clearance(self.pose.point()) - self.base.config().radius);
        }
        self.now = self.now + Duration::from_secs_f64(self.period);
        self.step += 1;
        if self.step.is_multiple_of(self.tells) {
            let (distance, turn) = std::mem::take(&mut self.untold);
            self.odometer.measure(self.now, distance, turn, self.period * self.tells as f64, &mut self.rng);
        }
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
    drive.protection.told.tell(drive.now, twist);
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
        assert!(worst.0 >= 0.4, "{worst:?}, walls answering up to {specular}°");
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

/// A body was left a millimetre from a wall, and some of its transducers are too near to tell how near. The wall's side bars
/// the way; whichever of ahead and back leads off by a fair angle does not.
#[test]
fn a_pioneer_left_at_a_wall_drives_off() {
    let ring = Ring { min_range: 0.1, ..pioneer_ring() };
    let config = presets::p3dx();
    let wall = config.radius + 0.001;
    for off in (25..=90).step_by(5) {
        for (side, speed) in [(1.0, 0.3), (-1.0, 0.3), (1.0, -0.3), (-1.0, -0.3)] {
            let heading = side * (f64::from(off) + if speed > 0.0 { 0.0 } else { 180.0 });
            let scene =
                Scene { walls: vec![(Point2::new(-20.0, -wall), Point2::new(20.0, -wall))], people: vec![], specular: 0.6 };
            let heading = if side > 0.0 { heading } else { 180.0 + heading };
            let mut drive = Drive::new(config.clone(), ring.clone(), scene, Pose::new(0.0, 0.0, heading.to_radians()));
            for _ in 0..8 {
                drive.step(Twist::STOP);
            }
            for _ in 0..100 {
                drive.step(Twist::new(speed, 0.0));
            }
            let off_by = drive.pose.y;
            assert!(off_by > 0.1, "{off}°, side {side}, {speed} m/s: {off_by} m in 5 s, {:?}", drive.permitted);
            assert!(drive.least >= -1e-6, "{off}°, side {side}, {speed} m/s: touches by {}", -drive.least);
        }
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
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn a_wall_is_never_touched(
        (config, ring) in robots(), bearing in -PI..PI, room in 0.05..2.5f64,
        demand in prop::collection::vec(demands(), 1..4), specular in prop::sample::select(vec![12.5f64, 25.0, 60.0]),
        noise in prop::sample::select(vec![0.0, 0.01])
    ) {
        let normal = nalgebra::Vector2::new(bearing.cos(), bearing.sin());
        let foot = Point2::from(normal * (config.radius + room));
        let along = nalgebra::Vector2::new(-normal.y, normal.x) * 30.0;
        let scene = Scene { walls: vec![(foot - along, foot + along)], people: vec![], specular: specular.to_radians() };
        assert_untouched(Drive { noise, ..Drive::new(config, ring, scene, Pose::default()) }, &demand)?;
    }

    #[test]
    fn a_base_that_heeds_and_tells_late_never_touches_a_wall(
        (config, ring) in robots(), bearing in -PI..PI, room in 0.05..2.5f64, demand in prop::collection::vec(demands(), 1..4),
        heeds in 0usize..4, tells in 1u64..5
    ) {
        let normal = nalgebra::Vector2::new(bearing.cos(), bearing.sin());
        let foot = Point2::from(normal * (config.radius + room));
        let along = nalgebra::Vector2::new(-normal.y, normal.x) * 30.0;
        let scene = Scene { walls: vec![(foot - along, foot + along)], people: vec![], specular: 0.44 };
        assert_untouched(Drive::new(config, ring, scene, Pose::default()).slow_of_hearing(heeds, tells), &demand)?;
    }

    #[test]
    fn a_person_is_never_touched(
        (config, ring) in robots(), bearing in -PI..PI, room in 0.05..2.5f64, demand in prop::collection::vec(demands(), 1..4)
    ) {
        let centre = Point2::from(nalgebra::Vector2::new(bearing.cos(), bearing.sin()) * (config.radius + room + 0.25));
        let scene = Scene { walls: vec![], people: vec![(centre, 0.25)], specular: 0.4 };
        assert_untouched(Drive::new(config, ring, scene, Pose::default()), &demand)?;
    }

    /// Within a metre there are gaps between the beams of a ring: a door post or a table leg slips into them.
    #[test]
    fn a_thin_post_is_never_touched(
        bearing in -0.5..0.5f64, room in 0.8..2.0f64, radius in 0.005..0.05f64, speed in 0.1..0.8f64, turn in -0.3..0.3f64,
        stands in 0usize..60
    ) {
        let (config, ring) = huey();
        let centre = Point2::from(nalgebra::Vector2::new(bearing.cos(), bearing.sin()) * (config.radius + room + radius));
        let scene = Scene { walls: vec![], people: vec![(centre, radius)], specular: 0.4 };
        // Huey's ring is read in less than a control period.
        let mut drive = Drive { every: 2, ..Drive::new(config, ring, scene, Pose::default()) };
        for _ in 0..12 {
            drive.step(Twist::STOP);
        }
        for step in 0..400 {
            // It stands for a while on the way, and goes on.
            let waits = (60..60 + stands).contains(&step);
            drive.step(if waits { Twist::STOP } else { Twist::new(speed, turn) });
            prop_assert!(drive.least >= -1e-6, "touches by {} at {:?}, {:?}", -drive.least, drive.pose, drive.permitted);
        }
    }

    #[test]
    fn a_crowded_corridor_is_never_touched(
        (config, ring) in robots(), heading in -PI..PI, offset in -0.2..0.2f64, width in 1.6..2.5f64, noise in prop::sample::select(vec![0.0, 0.01]),
        people in prop::collection::vec((0.9..4.0f64, -0.8..0.8f64, prop::bool::ANY), 0..4), demand in prop::collection::vec(demands(), 1..4)
    ) {
        let mut scene = Scene::corridor(width, 0.44);
        scene.people = people.iter().map(|(x, y, ahead)| (Point2::new(if *ahead { *x } else { -x }, *y), 0.25)).collect();
        let pose = Pose::new(0.0, offset, heading);
        assert_untouched(Drive { noise, ..Drive::new(config, ring, scene, pose) }, &demand)?;
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

mod rules;

/// Odometry that no wheel could have measured, near things that call for braking.
fn wild_odometry() -> impl Strategy<Value = Twist> {
    let sane = (-0.6..0.6f64, -1.5..1.5f64);
    let wild = (-1e3..1e3f64, -1e3..1e3f64);
    prop_oneof![sane, wild].prop_map(|(v, w)| Twist::new(v, w))
}

proptest! {
    /// A driver that divided a step of its encoders by a microsecond once measured -4.5 m/s, and was told to brake from there.
    #[test]
    fn whatever_is_measured_the_base_is_only_slowed_down(
        (config, ring) in robots(), backward in any::<bool>(),
        steps in prop::collection::vec((0.0..1.5f64, -1.5..1.5f64, wild_odometry(), 0.05..2.0f32), 1..60)
    ) {
        let platform = config.platform();
        let mut protection = Protection::new(platform.clone(), &ring, ProtectionConfig::default());
        let sense = if backward { -1.0 } else { 1.0 };
        let mut fastest = 0.0f64;
        for (step, (speed, turn, measured, range)) in (1u64..).zip(steps) {
            let now = Time::START + Duration::from_millis(50 * step);
            let mut scan = SonarScan::unfired(ring.transducers.len());
            (0..ring.transducers.len()).for_each(|i| scan.set(i, Echo::Range(range), 0.0));
            (scan.stamp, scan.seq) = (now, step);
            let demand = Demand { twist: Twist::new(sense * speed, turn), valid_until: Time::FAR, limits: Limits::NONE };
            let odometry = Odometry { stamp: now, twist: measured, flags: flags::ENABLED, ..Odometry::default() };
            let permitted = protection.filter(now, &demand, &odometry, Some(&scan), LinkState::Up).twist;
            fastest = fastest.max(speed);
            prop_assert!(sense * permitted.linear >= 0.0, "{permitted:?} is the other way");
            prop_assert!(permitted.linear.abs() <= fastest.min(platform.limits.linear) + 1e-12, "{permitted:?}");
            prop_assert!(permitted.angular.abs() <= platform.limits.angular + 1e-12, "{permitted:?}");
        }
    }
}
