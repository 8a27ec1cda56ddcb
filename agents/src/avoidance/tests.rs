#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::{f64::consts::TAU, sync::Arc, time::Duration};

use nalgebra::{Point2, Vector2};
use orienteer_runtime::{
    geometry::{Pose, Twist, angle},
    robot_model::{Ring, Transducer},
    time::Time,
    topics::{Echo, FiringProgram, FixedVec, MotionKind, Odometry, SonarScan},
};
use proptest::prelude::*;

use super::{AvoidanceConfig, Evasion, Move, Surroundings, Threat, caution, course};

const RADIUS: f64 = 0.3;
const RING: f64 = 0.08;
const STEP: f64 = 0.05;
const HALF_BEAM: f64 = 0.209;

/// How often a fast ring and a slow one have read all their transducers, s: Huey's, and a Pioneer's.
const FAST: f64 = 0.025;
const SLOW: f64 = 0.3;

fn ring(pass: f64) -> Arc<Ring> {
    let transducer = |k: u32| {
        let bearing = angle::wrap(-TAU * f64::from(k) / 16.0);
        Transducer { mount: Pose::new(RING * bearing.cos(), RING * bearing.sin(), bearing), half_beam: HALF_BEAM }
    };
    Arc::new(Ring {
        name: "test".into(),
        transducers: (0..16).map(transducer).collect(),
        min_range: 0.0,
        max_range: 7.77,
        slot_time: pass,
        program: FiringProgram { slots: FixedVec::filled(u32::MAX, 1), ..FiringProgram::default() },
    })
}

/// What a transducer hears of a world.
type World = dyn Fn(f64, Pose) -> Option<f64>;

/// A wall `distance` from the origin with its normal at `bearing`: answers up to 30° of incidence, at the rim of the beam too.
fn wall(distance: f64, bearing: f64) -> impl Fn(f64, Pose) -> Option<f64> {
    move |_, face| {
        let away = distance - face.x * bearing.cos() - face.y * bearing.sin();
        let incidence = (angle::turn(face.heading, bearing).abs() - HALF_BEAM).max(0.0);
        (away > 0.0 && incidence < 0.52).then(|| away / incidence.cos())
    }
}

/// Somebody of radius 0.25 m who starts at a point and walks with a velocity.
fn person(from: Point2<f64>, velocity: Vector2<f64>) -> impl Fn(f64, Pose) -> Option<f64> {
    move |time, face| {
        let to = from + velocity * time - face.point();
        let off = angle::turn(face.heading, to.y.atan2(to.x)).abs();
        (off < HALF_BEAM + (0.25 / to.norm()).asin()).then_some((to.norm() - 0.25).max(0.01))
    }
}

/// Drives for some seconds with a twist through a world, quantised as Huey's sonar is, and looks round after each step.
fn drive(twist: Twist, seconds: f64, world: &World, look: impl FnMut(&Surroundings, &Odometry)) {
    drive_with(FAST, twist, seconds, world, |_| None, look);
}

/// The same with this ring, and with odometry that slips in after the right one of a step.
fn drive_with(
    pass: f64,
    twist: Twist,
    seconds: f64,
    world: &World,
    slip: impl Fn(&Odometry) -> Option<Odometry>,
    mut look: impl FnMut(&Surroundings, &Odometry),
) {
    let ring = ring(pass);
    let mut around = Surroundings::new(ring.clone(), RADIUS);
    let pose_at = |time: f64| Pose::default().along_arc(twist.linear * time, twist.angular * time);
    for step in 1..=(seconds / STEP) as u32 {
        let now = f64::from(step) * STEP;
        let odometry = Odometry { stamp: Time::from_secs_f64(now), pose: pose_at(now), twist, ..Odometry::default() };
        around.moved(&odometry);
        if let Some(slipped) = slip(&odometry) {
            around.moved(&slipped);
        }
        // All passes that end within this step.
        let passes = |time: f64| (time / pass + 1e-9).floor() as u32;
        for time in (passes(now - STEP) + 1..=passes(now)).map(|n| f64::from(n) * pass) {
            let hear = |transducer: &Transducer| match world(time, pose_at(time).then(transducer.mount)) {
                Some(range) if range < ring.max_range => Echo::Range((((range / 0.03048).floor() * 0.03048) as f32).max(0.01)),
                _ => Echo::Nothing,
            };
            let echoes: Vec<Echo> = ring.transducers.iter().map(hear).collect();
            around.heard(&[SonarScan::from_echoes(Time::from_secs_f64(time), u64::from(step), &echoes)]);
        }
        look(&around, &odometry);
    }
}

