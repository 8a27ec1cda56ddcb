#![allow(clippy::unwrap_used)]
use std::time::Duration;

use orienteer_runtime::{geometry::Pose, random::Streams};
use proptest::prelude::*;

use super::*;
use crate::base::{
    kinematics::{BaseConfig, Kinematics},
    odometry::{Odometer, OdometryConfig},
    presets,
};

/// A base without world or protection.
struct Bench {
    base: Kinematics,
    odometer: Odometer,
    executor: Executor,
    now: Time,
    pose: Pose,
    period: f64,
    rng: rand_pcg::Pcg64,
    report: MotionReport,
}

fn decided(holder: u16, transaction: u32, motion: Motion) -> BaseDecision {
    let mut decision = BaseDecision::default();
    decision.holder = ClientId(holder);
    decision.transaction = transaction;
    decision.motion = motion;
    decision
}

impl Bench {
    fn new(config: BaseConfig, errors: OdometryConfig, period: f64) -> Self {
        Self {
            executor: Executor::new(config.platform(), ExecutorConfig::default()),
            base: Kinematics::new(config),
            odometer: Odometer::new(errors),
            now: Time::START,
            pose: Pose::default(),
            period,
            rng: Streams::new(3).stream("ann", "odometry"),
            report: MotionReport::default(),
        }
    }

    fn step(&mut self, holder: u16, transaction: u32, motion: Motion) -> MotionState {
        let decision = decided(holder, transaction, motion);
        let (twist, report) = self.executor.step(self.now, &decision, self.odometer.state(), self.period);
        let travel = self.base.step(self.pose, twist, self.period);
        self.pose = travel.pose;
        self.now = self.now + Duration::from_secs_f64(self.period);
        self.odometer.measure(self.now, travel.distance, travel.turn, self.period, &mut self.rng);
        self.report = report;
        report.state()
    }

    fn run(&mut self, motion: Motion, seconds: f64) -> MotionState {
        for _ in 0..(seconds / self.period) as usize {
            let state = self.step(1, 1, motion);
            if state != MotionState::Running {
                return state;
            }
        }
        MotionState::Running
    }
}

