//! Which packets of sensors there are, and how long they are.

/// A packet with one reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Id {
    /// What presses the bumper, and wheels that hang down.
    BumpsAndDrops = 7,
    /// The wall sensor sees one.
    Wall = 8,
    /// The floor is missing on the left.
    CliffLeft = 9,
    /// The floor is missing at the front, left.
    CliffFrontLeft = 10,
    /// The floor is missing at the front, right.
    CliffFrontRight = 11,
    /// The floor is missing on the right.
    CliffRight = 12,
    /// A virtual wall is seen.
    VirtualWall = 13,
    /// Motors that draw too much.
    Overcurrents = 14,
    /// Dirt; nothing on Create 1.
    Dirt = 15,
    /// Nothing.
    Unused16 = 16,
    /// What the infrared receiver on top hears; 0 or 255 for nothing.
    Infrared = 17,
    /// Buttons that are pressed.
    Buttons = 18,
    /// Way since this was asked for last, mm.
    Distance = 19,
    /// Turn since this was asked for last, °, counter-clockwise.
    Angle = 20,
    /// How it is charged.
    ChargingState = 21,
    /// Voltage of the battery, mV.
    Voltage = 22,
    /// Current into the battery, mA.
    Current = 23,
    /// Temperature of the battery, °C.
    Temperature = 24,
    /// What is in the battery, mAh.
    Charge = 25,
    /// What there is room for in the battery, mAh.
    Capacity = 26,
    /// What the wall sensor sees.
    WallSignal = 27,
    /// What the cliff sensor on the left sees.
    CliffLeftSignal = 28,
    /// What the cliff sensor at the front, left, sees.
    CliffFrontLeftSignal = 29,
    /// What the cliff sensor at the front, right, sees.
    CliffFrontRightSignal = 30,
    /// What the cliff sensor on the right sees.
    CliffRightSignal = 31,
    /// Digital inputs of Create 1; nothing elsewhere.
    Unused32 = 32,
    /// Analogue input of Create 1; nothing elsewhere.
    Unused33 = 33,
    /// Chargers that are there.
    ChargingSources = 34,
    /// The mode.
    Mode = 35,
    /// The song that was chosen last.
    SongNumber = 36,
    /// Whether it is played.
    SongPlays = 37,
    /// Number of packets in the stream.
    StreamPackets = 38,
    /// Velocity of the last Drive, mm/s.
    RequestedVelocity = 39,
    /// Radius of the last Drive, mm.
    RequestedRadius = 40,
    /// Speed that the right wheel was told, mm/s.
    RequestedRight = 41,
    /// Speed that the left wheel was told, mm/s.
    RequestedLeft = 42,
    /// Counts of the left wheel; they wrap.
    LeftEncoder = 43,
    /// Counts of the right wheel; they wrap.
    RightEncoder = 44,
    /// Sectors of the light bumper that see something.
    LightBumper = 45,
    /// What the light bumper sees on the left.
    LightBumpLeft = 46,
    /// What the light bumper sees at the front, left.
    LightBumpFrontLeft = 47,
    /// What the light bumper sees ahead, left.
    LightBumpCenterLeft = 48,
    /// What the light bumper sees ahead, right.
    LightBumpCenterRight = 49,
    /// What the light bumper sees at the front, right.
    LightBumpFrontRight = 50,
    /// What the light bumper sees on the right.
    LightBumpRight = 51,
    /// What the infrared receiver on the left hears.
    InfraredLeft = 52,
    /// What the infrared receiver on the right hears.
    InfraredRight = 53,
    /// Current of the left wheel's motor, mA.
    LeftMotorCurrent = 54,
    /// Current of the right wheel's motor, mA.
    RightMotorCurrent = 55,
    /// Current of the main brush's motor, mA.
    MainBrushCurrent = 56,
    /// Current of the side brush's motor, mA.
    SideBrushCurrent = 57,
    /// Whether the caster at the front turns.
    Stasis = 58,
}

use Id::*;

