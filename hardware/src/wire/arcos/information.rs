//! What the base says of itself ten times a second or more often: where it is, how fast, what it bumps into, what its sonars
//! hear.
//!
//! All bases send the standard part. Newer ones append more, field by field, so that older clients still understand the
//! beginning; whatever is behind the last field that is known here is left alone.

use smallvec::SmallVec;

use super::frame::{self, Frame};
use crate::wire::{PacketError, fields::Fields};

/// Packets of this kind say that the wheels stand still; those of the next, that they turn.
const STANDING: u8 = 0x32;
const MOVING: u8 = 0x33;

/// Readings for which a packet with everything else has room.
const ROOM_FOR_SONARS: usize = (frame::MOST - KIND_AND_STANDARD - MORE) / 3;
const KIND_AND_STANDARD: usize = 20;
const MORE: usize = 10;

/// Bits of [`Information::flags`].
pub mod flags {
    /// The motors are on.
    pub const MOTORS: u16 = 1;
    /// Any of the four sonar arrays is on.
    pub const SONARS: u16 = 0b1_1110;
    /// Somebody has pressed the stop button.
    pub const STOP_BUTTON: u16 = 1 << 5;
}

/// Bits of [`Information::left`] and [`Information::right`]: what the wheels and the bumpers feel.
pub mod touch {
    /// The wheel does not turn as it should.
    pub const STALL: u8 = 1;
    /// Any segment of a bumper is pressed, the first at bit 1.
    pub const BUMPERS: u8 = !STALL;
}

/// A reading of one transducer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SonarReading {
    /// The transducer, counted from 0.
    pub transducer: u8,
    /// The range in units of the base; [`units`](super::units).
    pub range: u16,
}

/// Readings of one packet; those of all transducers of a base fit without an allocation.
pub type SonarReadings = SmallVec<[SonarReading; 32]>;

/// A server information packet. Positions, headings and ranges are in units of the base.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Information {
    /// True if the wheels turn.
    pub moving: bool,
    /// Position since the session began or the origin was set. Counters that wrap: see
    /// [`Unwrapped`](super::units::Unwrapped).
    pub x: u16,
    /// As `x`, to the left.
    pub y: u16,
    /// Heading, counter-clockwise.
    pub heading: i16,
    /// Speed of the left wheel.
    pub left_speed: i16,
    /// Speed of the right wheel.
    pub right_speed: i16,
    /// Battery, 0.1 V.
    pub battery: u8,
    /// Left wheel and rear bumpers: [`touch`].
    pub left: u8,
    /// Right wheel and front bumpers: [`touch`].
    pub right: u8,
    /// The heading that the base tries to keep.
    pub control: i16,
    /// State of motors, sonars and buttons: [`flags`].
    pub flags: u16,
    /// Compass, 2°.
    pub compass: u8,
    /// The readings that are new, a few in each packet.
    pub sonars: SonarReadings,
    /// What only newer bases say.
    pub more: Option<More>,
}

/// Analogue and digital lines, and what newer bases append to that.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct More {
    /// State of a gripper.
    pub gripper: u8,
    /// The analogue line that was selected.
    pub analogue_line: u8,
    /// Its voltage, 5/255 V.
    pub analogue: u8,
    /// Digital inputs.
    pub inputs: u8,
    /// Digital outputs.
    pub outputs: u8,
    /// Battery, 0.1 V: for bases of more than 25 V.
    pub battery: Option<u16>,
    /// 0 not charging, 1 bulk, 2 overcharge, 3 float.
    pub charging: Option<u8>,
    /// Turn rate, 0.1 °/s.
    pub turn_rate: Option<i16>,
}

impl Information {
    /// True if a wheel stalls.
    #[must_use]
    pub fn stalls(&self) -> bool {
        (self.left | self.right) & touch::STALL != 0
    }

    /// True if any bumper is pressed.
    #[must_use]
    pub fn bumps(&self) -> bool {
        (self.left | self.right) & touch::BUMPERS != 0
    }

    /// True if a frame is such a packet.
    #[must_use]
    pub fn is_in(frame: Frame<'_>) -> bool {
        matches!(frame.kind, STANDING | MOVING)
    }

    /// Understands a frame.
    ///
    /// # Errors
    /// If it is of another kind or too short.
    pub fn parse(frame: Frame<'_>) -> Result<Self, PacketError> {
        if !Self::is_in(frame) {
            return Err(PacketError::OtherKind { found: frame.kind, wanted: "server information" });
        }
        let mut fields = Fields(frame.body);
        let mut packet = Self {
            moving: frame.kind == MOVING,
            x: fields.u16("x")?,
            y: fields.u16("y")?,
            heading: fields.i16("heading")?,
            left_speed: fields.i16("speed of the left wheel")?,
            right_speed: fields.i16("speed of the right wheel")?,
            battery: fields.u8("battery")?,
            left: fields.u8("left stall and bumpers")?,
            right: fields.u8("right stall and bumpers")?,
            control: fields.i16("control")?,
            flags: fields.u16("flags")?,
            compass: fields.u8("compass")?,
            ..Self::default()
        };
        for _ in 0..fields.u8("number of sonar readings")? {
            packet.sonars.push(SonarReading { transducer: fields.u8("transducer")?, range: fields.u16("range")? });
        }
        if !fields.is_empty() {
            packet.more = Some(More::parse(&mut fields)?);
        }
        Ok(packet)
    }

