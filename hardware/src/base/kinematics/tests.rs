#![allow(clippy::unwrap_used)]
use proptest::prelude::*;

use super::*;

fn drives() -> impl Strategy<Value = BaseConfig> {
    (0..presets::NAMES.len()).prop_map(|i| presets::by_name(presets::NAMES[i]).unwrap())
}

fn demands() -> impl Strategy<Value = Vec<Twist>> {
    prop::collection::vec((-2.0..2.0f64, -4.0..4.0f64).prop_map(|(v, w)| Twist::new(v, w)), 1..20)
}

/// The pose by brute force: ten times shorter arcs.
fn fine_pose(config: &BaseConfig, demand: &[Twist], seconds: f64) -> Pose {
    let mut base = Kinematics::new(config.clone());
    let mut pose = Pose::default();
    for twist in demand {
        for _ in 0..500 {
            pose = base.step(pose, *twist, seconds / 500.0).pose;
        }
    }
    pose
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_limit_is_ever_exceeded(config in drives(), demand in demands(), seconds in 0.01..0.2f64) {
        let mut base = Kinematics::new(config.clone());
        let limits = config.platform().limits;
        let mut before = base.twist();
        for twist in demand {
            let travel = base.step(Pose::default(), twist, seconds);
            let now = base.twist();
            prop_assert!(now.linear.abs() <= limits.linear + 1e-9 && now.angular.abs() <= limits.angular + 1e-9);
            prop_assert!((now.linear - before.linear).abs() <= config.acceleration * seconds + 1e-9);
            prop_assert!(travel.distance.abs() <= limits.linear * seconds + 1e-9);
            match config.drive {
                Drive::Synchro {} => {
                    prop_assert!((now.angular - before.angular).abs() <= config.angular_acceleration * seconds + 1e-9);
                }
                Drive::Differential { tread, wheel_speed } => {
                    prop_assert!(now.linear.abs() + 0.5 * tread * now.angular.abs() <= wheel_speed + 0.5 * tread * config.angular_acceleration * LONGEST_ARC + 1e-9);
                }
                Drive::Bicycle { steering_limit, .. } => {
                    prop_assert!(base.steering().abs() <= steering_limit + 1e-9);
                    prop_assert!(now.angular.abs() * config.turning_radius() <= now.linear.abs() + 1e-9);
                }
            }
            before = now;
        }
    }

    #[test]
    fn one_long_step_agrees_with_many_short_ones(config in drives(), demand in demands(), seconds in 0.02..0.1f64) {
        let mut base = Kinematics::new(config.clone());
        let coarse = demand.iter().fold(Pose::default(), |pose, twist| base.step(pose, *twist, seconds).pose);
        let fine = fine_pose(&config, &demand, seconds);
        prop_assert!(coarse.distance(&fine) < 2e-3, "{coarse:?} {fine:?}");
    }
}

#[test]
fn a_synchro_drive_turns_in_place_and_a_bicycle_does_not() {
    let mut b12 = Kinematics::new(presets::b12_huey());
    let mut chair = Kinematics::new(presets::wheelchair());
    let (mut here, mut there) = (Pose::default(), Pose::default());
    for _ in 0..100 {
        here = b12.step(here, Twist::new(0.0, 0.5), 0.02).pose;
        there = chair.step(there, Twist::new(0.0, 0.5), 0.02).pose;
    }
    assert!(here.x == 0.0 && here.y == 0.0 && here.heading > 0.9);
    assert_eq!(there, Pose::default());
}

/// Shanley (1994): at 45° the front axle describes a circle of radius `L / sin δ` = 0.707 m about the same centre.
#[test]
fn the_front_axle_of_the_wheelchair_describes_the_published_circle() {
    let mut chair = Kinematics::new(presets::wheelchair());
    let mut pose = Pose::default();
    let demand = Twist::new(0.5, 10.0); // asks for more than the wheels can give
    for _ in 0..200 {
        pose = chair.step(pose, demand, 0.05).pose;
    }
    assert!((chair.steering() - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
    let centre = pose.then(Pose::new(0.0, chair.config().turning_radius(), 0.0));
    let front = pose.then(Pose::new(0.5, 0.0, 0.0));
    assert!((front.distance(&centre) - 0.5f64.hypot(0.5)).abs() < 1e-9);
    assert!((chair.twist().angular - 0.5 / chair.config().turning_radius()).abs() < 1e-12);
    // the speed of the front axle, v / cos δ, gives the published yaw rate v_f·sin δ / L
    let front_speed = chair.twist().linear / chair.steering().cos();
    assert!((chair.twist().angular - front_speed * chair.steering().sin() / 0.5).abs() < 1e-12);
}

/// MacPherson (1993): the velocity ceiling in a curve.
#[test]
fn a_differential_drive_slows_down_in_a_curve_and_keeps_it() {
    let mut yamabico = Kinematics::new(presets::yamabico());
    for _ in 0..1000 {
        yamabico.step(Pose::default(), Twist::new(0.6, 1.2), 0.01);
    }
    let twist = yamabico.twist();
    assert!((twist.linear - 0.6 / (1.0 + 0.27 * 2.0)).abs() < 1e-9, "{twist:?}");
    assert!((twist.angular / twist.linear - 2.0).abs() < 1e-9);
}

#[test]
fn a_demand_that_is_not_finite_is_a_stop() {
    let mut base = Kinematics::new(presets::p3dx());
    base.step(Pose::default(), Twist::new(0.5, 0.0), 0.5);
    assert!(base.twist().linear > 0.1);
    for _ in 0..100 {
        base.step(Pose::default(), Twist::new(f64::NAN, f64::INFINITY), 0.1);
    }
    assert!(base.twist().is_stop());
}

#[test]
fn a_drive_refuses_unknown_keys() {
    let good = "drive = { kind = \"synchro\" }\nradius = 0.2";
    assert_eq!(toml::from_str::<BaseConfig>(good).unwrap().radius, 0.2);
    for bad in [
        "drive = { kind = \"synchro\", tread = 0.3 }",
        "drive = { kind = \"differential\", tread = 0.3, wheel_speed = 1.0, spoke = 3 }",
        "drive = { kind = \"differential\", tread = 0.3 }",
        "drive = { kind = \"hover\" }",
        "radios = 0.3",
    ] {
        assert!(toml::from_str::<BaseConfig>(bad).is_err(), "{bad}");
    }
}

#[test]
fn every_preset_has_a_sound_platform() {
    for name in presets::NAMES {
        let platform = presets::by_name(name).unwrap().platform();
        assert_eq!(platform.name, name);
        assert!(platform.limits.linear > 0.0 && platform.limits.angular > 0.0 && platform.radius > 0.1);
    }
    assert!(presets::by_name("tricycle").is_none());
}
