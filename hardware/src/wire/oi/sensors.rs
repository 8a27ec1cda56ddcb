//! What the packets of sensors say.

use super::packet::Id;
use crate::wire::{PacketError, fields::Fields};

/// What the base does with commands, and with itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// It listens to nothing but Start.
    #[default]
    Off = 0,
    /// It tells what it senses, and does not obey. Its buttons work.
    Passive = 1,
    /// It obeys, and goes to Passive by itself when a wheel drops, a cliff opens ahead, or it is charged.
    Safe = 2,
    /// It obeys, whatever happens to it.
    Full = 3,
}

impl Mode {
    fn from_number(number: u8) -> Result<Self, PacketError> {
        Ok(match number {
            0 => Self::Off,
            1 => Self::Passive,
            2 => Self::Safe,
            3 => Self::Full,
            _ => return Err(PacketError::BadValue { field: "the mode", value: number.into() }),
        })
    }

    /// True if the base moves as it is told.
    #[must_use]
    pub fn obeys(self) -> bool {
        matches!(self, Self::Safe | Self::Full)
    }
}

/// Bits of [`Sensors::bumps_and_drops`].
pub mod bumps {
    /// The right half of the bumper is pressed.
    pub const RIGHT: u8 = 1;
    /// The left half of the bumper is pressed. Both are by what is straight ahead.
    pub const LEFT: u8 = 1 << 1;
    /// A wheel hangs down: the right one, the left one, or the caster of Create 1.
    pub const DROPS: u8 = 0b1_1100;
    /// The right wheel hangs down.
    pub const RIGHT_DROP: u8 = 1 << 2;
    /// The left wheel hangs down.
    pub const LEFT_DROP: u8 = 1 << 3;
}

/// Bits of [`Sensors::overcurrents`]. Below them are brushes, or the outputs of Create 1.
pub mod overcurrents {
    /// The right wheel's motor.
    pub const RIGHT: u8 = 1 << 3;
    /// The left wheel's motor.
    pub const LEFT: u8 = 1 << 4;
}

/// Values of [`Sensors::stasis`].
pub mod stasis {
    /// The caster turns as it does when the base goes ahead. It never does when it turns, goes back or stands.
    pub const GOES_AHEAD: u8 = 1;
    /// The caster is too dirty to be seen.
    pub const DIRTY: u8 = 2;
}

/// The newest reading of every packet; what was never heard is 0. Those of one row stand in the order of their packets.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sensors {
    /// [`bumps`].
    pub bumps_and_drops: u8,
    /// The wall sensor sees one.
    pub wall: bool,
    /// The floor is missing: left, front left, front right, right.
    pub cliffs: [bool; 4],
    /// A virtual wall is seen.
    pub virtual_wall: bool,
    /// [`overcurrents`].
    pub overcurrents: u8,
    /// Dirt, 0 to 255.
    pub dirt: u8,
    /// What is heard on top, on the left and on the right.
    pub infrared: [u8; 3],
    /// Buttons, one bit each.
    pub buttons: u8,
    /// Way since it was asked for last, mm.
    pub distance: i16,
    /// Turn since it was asked for last, °, counter-clockwise.
    pub angle: i16,
    /// 0 not charging, 1 reconditioning, 2 full, 3 trickle, 4 waiting, 5 fault.
    pub charging: u8,
    /// Battery, mV.
    pub voltage: u16,
    /// Into the battery, mA.
    pub current: i16,
    /// Battery, °C.
    pub temperature: i8,
    /// In the battery, mAh.
    pub charge: u16,
    /// That the battery holds when it is full, mAh.
    pub capacity: u16,
    /// What the wall sensor sees.
    pub wall_signal: u16,
    /// What the cliff sensors see: left, front left, front right, right.
    pub cliff_signals: [u16; 4],
    /// Digital inputs of Create 1.
    pub inputs: u8,
    /// Analogue input of Create 1.
    pub analogue: u16,
    /// Chargers that are there: 1 the internal one, 2 the home base.
    pub charging_sources: u8,
    /// Its mode.
    pub mode: Mode,
    /// The song that was chosen last.
    pub song: u8,
    /// It is played.
    pub song_plays: bool,
    /// Number of packets in the stream.
    pub stream_packets: u8,
    /// Of the last Drive, mm/s.
    pub requested_velocity: i16,
    /// Of the last Drive, mm.
    pub requested_radius: i16,
    /// Of the right wheel, mm/s.
    pub requested_right: i16,
    /// Of the left wheel, mm/s.
    pub requested_left: i16,
    /// Counts of the left wheel; they wrap.
    pub left_encoder: u16,
    /// Counts of the right wheel; they wrap.
    pub right_encoder: u16,
    /// Sectors that see something, the left one at bit 0.
    pub light_bumper: u8,
    /// What the sectors see, from left to right.
    pub light_bumps: [u16; 6],
    /// Of the motors of the left and the right wheel, the main and the side brush, mA.
    pub motor_currents: [i16; 4],
    /// [`stasis`].
    pub stasis: u8,
}