impl Id {
    /// All of them, by number, without a gap.
    pub const ALL: [Self; 52] = [
        BumpsAndDrops,
        Wall,
        CliffLeft,
        CliffFrontLeft,
        CliffFrontRight,
        CliffRight,
        VirtualWall,
        Overcurrents,
        Dirt,
        Unused16,
        Infrared,
        Buttons,
        Distance,
        Angle,
        ChargingState,
        Voltage,
        Current,
        Temperature,
        Charge,
        Capacity,
        WallSignal,
        CliffLeftSignal,
        CliffFrontLeftSignal,
        CliffFrontRightSignal,
        CliffRightSignal,
        Unused32,
        Unused33,
        ChargingSources,
        Mode,
        SongNumber,
        SongPlays,
        StreamPackets,
        RequestedVelocity,
        RequestedRadius,
        RequestedRight,
        RequestedLeft,
        LeftEncoder,
        RightEncoder,
        LightBumper,
        LightBumpLeft,
        LightBumpFrontLeft,
        LightBumpCenterLeft,
        LightBumpCenterRight,
        LightBumpFrontRight,
        LightBumpRight,
        InfraredLeft,
        InfraredRight,
        LeftMotorCurrent,
        RightMotorCurrent,
        MainBrushCurrent,
        SideBrushCurrent,
        Stasis,
    ];

    /// The packet of this number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        number.checked_sub(BumpsAndDrops as u8).and_then(|i| Self::ALL.get(usize::from(i)).copied())
    }

    /// How long it is, bytes.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Distance | Angle | Voltage | Current | Charge | Capacity | Unused33 => 2,
            WallSignal | CliffLeftSignal | CliffFrontLeftSignal | CliffFrontRightSignal | CliffRightSignal => 2,
            RequestedVelocity | RequestedRadius | RequestedRight | RequestedLeft | LeftEncoder | RightEncoder => 2,
            LightBumpLeft | LightBumpFrontLeft | LightBumpCenterLeft => 2,
            LightBumpCenterRight | LightBumpFrontRight | LightBumpRight => 2,
            LeftMotorCurrent | RightMotorCurrent | MainBrushCurrent | SideBrushCurrent => 2,
            _ => 1,
        }
    }
}

/// The packets of which a packet or a group consists, in their order; `None` for a number that is neither.
///
/// ```
/// use orienteer_hardware::wire::oi::packet::{Id, members};
/// assert_eq!(members(43), Some(&[Id::LeftEncoder][..]));
/// assert_eq!(members(2).map(|group| group.len()), Some(4));
/// assert_eq!(members(59), None);
/// ```
#[must_use]
pub fn members(number: u8) -> Option<&'static [Id]> {
    let (first, last): (u8, u8) = match number {
        0 => (7, 26),
        1 => (7, 16),
        2 => (17, 20),
        3 => (21, 26),
        4 => (27, 34),
        5 => (35, 42),
        6 => (7, 42),
        7..=58 => (number, number),
        100 => (7, 58),
        101 => (43, 58),
        106 => (46, 51),
        107 => (54, 58),
        _ => return None,
    };
    let place = |number: u8| usize::from(number - BumpsAndDrops as u8);
    Id::ALL.get(place(first)..=place(last))
}

/// How long a packet or a group is, bytes; `None` for a number that is neither.
#[must_use]
pub fn size(number: u8) -> Option<usize> {
    members(number).map(|members| members.iter().map(|id| id.size()).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_packet_has_its_number() {
        for (number, id) in (7..).zip(Id::ALL) {
            assert_eq!((id as u8, Id::from_number(number)), (number, Some(id)));
        }
        assert_eq!([0, 6, 59, 255].map(Id::from_number), [None; 4]);
    }

    /// From the tables of groups in both specifications.
    #[test]
    fn groups_are_as_long_as_the_specifications_say() {
        let groups = [(0, 26), (1, 10), (2, 6), (3, 10), (4, 14), (5, 12), (6, 52), (100, 80), (101, 28), (106, 12), (107, 9)];
        for (group, long) in groups {
            assert_eq!(size(group), Some(long), "{group}");
        }
        let known = (0..=255).filter(|number| size(*number).is_some()).count();
        assert_eq!(known, groups.len() + Id::ALL.len());
    }
}