fn pass() -> impl Strategy<Value = f64> {
    prop_oneof![Just(FAST), Just(SLOW)]
}

proptest! {
    #[test]
    fn a_wall_never_comes(
        pass in pass(), bearing in -3.1..3.1f64, distance in 1.5..3.0f64, speed in 0.0..0.4f64, rate in -0.3..0.3f64
    ) {
        let config = AvoidanceConfig::default();
        drive_with(pass, Twist::new(speed, rate), 2.5, &wall(distance, bearing), |_| None, |around, _| {
            for thing in around.all() {
                let comes = thing.steady && thing.approach > config.approach_speed && thing.came >= config.approach_distance;
                assert!(!comes, "{thing:?}");
            }
        });
    }

    /// Three readings for the first median, two more for a slope, and as many until a beam beside it does not take it for a wall.
    #[test]
    fn somebody_who_walks_up_to_a_standing_robot_is_seen_to(pass in pass(), bearing in -3.1..3.1f64, speed in 0.2..1.2f64) {
        let (sin, cos) = bearing.sin_cos();
        // From 5.5 m away to an arm's length.
        let (from, seconds) = (Point2::new(5.5 * cos, 5.5 * sin), 4.2 / speed);
        let soon = (8.0 * pass * speed + 0.2).max(1.2);
        let (mut first, mut steps, mut seen) = (None, 0, 0);
        let comer = person(from, Vector2::new(-speed * cos, -speed * sin));
        drive_with(pass, Twist::STOP, seconds, &comer, |_| None, |around, odometry| {
            // Whoever stands at the rim of one beam is squarely in the next.
            let sees = around.all().any(|thing: Threat| {
                let off = angle::turn(thing.bearing, bearing).abs();
                thing.steady && off < 0.42 && (thing.approach / speed - 1.0).abs() < 0.2
            });
            let walked = speed * odometry.stamp.as_secs_f64();
            first = first.or(sees.then_some(walked));
            if first.is_some() {
                (steps, seen) = (steps + 1, seen + i32::from(sees));
            }
        });
        prop_assert!(first.is_some_and(|walked| walked < soon), "not seen to come before {first:?}");
        prop_assert!(2 * seen >= steps, "seen in {seen} of {steps} steps only");
    }
}

#[test]
fn somebody_ahead_of_a_driving_robot_is_told_from_its_own_motion() {
    let mut last = None;
    drive(Twist::new(0.3, 0.0), 2.0, &person(Point2::new(3.5, 0.0), Vector2::new(-0.4, 0.0)), |around, _| {
        last = around.all().find(|thing| thing.bearing.abs() < 0.01);
    });
    let ahead = last.unwrap();
    assert!((ahead.approach - 0.4).abs() < 0.08 && (ahead.closing - 0.7).abs() < 0.08, "{ahead:?}");
}

#[test]
fn caution_stops_for_who_comes_and_not_for_who_stands() {
    let config = AvoidanceConfig::default();
    let limit_at_the_end = |velocity: f64| {
        let mut limit = None;
        drive(Twist::new(0.3, 0.0), 1.5, &person(Point2::new(2.6, 0.0), Vector2::new(velocity, 0.0)), |around, odometry| {
            limit = caution(&config, around, course(odometry.twist, MotionKind::Stop));
        });
        limit
    };
    assert_eq!(limit_at_the_end(-0.6), Some(0.0));
    assert_eq!(limit_at_the_end(0.0), None);
}

#[test]
fn who_stands_before_something_may_back_off() {
    let config = AvoidanceConfig::default();
    let (standing, rolling) = (Twist::STOP, Twist::new(0.05, 0.0));
    let backward = MotionKind::Velocity(Twist::new(-0.2, 0.0));
    drive(Twist::STOP, 1.0, &wall(0.32, 0.0), |around, odometry| {
        if odometry.stamp.as_secs_f64() < 0.9 {
            return;
        }
        let on = |twist, told| caution(&config, around, course(twist, told));
        assert_eq!(on(standing, MotionKind::Translate { distance: 0.5, speed: 0.2 }), Some(0.0));
        assert_eq!(on(standing, MotionKind::Translate { distance: -0.5, speed: 0.2 }), None);
        assert_eq!(on(standing, backward), None);
        // As it rolls out it is still going on.
        assert_eq!(on(rolling, backward), Some(0.0));
    });
}

