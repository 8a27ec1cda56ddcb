//! What the numbers of a base are worth, model by model.

use std::f64::consts::PI;

use super::packet::Id;

/// How a model counts its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way {
    /// By encoders of both wheels, which wrap at 16 bits: so many m to a count.
    Encoders(f64),
    /// By whole mm and degrees since it was asked last.
    Sums,
}

/// What has to be known of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// Its name in configurations.
    pub name: &'static str,
    /// Speeds of its serial port, its own first, baud.
    pub bauds: [u32; 2],
    /// Distance between the wheels, m.
    pub tread: f64,
    /// How it counts its way.
    pub way: Way,
    /// The packets that a driver has to know.
    pub packets: &'static [Id],
    /// The last packet that it has.
    pub last: Id,
    /// The sum of a frame may leave its header out: see [`stream`](super::stream).
    pub headless_sum: bool,
}

/// Counts of a whole turn of a wheel.
const COUNTS: f64 = 508.8;
/// Diameter of the wheels, m.
const WHEEL: f64 = 0.072;

/// A Create 2, and the Roombas of the series 500 to 700 of which it is made: 508.8 counts to the turn of a wheel of 72 mm, 235 mm apart.
/// A Roomba whose button was held when it was switched on listens at 19200 baud.
const CREATE_2: Model = Model {
    name: "create2",
    bauds: [115_200, 19_200],
    tread: 0.235,
    way: Way::Encoders(PI * WHEEL / COUNTS),
    packets: &[
        Id::BumpsAndDrops,
        Id::CliffLeft,
        Id::CliffFrontLeft,
        Id::CliffFrontRight,
        Id::CliffRight,
        Id::Overcurrents,
        Id::Voltage,
        Id::Mode,
        Id::LeftEncoder,
        Id::RightEncoder,
        Id::Stasis,
    ],
    last: Id::Stasis,
    headless_sum: false,
};

/// The models that are known. The tread of Create 1, which has no encoders, is libcreate's.
pub const MODELS: [Model; 3] = [
    CREATE_2,
    Model {
        name: "create1",
        bauds: [57_600, 19_200],
        tread: 0.258,
        way: Way::Sums,
        packets: &[
            Id::BumpsAndDrops,
            Id::CliffLeft,
            Id::CliffFrontLeft,
            Id::CliffFrontRight,
            Id::CliffRight,
            Id::Overcurrents,
            Id::Distance,
            Id::Angle,
            Id::Voltage,
            Id::Mode,
        ],
        last: Id::RequestedLeft,
        headless_sum: true,
    },
    Model { name: "roomba", ..CREATE_2 },
];

impl Model {
    /// A Create 2.
    pub const CREATE_2: Self = CREATE_2;

    /// The model of this name.
    ///
    /// ```
    /// use orienteer_hardware::wire::oi::units::Model;
    /// assert_eq!(Model::of("create1").map(|model| model.bauds[0]), Some(57_600));
    /// assert_eq!(Model::of("p3dx"), None);
    /// ```
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        MODELS.into_iter().find(|model| model.name == name)
    }

    /// The least way and the least turn that such a base can tell, m and rad.
    #[must_use]
    pub fn steps(&self) -> (f64, f64) {
        match self.way {
            Way::Encoders(count) => (count, count / self.tread),
            Way::Sums => (0.001, 1f64.to_radians()),
        }
    }
}

/// The change of a counter that wraps, by the shorter way round: up to 14.5 m between two frames of a Create 2.
#[must_use]
pub fn change(before: u16, now: u16) -> i16 {
    now.wrapping_sub(before).cast_signed()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::wire::oi::stream;

    proptest! {
        #[test]
        fn no_count_is_lost_when_a_counter_wraps(from: u16, step in -32_768i32..=32_767) {
            let to = (i32::from(from) + step).rem_euclid(65_536);
            prop_assert_eq!(i32::from(change(from, u16::try_from(to).unwrap_or(0))), step);
        }
    }

    #[test]
    fn a_turn_of_the_wheel_is_its_circumference() {
        let Way::Encoders(count) = CREATE_2.way else { panic!("{:?}", CREATE_2.way) };
        assert!((508.8 * count - 0.2262).abs() < 1e-4, "{count}");
    }

    /// A byte takes ten bits, and a frame must be through before the next one, at the slower speed, too.
    #[test]
    fn frames_fit_into_15_ms() {
        for model in MODELS {
            let slowest = model.bauds.into_iter().min().unwrap_or(0);
            let room = f64::from(slowest) / 10.0 * stream::PERIOD.as_secs_f64();
            let frame = stream::length(model.packets);
            assert!((frame as f64) <= room, "{}: {frame} of {room}", model.name);
            assert!(model.packets.iter().all(|id| *id <= model.last));
        }
    }
}