    /// Appends the frame. Readings for which there is no room are left out.
    pub fn emit(&self, into: &mut Vec<u8>) {
        let sonars = &self.sonars[..self.sonars.len().min(ROOM_FOR_SONARS)];
        let mut body = Vec::with_capacity(frame::MOST);
        for number in [self.x, self.y, self.heading.cast_unsigned(), self.left_speed.cast_unsigned()] {
            body.extend(number.to_le_bytes());
        }
        body.extend(self.right_speed.to_le_bytes());
        body.extend([self.battery, self.left, self.right]);
        body.extend(self.control.to_le_bytes());
        body.extend(self.flags.to_le_bytes());
        // At most 56.
        #[allow(clippy::cast_possible_truncation)]
        body.extend([self.compass, sonars.len() as u8]);
        for reading in sonars {
            body.push(reading.transducer);
            body.extend(reading.range.to_le_bytes());
        }
        if let Some(more) = &self.more {
            more.emit(&mut body);
        }
        frame::emit(if self.moving { MOVING } else { STANDING }, &body, into);
    }
}

impl More {
    fn parse(fields: &mut Fields<'_>) -> Result<Self, PacketError> {
        let mut more = Self {
            gripper: fields.u8("gripper")?,
            analogue_line: fields.u8("analogue line")?,
            analogue: fields.u8("analogue voltage")?,
            inputs: fields.u8("digital inputs")?,
            outputs: fields.u8("digital outputs")?,
            ..Self::default()
        };
        // One base stops after one field and the next after another; none leaves one out and sends the next.
        if !fields.is_empty() {
            more.battery = Some(fields.u16("battery of more than 25 V")?);
        }
        if !fields.is_empty() {
            more.charging = Some(fields.u8("state of charging")?);
        }
        if !fields.is_empty() {
            more.turn_rate = Some(fields.i16("turn rate")?);
        }
        Ok(more)
    }

    fn emit(&self, body: &mut Vec<u8>) {
        body.extend([self.gripper, self.analogue_line, self.analogue, self.inputs, self.outputs]);
        let Some(battery) = self.battery else { return };
        body.extend(battery.to_le_bytes());
        let Some(charging) = self.charging else { return };
        body.push(charging);
        let Some(turn_rate) = self.turn_rate else { return };
        body.extend(turn_rate.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    /// A standing Pioneer 3 with two readings, field by field as the manual lists them.
    const STANDARD: [u8; 27] = [
        0x01, 0x80, 0xFF, 0x7F, 0x00, 0xFC, 0xF6, 0xFF, 0x0A, 0x00, 128, 0x00, 0x04, 0x10, 0x00, 0x1F, 0x00, 90, 2, //
        0, 0x10, 0x27, 15, 0x88, 0x13, 9, 9,
    ];

    #[test]
    fn the_fields_lie_where_the_manual_says() {
        let packet = Information::parse(Frame { kind: 0x32, body: &STANDARD[..25] });
        let sonars = [SonarReading { transducer: 0, range: 10_000 }, SonarReading { transducer: 15, range: 5_000 }];
        let expected = Information {
            moving: false,
            x: 0x8001,
            y: 0x7FFF,
            heading: -1024,
            left_speed: -10,
            right_speed: 10,
            battery: 128,
            left: 0,
            right: 4,
            control: 16,
            flags: flags::MOTORS | flags::SONARS,
            compass: 90,
            sonars: sonars.into_iter().collect(),
            more: None,
        };
        assert!(expected.bumps() && !expected.stalls());
        assert_eq!(packet, Ok(expected));
    }

    #[test]
    fn what_is_cut_off_says_where() {
        for length in 0..STANDARD.len() {
            let packet = Information::parse(Frame { kind: 0x33, body: &STANDARD[..length] });
            assert_eq!(packet.is_ok(), length == 25, "{length}: {packet:?}");
        }
    }

    prop_compose! {
        fn more()(lines: [u8; 5], battery: Option<u16>, charging: Option<u8>, turn_rate: Option<i16>) -> More {
            let [gripper, analogue_line, analogue, inputs, outputs] = lines;
            let charging = charging.filter(|_| battery.is_some());
            let turn_rate = turn_rate.filter(|_| charging.is_some());
            More { gripper, analogue_line, analogue, inputs, outputs, battery, charging, turn_rate }
        }
    }

    prop_compose! {
        fn information()(
            moving: bool,
            words: [u16; 7],
            bytes: [u8; 4],
            sonars in vec(any::<(u8, u16)>(), 0..=ROOM_FOR_SONARS),
            more in proptest::option::of(more()),
        ) -> Information {
            let [x, y, heading, left_speed, right_speed, control, flags] = words;
            let [battery, left, right, compass] = bytes;
            Information {
                moving,
                x,
                y,
                heading: heading.cast_signed(),
                left_speed: left_speed.cast_signed(),
                right_speed: right_speed.cast_signed(),
                battery,
                left,
                right,
                control: control.cast_signed(),
                flags,
                compass,
                sonars: sonars.into_iter().map(|(transducer, range)| SonarReading { transducer, range }).collect(),
                more,
            }
        }
    }

    proptest! {
        #[test]
        fn packets_come_back(packet in information()) {
            let mut bytes = Vec::new();
            packet.emit(&mut bytes);
            prop_assert_eq!(frame::each(&bytes, Information::parse), [Ok(packet)]);
        }

        #[test]
        fn nonsense_is_refused_and_not_feared(moving: bool, body in vec(any::<u8>(), 0..199)) {
            let _ = Information::parse(Frame { kind: if moving { MOVING } else { STANDING }, body: &body });
        }
    }
}
