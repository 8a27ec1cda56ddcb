//! The bases that the sources drove, and three that can still be bought.
//!
//! Where a source is silent the number is our choice and says so; the maker's manual of the B12 (Real World Interface 1988,
//! cited by Good) was not to be had.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::kinematics::{BaseConfig, Drive};

/// The names that [`by_name`] knows.
pub const NAMES: [&str; 7] = ["b12-huey", "b12-luey", "yamabico", "wheelchair", "p3dx", "amigobot", "create2"];

/// All presets.
pub fn all() -> impl Iterator<Item = BaseConfig> {
    NAMES.into_iter().filter_map(by_name)
}

/// The preset of this name.
#[must_use]
pub fn by_name(name: &str) -> Option<BaseConfig> {
    match name {
        "b12-huey" => Some(b12_huey()),
        "b12-luey" => Some(b12_luey()),
        "yamabico" => Some(yamabico()),
        "wheelchair" => Some(wheelchair()),
        "p3dx" => Some(p3dx()),
        "amigobot" => Some(amigobot()),
        "create2" => Some(create2()),
        _ => None,
    }
}

/// Huey, a Real World Interface B12 with a stabilising ring of 60 cm (Randazza 1989).
///
/// Acceleration 2.18 m/s² is Randazza's constant. Its programs drive at 0.02 to 0.08 m/s and turn at 4 to 16 °/s; the limits
/// here (1.0 m/s, 90 °/s, 180 °/s²) are our choice.
#[must_use]
pub fn b12_huey() -> BaseConfig {
    BaseConfig {
        name: "b12-huey".into(),
        radius: 0.30,
        speed: 1.0,
        turn_rate: FRAC_PI_2,
        acceleration: 2.18,
        angular_acceleration: PI,
        drive: Drive::Synchro {},
    }
}

/// Luey, a bare B12 of 33 cm with a sonar tower (Good 1992).
///
/// The tower's corners stand 18.4 cm from the centre, outside the base's own 16.5 cm; the circle is drawn about both. Limits as
/// for Huey; Good's navigators travel at up to 0.12 m/s and 10 °/s, and scan at 15 °/s.
#[must_use]
pub fn b12_luey() -> BaseConfig {
    BaseConfig { name: "b12-luey".into(), radius: 0.19, ..b12_huey() }
}

/// Yamabico-11, 54 cm × 54 cm (MacPherson 1993): the circle is drawn about the corners, `27·√2` cm.
///
/// 0.6 m/s, 0.2 m/s² and a wheel ceiling of 0.6 m/s are MacPherson's; the tread of 54 cm reproduces the times that he prints. His
/// 0.5 rad/s and 0.5 rad/s² are defaults of the *command* to turn in place, not limits of the vehicle: his own test drives a
/// 50 cm circle at 30 cm/s, 0.6 rad/s. So the turn rate is what the wheels allow, and 2 rad/s² is our choice.
#[must_use]
pub fn yamabico() -> BaseConfig {
    BaseConfig {
        name: "yamabico".into(),
        radius: 0.382,
        speed: 0.6,
        turn_rate: 2.22,
        acceleration: 0.2,
        angular_acceleration: 2.0,
        drive: Drive::Differential { tread: 0.54, wheel_speed: 0.6 },
    }
}

/// The wheelchair (Shanley 1994): wheelbase 0.5 m, up to 1.5 m/s, body 0.4 m wide between the axles.
///
/// Shanley steers up to 45° at once and lets the speed follow with a time constant of 0.1 s; 1.5 m/s² and 3 rad/s are our choice.
/// The robot frame lies at the rear axle (see [`kinematics`](super::kinematics)), so the circle about the body,
/// `√(0.5² + 0.2²)` m, is wide.
#[must_use]
pub fn wheelchair() -> BaseConfig {
    BaseConfig {
        name: "wheelchair".into(),
        radius: 0.54,
        speed: 1.5,
        turn_rate: 3.0,
        acceleration: 1.5,
        angular_acceleration: 6.0,
        drive: Drive::Bicycle { wheelbase: 0.5, steering_limit: FRAC_PI_4, steering_rate: 3.0 },
    }
}

/// Pioneer P3-DX: swing radius 26.7 cm and 1.2 m/s by its data sheet.
///
/// 0.3 m/s², 100 °/s² and 100 °/s are our choice, near what its firmware is said to ship with; the wheels stand 33 cm apart.
#[must_use]
pub fn p3dx() -> BaseConfig {
    BaseConfig {
        name: "p3dx".into(),
        radius: 0.267,
        speed: 1.2,
        turn_rate: 1.745,
        acceleration: 0.3,
        angular_acceleration: 1.745,
        drive: Drive::Differential { tread: 0.33, wheel_speed: 1.2 },
    }
}

/// AmigoBot: radius 18 cm, 1.0 m/s and 28 cm wide by the parameter file of the maker's library.
///
/// Accelerations and turn rate as for the P3-DX.
#[must_use]
pub fn amigobot() -> BaseConfig {
    BaseConfig {
        name: "amigobot".into(),
        radius: 0.18,
        speed: 1.0,
        drive: Drive::Differential { tread: 0.28, wheel_speed: 1.0 },
        ..p3dx()
    }
}

/// iRobot Create 2: wheels of up to 500 mm/s that stand 235 mm apart, by its specification; its diameter of 34 cm is that of a Roomba
/// 600.
///
/// The base itself changes its speed as fast as its motors can. 0.5 m/s² and 4 rad/s², which at the wheels are about the same, are our
/// choice.
#[must_use]
pub fn create2() -> BaseConfig {
    BaseConfig {
        name: "create2".into(),
        radius: 0.17,
        speed: 0.5,
        turn_rate: 4.25,
        acceleration: 0.5,
        angular_acceleration: 4.0,
        drive: Drive::Differential { tread: 0.235, wheel_speed: 0.5 },
    }
}