fn turning_bases() -> impl Strategy<Value = BaseConfig> {
    prop::sample::select(vec!["b12-huey", "yamabico", "p3dx", "amigobot"]).prop_map(|name| presets::by_name(name).unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn a_translation_ends_on_its_mark(
        name in prop::sample::select(presets::NAMES.to_vec()), distance in -3.0..3.0f64, speed in 0.02..2.0f64,
        period in prop::sample::select(vec![0.01, 0.05])
    ) {
        let mut bench = Bench::new(presets::by_name(name).unwrap(), OdometryConfig::exact(), period);
        let state = bench.run(Motion::translate(1, distance, speed), 200.0);
        prop_assert_eq!(state, MotionState::Done);
        prop_assert!((bench.pose.x - distance).abs() < 0.002 && bench.pose.y.abs() < 1e-9, "{:?}", bench.pose);
        prop_assert_eq!(bench.report.progress, distance);
        // and it stays there
        for _ in 0..20 {
            prop_assert_eq!(bench.step(1, 1, Motion::translate(1, distance, speed)), MotionState::Done);
        }
        prop_assert!(bench.base.twist().is_stop() && (bench.pose.x - distance).abs() < 0.002);
    }

    #[test]
    fn a_rotation_ends_on_its_mark(
        config in turning_bases(), angle in -7.0..7.0f64, rate in 0.05..3.0f64, period in prop::sample::select(vec![0.01, 0.05])
    ) {
        let mut bench = Bench::new(config, OdometryConfig::exact(), period);
        prop_assert_eq!(bench.run(Motion::rotate(9, angle, rate), 200.0), MotionState::Done);
        let error = bench.odometer.state().turned - angle;
        prop_assert!(error.abs() < 0.2f64.to_radians(), "{error}");
        prop_assert_eq!(bench.report.progress, angle);
        prop_assert_eq!(bench.pose.x, 0.0);
    }

    #[test]
    fn it_arrives_in_the_time_of_a_trapezoid(distance in 0.2..3.0f64, speed in 0.1..1.0f64) {
        let mut bench = Bench::new(presets::b12_huey(), OdometryConfig::exact(), 0.01);
        prop_assert_eq!(bench.run(Motion::translate(1, distance, speed), 100.0), MotionState::Done);
        let a = 2.18 * 0.9;
        let ideal = if speed * speed / a > distance { 2.0 * (distance / a).sqrt() } else { distance / speed + speed / a };
        prop_assert!(bench.now.as_secs_f64() < ideal + 0.25, "{} s, ideal {ideal}", bench.now.as_secs_f64());
    }

    #[test]
    fn coarse_encoders_and_noise_do_not_keep_it_from_ending(
        config in turning_bases(), distance in -2.0..2.0f64, period in prop::sample::select(vec![0.01, 0.05])
    ) {
        let errors = OdometryConfig { distance_step: 0.001, turn_step: 0.002, ..OdometryConfig::default() };
        let mut bench = Bench::new(config, errors, period);
        prop_assert_eq!(bench.run(Motion::translate(1, distance, 0.3), 100.0), MotionState::Done);
        prop_assert!((bench.pose.x - distance).abs() < 0.002 + 0.002 * distance.abs() + 5.0 * 0.00133 * distance.abs().sqrt());
    }

    #[test]
    fn a_move_that_begins_in_full_drive_still_ends_on_its_mark(before in -1.0..1.0f64, distance in -1.0..1.0f64) {
        let mut bench = Bench::new(presets::p3dx(), OdometryConfig::exact(), 0.05);
        for _ in 0..100 {
            bench.step(1, 1, Motion::velocity(Twist::new(before, 0.0)));
        }
        let start = bench.pose.x;
        prop_assert_eq!(bench.run(Motion::translate(1, distance, 0.5), 100.0), MotionState::Done);
        prop_assert!((bench.pose.x - start - distance).abs() < 0.002);
    }
}

#[test]
fn a_displaced_move_is_given_up_and_a_new_id_begins_anew() {
    let mut bench = Bench::new(presets::b12_huey(), OdometryConfig::exact(), 0.05);
    let go = Motion::translate(7, 1.0, 0.2);
    for _ in 0..20 {
        assert_eq!(bench.step(1, 1, go), MotionState::Running);
    }
    let progress = bench.report.progress;
    // somebody else takes over for a moment, even with the same id
    for _ in 0..20 {
        assert_eq!(bench.step(2, 1, Motion::translate(7, -0.5, 0.2)), MotionState::Running);
    }
    assert_eq!(bench.report.id, 7);
    let here = bench.pose;
    for _ in 0..20 {
        assert_eq!(bench.step(1, 1, go), MotionState::Blocked);
        assert_eq!((bench.report.id, bench.report.progress), (7, progress));
    }
    assert!(here.distance(&bench.pose) < 0.02, "it stands");
    let start = bench.pose;
    assert_eq!(bench.run(Motion::translate(8, 0.3, 0.2), 10.0), MotionState::Done);
    assert!((bench.pose.distance(&start) - 0.3).abs() < 0.002);
    // a new transaction of the same holder may use an old id
    assert_eq!(bench.step(1, 2, go), MotionState::Running);
}

#[test]
fn a_finished_move_stays_done() {
    let mut bench = Bench::new(presets::b12_huey(), OdometryConfig::exact(), 0.05);
    let go = Motion::translate(7, 0.1, 0.2);
    assert_eq!(bench.run(go, 10.0), MotionState::Done);
    assert_eq!(bench.step(2, 1, Motion::velocity(Twist::new(0.2, 0.0))), MotionState::Idle);
    assert_eq!(bench.step(1, 1, go), MotionState::Done);
    assert_eq!(bench.report.progress, 0.1);
}

#[test]
fn a_change_of_speed_or_distance_under_way_keeps_the_progress() {
    let mut bench = Bench::new(presets::b12_huey(), OdometryConfig::exact(), 0.05);
    for _ in 0..20 {
        bench.step(1, 1, Motion::translate(7, 1.0, 0.2));
    }
    assert_eq!(bench.run(Motion::translate(7, 0.5, 0.05), 20.0), MotionState::Done);
    assert!((bench.pose.x - 0.5).abs() < 0.002);
}

#[test]
fn a_bicycle_refuses_to_turn_in_place_at_once() {
    let mut bench = Bench::new(presets::wheelchair(), OdometryConfig::exact(), 0.05);
    assert_eq!(bench.step(1, 1, Motion::rotate(1, 1.0, 0.5)), MotionState::Blocked);
    assert!(bench.base.twist().is_stop());
}

#[test]
fn a_move_without_progress_is_given_up() {
    let mut executor = Executor::new(presets::b12_huey().platform(), ExecutorConfig::default());
    let mut run = |flags: u32, id: u32, seconds: f64| {
        let decision = decided(1, 1, Motion::translate(id, 1.0, 0.2));
        let odometry = Odometry { flags, ..Odometry::default() };
        let mut state = MotionState::Idle;
        for i in 0..=(seconds * 20.0) as u64 {
            let now = Time::from_secs_f64(f64::from(id) * 100.0) + Duration::from_millis(50 * i);
            let (twist, report) = executor.step(now, &decision, &odometry, 0.05);
            state = report.state();
            assert!(state == MotionState::Running || twist.is_stop());
        }
        state
    };
    assert_eq!(run(flags::ENABLED, 1, 9.9), MotionState::Running);
    assert_eq!(run(flags::ENABLED, 2, 10.2), MotionState::Blocked);
    assert_eq!(run(flags::CONTACT, 3, 0.4), MotionState::Running);
    assert_eq!(run(flags::CONTACT, 4, 0.6), MotionState::Blocked);
    assert_eq!(run(flags::STALLED, 5, 0.0), MotionState::Blocked);
    assert_eq!(run(flags::EMERGENCY_STOP, 6, 0.0), MotionState::Blocked);
}

#[test]
fn a_straight_move_steers_a_turned_heading_back() {
    let mut bench = Bench::new(presets::p3dx(), OdometryConfig::exact(), 0.05);
    for _ in 0..40 {
        bench.step(1, 1, Motion::velocity(Twist::new(0.3, 0.2)));
    }
    let heading = bench.odometer.state().turned;
    assert_eq!(bench.run(Motion::translate(2, 3.0, 0.3), 60.0), MotionState::Done);
    assert!((bench.odometer.state().turned - heading).abs() < 0.01);
}
