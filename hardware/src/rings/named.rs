//! The rings that have a name, with their sources.

use std::f64::consts::TAU;

use orienteer_runtime::{
    geometry::Pose,
    robot_model::{Ring, Transducer},
    topics::{FiringProgram, FixedVec},
};

use crate::echo::{DetectionPoint, IncidencePoint, SonarModel};

/// A ring that has a name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedRing {
    /// Where the transducers are and when they fire.
    pub ring: Ring,
    /// How they hear.
    pub model: SonarModel,
    /// One line for a list of rings.
    pub help: &'static str,
}

/// The ring of that name.
///
/// ```
/// let huey = orienteer_hardware::rings::find("denning-16").unwrap();
/// assert_eq!(huey.ring.transducers.len(), 16);
/// // Huey counts clockwise from the front: 4 looks to the right.
/// assert!((huey.ring.transducers[4].mount.heading + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
/// assert!(orienteer_hardware::rings::find("bat").is_none());
/// ```
#[must_use]
pub fn find(name: &str) -> Option<NamedRing> {
    all().find(|named| named.ring.name == name)
}

/// All named rings.
pub fn all() -> impl Iterator<Item = NamedRing> {
    let makers: [fn() -> NamedRing; 8] =
        [denning_16, luey_8_square, luey_8_front, yamabico_12, wheelchair_6, p3dx_16, amigobot_8, robond_8];
    makers.into_iter().map(|make| make())
}

/// A transducer from metres and degrees.
fn at(x: f64, y: f64, bearing_deg: f64, half_beam_deg: f64) -> Transducer {
    Transducer { mount: Pose::new(x, y, bearing_deg.to_radians()), half_beam: half_beam_deg.to_radians() }
}

fn program(slots: &[&[u32]], period: f32) -> FiringProgram {
    let mut masks = FixedVec::filled(0, slots.len());
    for (mask, slot) in masks.iter_mut().zip(slots) {
        *mask = slot.iter().fold(0, |mask, transducer| mask | 1 << transducer);
    }
    FiringProgram { slots: masks, period, rings: 1 }
}

/// Randazza 1989: two stacked rings of eight, 22.5° apart in all, that fire in turn. Even indices are one physical ring, odd
/// ones the other; a whole ring takes 25 ms. Readings are whole tenths of a foot up to 25.5 ft, which means no echo. The
/// radius, the beam of ±12°, the incidence limit of 30° and the least range of 20 cm are those of the model that reproduces
/// the wall-end overshoot of 14 cm that he reports.
fn denning_16() -> NamedRing {
    let radius = 0.08;
    let transducer = |k: u32| {
        let bearing = -TAU * f64::from(k) / 16.0;
        Transducer { mount: Pose::new(radius * bearing.cos(), radius * bearing.sin(), bearing), half_beam: 12f64.to_radians() }
    };
    let ring = Ring {
        name: "denning-16".into(),
        transducers: (0..16).map(transducer).collect(),
        min_range: 0.20,
        max_range: 7.77,
        slot_time: 0.0125,
        program: program(&[&[0, 2, 4, 6, 8, 10, 12, 14], &[1, 3, 5, 7, 9, 11, 13, 15]], 0.0),
    };
    let model = SonarModel { noise: 0.01, quantum: 0.03048, spurious: 0.01, ..SonarModel::default().with_incidence_limit(30.0) };
    NamedRing { ring, model, help: "Huey's Denning ring: 16 at 22.5 degrees, clockwise from the front (Randazza 1989)" }
}

/// Good 1992, firing order and 10 ms between firings. One scan was measured to cost the robot 0.66 s, which is the period.
const LUEY_ORDER: [&[u32]; 8] = [&[0], &[5], &[2], &[7], &[4], &[1], &[6], &[3]];

/// Good 1992, table of mounts: x, y in cm of the base's centre, facing in degrees. Sonars that share a corner of the square
/// tower are stacked. Units 2 and 3 are the pair that the two arrangements place differently.
fn luey(name: &str, two: [f64; 3], three: [f64; 3], help: &'static str) -> NamedRing {
    let table = [
        [-8.2, -8.5, -90.0],
        [-8.2, 9.5, 90.0],
        two,
        three,
        [13.3, -11.0, 0.0],
        [13.3, 12.0, 0.0],
        [15.8, -8.5, -90.0],
        [15.8, 9.5, 90.0],
    ];
    let ring = Ring {
        name: name.into(),
        transducers: table.iter().map(|[x, y, facing]| at(0.01 * x, 0.01 * y, *facing, 15.0)).collect(),
        min_range: 0.03,
        max_range: 5.99,
        slot_time: 0.01,
        program: program(&LUEY_ORDER, 0.66),
    };
    NamedRing { ring, model: SonarModel { second_bounce: true, ..SonarModel::default() }, help }
}