impl Sensors {
    /// True if the bumper is pressed anywhere.
    #[must_use]
    pub fn bumps(&self) -> bool {
        self.bumps_and_drops & (bumps::LEFT | bumps::RIGHT) != 0
    }

    /// True if a wheel hangs down.
    #[must_use]
    pub fn drops(&self) -> bool {
        self.bumps_and_drops & bumps::DROPS != 0
    }

    /// True if the floor is missing anywhere.
    #[must_use]
    pub fn cliff(&self) -> bool {
        self.cliffs.contains(&true)
    }

    /// True if the motor of either wheel draws too much.
    #[must_use]
    pub fn overloaded(&self) -> bool {
        self.overcurrents & (overcurrents::LEFT | overcurrents::RIGHT) != 0
    }

    /// Takes in what these packets say, one behind the other.
    ///
    /// # Errors
    /// If they end too early, go on behind the last, or one says what can't be. Then nothing is taken in.
    pub fn read(&mut self, packets: &[Id], bytes: &[u8]) -> Result<(), PacketError> {
        let (mut read, mut fields) = (*self, Fields(bytes));
        for id in packets {
            read.take(*id, &mut fields)?;
        }
        if let [first, ..] = fields.0 {
            return Err(PacketError::BadValue { field: "what follows the last packet", value: (*first).into() });
        }
        *self = read;
        Ok(())
    }
}

/// A number as it goes over the wire.
trait Number: Sized {
    fn read(fields: &mut Fields<'_>, what: &'static str) -> Result<Self, PacketError>;
    fn write(self, into: &mut Vec<u8>);
}

/// Numbers of more than a byte begin with the high one.
macro_rules! number {
    ($($number:ty: $read:ident),+) => {
        $(impl Number for $number {
            fn read(fields: &mut Fields<'_>, what: &'static str) -> Result<Self, PacketError> {
                fields.$read(what)
            }
            fn write(self, into: &mut Vec<u8>) {
                into.extend(self.to_be_bytes());
            }
        })+
    };
}

number!(u8: u8, i8: i8, u16: u16_be, i16: i16_be);

/// Flags have a byte each, of which the lowest bit counts.
impl Number for bool {
    fn read(fields: &mut Fields<'_>, what: &'static str) -> Result<Self, PacketError> {
        Ok(fields.u8(what)? & 1 != 0)
    }

    fn write(self, into: &mut Vec<u8>) {
        into.push(self.into());
    }
}

impl Number for Mode {
    fn read(fields: &mut Fields<'_>, what: &'static str) -> Result<Self, PacketError> {
        Self::from_number(fields.u8(what)?)
    }

    fn write(self, into: &mut Vec<u8>) {
        into.push(self as u8);
    }
}

