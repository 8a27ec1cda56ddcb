//! What the numbers of a base are worth.
//!
//! Older controllers count encoder ticks, and their wheels are what they are; newer ones (`-sh`) count millimetres.

use std::f64::consts::TAU;

use super::information::Information;

/// What a unit of one model is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// The model, as in the greeting.
    pub model: &'static str,
    /// A unit of position, m.
    pub distance: f64,
    /// A unit of a wheel's speed, m/s.
    pub speed: f64,
    /// A unit of a sonar's range, m.
    pub range: f64,
    /// Distance between the wheels, by which their speeds make a turn rate, m. As wide tyres and skidding have it, not as a ruler
    /// would.
    pub tread: f64,
}

/// A unit of heading, rad; the same for all.
pub const ANGLE: f64 = TAU / 4096.0;

/// The models that are known, with the factors of ARIA's parameter files.
pub const MODELS: [Units; 12] = [
    units("p3dx-sh", 1.0, 1.0, 1.0, 0.0056),
    units("p3dx", 0.485, 1.0, 1.0, 0.0056),
    units("p3at-sh", 1.0, 1.0, 1.0, 0.0034),
    units("p3at", 0.465, 1.0, 1.0, 0.0034),
    units("p2dx", 0.84, 1.0, 0.268, 0.0056),
    units("p2de", 0.969, 1.0, 0.268, 0.0056),
    units("p2d8", 0.485, 1.0, 1.0, 0.0056),
    units("p2d8+", 0.485, 1.0, 1.0, 0.0056),
    units("p2at", 1.32, 1.0, 0.268, 0.0034),
    units("p2at8", 1.32, 1.0, 1.0, 0.0034),
    units("amigo", 0.5083, 0.6154, 1.0, 0.011),
    units("amigo-sh", 1.0, 1.0, 1.0, 0.011),
];

/// From ARIA's factors: mm and mm/s per unit, and rad/s for half a mm/s of difference between the wheels.
const fn units(model: &'static str, distance: f64, speed: f64, range: f64, turn: f64) -> Units {
    Units { model, distance: distance / 1000.0, speed: speed / 1000.0, range: range / 1000.0, tread: 0.002 / turn }
}

impl Units {
    /// The units of the model of this name, in whatever case.
    ///
    /// ```
    /// use orienteer_hardware::wire::arcos::units::Units;
    /// assert_eq!(Units::of("P2DX").map(|units| units.speed), Some(0.001));
    /// assert_eq!(Units::of("roomba"), None);
    /// ```
    #[must_use]
    pub fn of(model: &str) -> Option<Self> {
        MODELS.into_iter().find(|units| units.model.eq_ignore_ascii_case(model))
    }
}

/// Position and heading in units of the base, from where its counters began to be read on, with nothing lost when they wrap.
///
/// Positions have 15 bits on the older controllers and 16 on others, so the lower 15 are counted; headings go round in 4096. Between
/// two packets a base may go half way round its counters, 7.9 m and half a turn for a P3-DX, before a count is lost.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Unwrapped {
    /// Along the axis of the base's own frame.
    pub x: i64,
    /// To the left of it.
    pub y: i64,
    /// Counter-clockwise.
    pub heading: i64,
    last: Option<(u16, u16, i16)>,
}

impl Unwrapped {
    /// Goes on to where the base is now. The first packet that it gets is where it begins.
    pub fn follow(&mut self, packet: &Information) {
        let now = (packet.x, packet.y, packet.heading);
        let last = self.last.replace(now).unwrap_or(now);
        self.x += change(now.0.wrapping_sub(last.0), 15);
        self.y += change(now.1.wrapping_sub(last.1), 15);
        self.heading += change(now.2.wrapping_sub(last.2).cast_unsigned(), 12);
    }

    /// Takes the next packet for where the base is, however far from the last: for when the base has begun anew.
    pub fn begin_anew(&mut self) {
        self.last = None;
    }
}

/// The lower bits of a difference as a signed number.
fn change(difference: u16, bits: u32) -> i64 {
    let unused = 16 - bits;
    i64::from((difference << unused).cast_signed() >> unused)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// However the counters wrap, the sum of all steps is the way gone.
        #[test]
        fn nothing_is_lost_when_counters_wrap(
            start in any::<(u16, u16)>(),
            bits in 15u32..=16,
            steps in proptest::collection::vec((-0x3FFFi64..0x4000, -0x3FFFi64..0x4000, -2047i64..2048), 0..50),
        ) {
            let mut truth = (i64::from(start.0), i64::from(start.1), 0i64);
            let begun = truth;
            let mut unwrapped = Unwrapped::default();
            for step in std::iter::once((0, 0, 0)).chain(steps) {
                truth = (truth.0 + step.0, truth.1 + step.1, truth.2 + step.2);
                let counter = |count: i64| (count.rem_euclid(1 << bits)) as u16;
                let heading = ((truth.2 + 2048).rem_euclid(4096) - 2048) as i16;
                unwrapped.follow(&Information { x: counter(truth.0), y: counter(truth.1), heading, ..Information::default() });
                let way = (truth.0 - begun.0, truth.1 - begun.1, truth.2 - begun.2);
                prop_assert_eq!((unwrapped.x, unwrapped.y, unwrapped.heading), way);
            }
        }
    }

    #[test]
    fn a_base_that_was_switched_off_does_not_jump() {
        let mut unwrapped = Unwrapped::default();
        for x in [100, 150] {
            unwrapped.follow(&Information { x, ..Information::default() });
        }
        unwrapped.begin_anew();
        for x in [0, 7] {
            unwrapped.follow(&Information { x, ..Information::default() });
        }
        assert_eq!(unwrapped.x, 57);
    }
}