fn luey_8_square() -> NamedRing {
    let (left, right) = ([-5.7, 12.0, 180.0], [-5.7, -11.0, 180.0]);
    luey("luey-8-square", left, right, "Luey's ring as four parallel pairs: front, left, right, back (Good 1992)")
}

fn luey_8_front() -> NamedRing {
    let (right, left) = ([11.6, -10.2, -45.0], [11.6, 11.2, 45.0]);
    luey("luey-8-front", right, left, "Luey's ring with the back pair moved to the front corners at 45 degrees (Good 1992)")
}

/// MacPherson 1993, §III: twelve collimated pairs in three groups that ping in turn every 24 ms, 9.3 cm to 4.09 m, 1 mm.
/// Surfaces must be met within 15°, less from far away (10° to 2 m), and every material of his world is heard to 2.3 m if it
/// reflects half. The drawing of the array is lost; positions follow from what text and listing fix (names, side sonars at
/// 23 cm). The beam's width is nowhere printed: "much narrower" than the usual 15° to each side, and his own simulator takes
/// it for a line. 5° is our choice, and so is that corners are heard from half a metre.
fn yamabico_12() -> NamedRing {
    let table = [
        [23.0, 12.0, 0.0],
        [-23.0, 12.0, 180.0],
        [-23.0, -12.0, 180.0],
        [23.0, -12.0, 0.0],
        [12.0, 23.0, 90.0],
        [-12.0, 23.0, 90.0],
        [-12.0, -23.0, -90.0],
        [12.0, -23.0, -90.0],
        [20.0, 20.0, 45.0],
        [20.0, -20.0, -45.0],
        [-20.0, 20.0, 135.0],
        [-20.0, -20.0, -135.0],
    ];
    let ring = Ring {
        name: "yamabico-12".into(),
        transducers: table.iter().map(|[x, y, axis]| at(0.01 * x, 0.01 * y, *axis, 5.0)).collect(),
        min_range: 0.093,
        max_range: 4.09,
        slot_time: 0.024,
        program: program(&[&[0, 2, 5, 7], &[1, 3, 4, 6], &[8, 9, 10, 11]], 0.0),
    };
    let limits = [(1.0, 15.0), (2.0, 10.0), (4.0, 5.0)];
    let model = SonarModel {
        incidence_limit: limits.iter().map(|&(range, limit_deg)| IncidencePoint { range, limit_deg }).collect(),
        detection: vec![
            DetectionPoint { range: 0.0, reflectance: 0.0 },
            DetectionPoint { range: 2.3, reflectance: 0.5 },
            DetectionPoint { range: 4.6, reflectance: 1.0 },
        ],
        vertex_range: 0.5,
        noise: 0.003,
        quantum: 0.001,
        ..SonarModel::default()
    };
    NamedRing { ring, model, help: "Yamabico's array: 12 narrow beams in three groups (MacPherson 1993)" }
}

/// Shanley 1994: units 2 and 3 are crossed (mounted left, looking to the right, and the other way round). The source's frame
/// has its origin at the middle of the front axle, x to the right, y to the rear and clockwise angles; the table has ours, but
/// for the origin: the robot frame of [`wheelchair`](crate::base::presets::wheelchair) lies at the rear axle. One
/// complete scan every supervisor cycle of 0.2 s. Echoes from below 0.40 m are discarded by the instrument.
fn wheelchair_6() -> NamedRing {
    const WHEELBASE: f64 = 0.5;
    let table =
        [[0.0, 0.0, 0.0], [-0.5, 0.0, 180.0], [0.0, 0.2, -67.5], [0.0, -0.2, 67.5], [-0.45, 0.25, 90.0], [-0.45, -0.25, -90.0]];
    let ring = Ring {
        name: "wheelchair-6".into(),
        transducers: table.iter().map(|[x, y, bearing]| at(WHEELBASE + x, *y, *bearing, 10.0)).collect(),
        min_range: 0.40,
        max_range: 10.0,
        slot_time: 0.2,
        program: program(&[&[0, 1, 2, 3, 4, 5]], 0.2),
    };
    NamedRing { ring, model: SonarModel::default(), help: "A wheelchair's six, the angled pair crossed (Shanley 1994)" }
}