/// Makes both directions of one list of packets: where in [`Sensors`] each belongs, and what people call it.
macro_rules! packets {
    ($($id:ident: $place:ident $([$index:literal])?, $what:literal;)+) => {
        impl Sensors {
            fn take(&mut self, id: Id, fields: &mut Fields<'_>) -> Result<(), PacketError> {
                match id {
                    $(Id::$id => self.$place $([$index])? = Number::read(fields, $what)?,)+
                    Id::Unused16 => fields.skip(1, "unused packet")?,
                }
                Ok(())
            }

            /// Appends what a packet says.
            pub fn emit(&self, id: Id, into: &mut Vec<u8>) {
                match id {
                    $(Id::$id => self.$place $([$index])?.write(into),)+
                    Id::Unused16 => into.push(0),
                }
            }
        }
    };
}

packets! {
    BumpsAndDrops: bumps_and_drops, "bumps and drops";
    Wall: wall, "wall";
    CliffLeft: cliffs[0], "cliff on the left";
    CliffFrontLeft: cliffs[1], "cliff on the front left";
    CliffFrontRight: cliffs[2], "cliff on the front right";
    CliffRight: cliffs[3], "cliff on the right";
    VirtualWall: virtual_wall, "virtual wall";
    Overcurrents: overcurrents, "overcurrents";
    Dirt: dirt, "dirt";
    Infrared: infrared[0], "infrared";
    Buttons: buttons, "buttons";
    Distance: distance, "distance";
    Angle: angle, "angle";
    ChargingState: charging, "state of charging";
    Voltage: voltage, "voltage";
    Current: current, "current";
    Temperature: temperature, "temperature";
    Charge: charge, "charge";
    Capacity: capacity, "capacity";
    WallSignal: wall_signal, "wall signal";
    CliffLeftSignal: cliff_signals[0], "cliff signal";
    CliffFrontLeftSignal: cliff_signals[1], "cliff signal";
    CliffFrontRightSignal: cliff_signals[2], "cliff signal";
    CliffRightSignal: cliff_signals[3], "cliff signal";
    Unused32: inputs, "digital inputs";
    Unused33: analogue, "analogue input";
    ChargingSources: charging_sources, "chargers";
    Mode: mode, "mode";
    SongNumber: song, "song";
    SongPlays: song_plays, "song that plays";
    StreamPackets: stream_packets, "packets of the stream";
    RequestedVelocity: requested_velocity, "requested velocity";
    RequestedRadius: requested_radius, "requested radius";
    RequestedRight: requested_right, "requested speed";
    RequestedLeft: requested_left, "requested speed";
    LeftEncoder: left_encoder, "left encoder";
    RightEncoder: right_encoder, "right encoder";
    LightBumper: light_bumper, "light bumper";
    LightBumpLeft: light_bumps[0], "light bump";
    LightBumpFrontLeft: light_bumps[1], "light bump";
    LightBumpCenterLeft: light_bumps[2], "light bump";
    LightBumpCenterRight: light_bumps[3], "light bump";
    LightBumpFrontRight: light_bumps[4], "light bump";
    LightBumpRight: light_bumps[5], "light bump";
    InfraredLeft: infrared[1], "infrared";
    InfraredRight: infrared[2], "infrared";
    LeftMotorCurrent: motor_currents[0], "motor current";
    RightMotorCurrent: motor_currents[1], "motor current";
    MainBrushCurrent: motor_currents[2], "motor current";
    SideBrushCurrent: motor_currents[3], "motor current";
    Stasis: stasis, "stasis";
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;
    use crate::wire::oi::packet::members;

    /// Group 100 of a base that stands, as its table in the specification lists it: only what differs from 0.
    #[test]
    fn the_packets_of_a_group_lie_where_the_specification_says() {
        let mut bytes = [0; 80];
        for (place, byte) in [(0, 0b1011), (4, 1), (7, 0x18), (12, 0xFF), (13, 0x9C), (15, 90), (17, 0x38), (18, 0x40)] {
            bytes[place] = byte;
        }
        for (place, byte) in [(21, 0xFB), (36, 5), (40, 2), (51, 200), (52, 0xFF), (53, 0xFE), (55, 3), (79, 1)] {
            bytes[place] = byte;
        }
        let mut sensors = Sensors::default();
        assert_eq!(sensors.read(members(100).unwrap_or_default(), &bytes), Ok(()));
        let expected = Sensors {
            bumps_and_drops: bumps::LEFT | bumps::RIGHT | bumps::LEFT_DROP,
            cliffs: [false, false, true, false],
            overcurrents: overcurrents::LEFT | overcurrents::RIGHT,
            distance: -100,
            angle: 90,
            voltage: 14_400,
            temperature: -5,
            inputs: 5,
            mode: Mode::Safe,
            requested_left: 200,
            left_encoder: 65_534,
            right_encoder: 3,
            stasis: stasis::GOES_AHEAD,
            ..Sensors::default()
        };
        assert_eq!(sensors, expected);
        assert!(sensors.bumps() && sensors.drops() && sensors.cliff() && sensors.overloaded() && sensors.mode.obeys());
    }

    #[test]
    fn what_is_cut_off_or_goes_on_changes_nothing() {
        let ids = [Id::Mode, Id::Voltage];
        for bytes in [&[2][..], &[2, 0x38], &[2, 0x38, 0x40, 0], &[4, 0x38, 0x40], &[]] {
            let mut sensors = Sensors::default();
            assert!(sensors.read(&ids, bytes).is_err(), "{bytes:?}");
            assert_eq!(sensors, Sensors::default());
        }
    }

    proptest! {
        /// Whatever packets say is said again in the same bytes, but for the bits that no flag and no packet has.
        #[test]
        fn packets_come_back(places in vec(0..Id::ALL.len(), 1..60), noise in vec(any::<u8>(), 120)) {
            let ids: Vec<Id> = places.iter().map(|place| Id::ALL[*place]).collect();
            let size: usize = ids.iter().map(|id| id.size()).sum();
            let mut sensors = Sensors::default();
            let mut bytes = noise[..size].to_vec();
            let mut at = 0;
            for id in &ids {
                bytes[at] &= if *id == Id::Mode { 3 } else { 0xFF };
                at += id.size();
            }
            prop_assert_eq!(sensors.read(&ids, &bytes), Ok(()));
            let mut again = Vec::new();
            ids.iter().for_each(|id| sensors.emit(*id, &mut again));
            prop_assert_eq!(again.len(), size);
            let mut read = Sensors::default();
            prop_assert_eq!(read.read(&ids, &again), Ok(()));
            prop_assert_eq!(read, sensors);
        }

        /// Each packet by itself: all that it says is kept.
        #[test]
        fn every_bit_of_a_number_counts(place in 0..Id::ALL.len(), noise: [u8; 2]) {
            let id = Id::ALL[place];
            let flags = [Id::Wall, Id::CliffLeft, Id::CliffFrontLeft, Id::CliffFrontRight, Id::CliffRight, Id::VirtualWall];
            let mask = match id {
                Id::Unused16 => 0,
                Id::Mode => 3,
                Id::SongPlays => 1,
                id if flags.contains(&id) => 1,
                _ => 0xFF,
            };
            let bytes = [noise[0] & mask, noise[1]];
            let (mut sensors, mut again) = (Sensors::default(), Vec::new());
            prop_assert_eq!(sensors.read(&[id], &bytes[..id.size()]), Ok(()));
            sensors.emit(id, &mut again);
            prop_assert_eq!(&again[..], &bytes[..id.size()]);
        }

        #[test]
        fn nonsense_is_refused_and_not_feared(places in vec(0..Id::ALL.len(), 0..60), noise in vec(any::<u8>(), 0..120)) {
            let ids: Vec<Id> = places.iter().map(|place| Id::ALL[*place]).collect();
            let _ = Sensors::default().read(&ids, &noise);
        }
    }
}