#[test]
fn a_step_aside_leads_across_the_comers_path() {
    let config = AvoidanceConfig::default();
    for bearing in [0.0, 0.7, 1.57, 2.5, -1.2] {
        let (sin, cos) = f64::sin_cos(bearing);
        let mut evasion = Evasion::new(true);
        let mut first = None;
        drive(
            Twist::STOP,
            6.0,
            &person(Point2::new(2.5 * cos, 2.5 * sin), Vector2::new(-0.4 * cos, -0.4 * sin)),
            |around, odometry| {
                let now = odometry.stamp + Duration::ZERO;
                if let (Move::Drive(_), None) = (evasion.step(now, &config, around, odometry), first) {
                    first = evasion.way();
                }
            },
        );
        let way = first.expect("steps aside");
        assert!(angle::turn(bearing, way).cos() < 0.4, "comes from {bearing}, goes to {way}");
        assert_eq!(evasion.count(), 1);
    }
}

#[test]
fn who_shall_not_step_aside_takes_the_base_and_stands() {
    let config = AvoidanceConfig { most_steps: 0, ..AvoidanceConfig::default() };
    let mut evasion = Evasion::new(true);
    let mut stood = 0;
    drive(Twist::STOP, 6.0, &person(Point2::new(2.5, 0.0), Vector2::new(-0.4, 0.0)), |around, odometry| {
        let what = evasion.step(odometry.stamp, &config, around, odometry);
        assert!(matches!(what, Move::Nothing | Move::Drive(Twist::STOP)), "{what:?}");
        stood += u32::from(what != Move::Nothing);
    });
    assert!(stood > 20 && evasion.way().is_none(), "{stood} steps");
}

#[test]
fn nobody_means_no_step_aside() {
    let config = AvoidanceConfig::default();
    let mut evasion = Evasion::new(true);
    drive(Twist::new(0.05, 0.0), 6.0, &wall(1.2, 0.4), |around, odometry| {
        assert_eq!(evasion.step(odometry.stamp, &config, around, odometry), Move::Nothing);
    });
}

/// One number that is none would stay in the history, and nobody would be seen to come any more.
#[test]
fn odometry_that_is_not_a_number_leaves_no_trace() {
    let states = |spoil: Option<fn(&mut Odometry)>| {
        let slip = |odometry: &Odometry| {
            let mut slipped = Odometry { stamp: odometry.stamp + Duration::from_millis(10), ..*odometry };
            spoil.filter(|_| (odometry.stamp.as_secs_f64() - 1.0).abs() < 0.01)?(&mut slipped);
            Some(slipped)
        };
        let comer = person(Point2::new(3.5, 0.0), Vector2::new(-0.4, 0.0));
        let mut states = Vec::new();
        drive_with(FAST, Twist::new(0.3, 0.1), 2.0, &comer, slip, |around, _| states.push(format!("{around:?}")));
        states
    };
    let undisturbed = states(None);
    let nonsense: [fn(&mut Odometry); 3] = [
        |odometry| odometry.pose.x = f64::NAN,
        |odometry| odometry.pose.heading = f64::INFINITY,
        |odometry| odometry.twist.linear = f64::NAN,
    ];
    for (i, spoil) in nonsense.into_iter().enumerate() {
        assert!(states(Some(spoil)) == undisturbed, "nonsense {i} has left a trace");
    }
}

/// A transducer that has died says nothing of what is there now.
#[test]
fn what_a_silent_transducer_heard_last_is_no_news() {
    let ring = ring(FAST);
    let mut around = Surroundings::new(ring.clone(), RADIUS);
    let dead = ring.nearest_to(1.57).unwrap();
    let echoes = |i: usize| if i == dead { Echo::NotFired } else { Echo::Nothing };
    for step in 0..40u32 {
        let now = Time::from_secs_f64(f64::from(step) * STEP);
        around.moved(&Odometry { stamp: now, ..Odometry::default() });
        let heard: Vec<Echo> = (0..16).map(|i| if step < 10 { Echo::Range(1.0) } else { echoes(i) }).collect();
        around.heard(&[SonarScan::from_echoes(now, u64::from(step), &heard)]);
        if step == 9 {
            assert!(around.free_toward(1.57, 0.05, 3.0) > 0.5 && around.all().count() == 16);
        }
    }
    assert_eq!((around.free_toward(1.57, 0.05, 3.0), around.all().count()), (0.0, 0));
    assert_eq!(around.free_toward(0.0, 0.05, 3.0), 3.0, "the others hear that nothing is there");
}