/// `SonarUnit` lines of ARIA's parameter file `p3dx.p`, in mm and degrees. That one transducer of each array fires
/// every 40 ms is what its users report; the maker's manual was not to be had. No echo reads 5 m. The beam of 30° is that of Stage's model of the robot (`pioneer.inc`).
fn p3dx_16() -> NamedRing {
    let front = [
        [69.0, 136.0, 90.0],
        [114.0, 119.0, 50.0],
        [148.0, 78.0, 30.0],
        [166.0, 27.0, 10.0],
        [166.0, -27.0, -10.0],
        [148.0, -78.0, -30.0],
        [114.0, -119.0, -50.0],
        [69.0, -136.0, -90.0],
    ];
    let rear = [
        [-157.0, -136.0, -90.0],
        [-203.0, -119.0, -130.0],
        [-237.0, -78.0, -150.0],
        [-255.0, -27.0, -170.0],
        [-255.0, 27.0, 170.0],
        [-237.0, 78.0, 150.0],
        [-203.0, 119.0, 130.0],
        [-157.0, 136.0, 90.0],
    ];
    let ring = Ring {
        name: "p3dx-16".into(),
        transducers: front.iter().chain(&rear).map(|[x, y, bearing]| at(1e-3 * x, 1e-3 * y, *bearing, 15.0)).collect(),
        min_range: 0.10,
        max_range: 5.0,
        slot_time: 0.04,
        program: program(&[&[0, 8], &[1, 9], &[2, 10], &[3, 11], &[4, 12], &[5, 13], &[6, 14], &[7, 15]], 0.0),
    };
    NamedRing { ring, model: SonarModel::default(), help: "Pioneer 3-DX: arrays of 8 in front and behind (ARIA p3dx.p)" }
}

/// `SonarUnit` lines of ARIA's parameter file `amigo.p`, in mm and degrees; later files of the same robot differ by up to
/// 6 mm. One transducer fires every 40 ms; ranges and beam as for the Pioneer 3-DX.
fn amigobot_8() -> NamedRing {
    let table = [
        [76.0, 100.0, 90.0],
        [125.0, 75.0, 41.0],
        [150.0, 30.0, 15.0],
        [150.0, -30.0, -15.0],
        [125.0, -75.0, -41.0],
        [76.0, -100.0, -90.0],
        [-140.0, -58.0, -145.0],
        [-140.0, 58.0, 145.0],
    ];
    let ring = Ring {
        name: "amigobot-8".into(),
        transducers: table.iter().map(|[x, y, bearing]| at(1e-3 * x, 1e-3 * y, *bearing, 15.0)).collect(),
        min_range: 0.10,
        max_range: 5.0,
        slot_time: 0.04,
        program: program(&[&[0], &[1], &[2], &[3], &[4], &[5], &[6], &[7]], 0.0),
    };
    NamedRing { ring, model: SonarModel::default(), help: "AmigoBot: 6 in front, 2 behind (ARIA amigo.p)" }
}

/// The eight sensors of the log that comes with RoboND's occupancy grid mapping exercise: right to left, all taken to be in
/// the robot's middle, beams of 20°, steps of 10 mm up to 5.10 m. All eight are read at once, every 0.2 to 0.4 s.
pub(crate) fn robond_8() -> NamedRing {
    let bearings = [-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0];
    let ring = Ring {
        name: "robond-8".into(),
        transducers: bearings.iter().map(|bearing| at(0.0, 0.0, *bearing, 10.0)).collect(),
        min_range: 0.01,
        max_range: 5.1,
        slot_time: 0.2,
        program: program(&[&[0, 1, 2, 3, 4, 5, 6, 7]], 0.2),
    };
    let model = SonarModel { quantum: 0.01, ..SonarModel::default() };
    NamedRing { ring, model, help: "The 8 sensors of the RoboND occupancy grid mapping log" }
}

#[cfg(test)]
mod shanley;
#[cfg(test)]
mod tests;
