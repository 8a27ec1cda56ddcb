//! What a client tells the base.
//!
//! A command is an opcode and arguments, whose number follows from the opcode, for some from the first or second argument. There is no
//! checksum: whatever noise looks like a command is one. Bytes that are no opcode are passed over.

use crate::wire::{Counts, PacketError, fields::Fields};

/// The greatest speed of a wheel, mm/s; what is beyond means this.
pub const TOP_SPEED: i16 = 500;
/// The radius that means straight on; so does the one below it.
pub const STRAIGHT: i16 = i16::MIN;
/// Songs are no longer than this, notes.
pub const LONGEST_SONG: usize = 16;
/// The longest command: an opcode, a number, and as many packets as it says.
const LONGEST: usize = 2 + u8::MAX as usize;

/// A command.
///
/// What no driver or emulator here has a use for is [`Other`](Self::Other): it must be known by its length all the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command<'a> {
    /// 7: begin as if the battery had been put in.
    Reset,
    /// 128: begin to listen; to Passive.
    Start,
    /// 129: speed of the serial port, 0 to 11 for 300 to 115200 baud.
    Baud(u8),
    /// 131: to Safe. 130, its older name, means the same.
    Safe,
    /// 132: to Full.
    Full,
    /// 133: switch off the lights; to Passive.
    Power,
    /// 134: clean a spot; to Passive.
    Spot,
    /// 135: clean; to Passive.
    Clean,
    /// 136: clean until the battery is empty; to Passive.
    Max,
    /// 137: drive along a circle.
    Drive {
        /// Speed of its middle, mm/s, at most [`TOP_SPEED`].
        velocity: i16,
        /// mm, at most 2000, the centre to the left if positive; 1 and -1 turn on the spot, [`STRAIGHT`] does not turn.
        radius: i16,
    },
    /// 139: lights.
    Leds {
        /// Which are on.
        lights: u8,
        /// Of the power light: 0 green to 255 red.
        colour: u8,
        /// Of the power light.
        intensity: u8,
    },
    /// 140: remember a song.
    Song {
        /// Its number.
        number: u8,
        /// Notes as in MIDI, each with its duration in 1/64 s; at most [`LONGEST_SONG`].
        notes: &'a [[u8; 2]],
    },
    /// 141: play the song of this number.
    Play(u8),
    /// 142: send this packet or group once.
    Sensors(u8),
    /// 143: go to the charger; to Passive.
    SeekDock,
    /// 145: speeds of the wheels, mm/s, at most [`TOP_SPEED`].
    DriveDirect {
        /// Right wheel.
        right: i16,
        /// Left wheel.
        left: i16,
    },
    /// 146: duty of the wheels' motors, at most 255.
    DrivePwm {
        /// Right wheel.
        right: i16,
        /// Left wheel.
        left: i16,
    },
    /// 148: send these packets each 15 ms.
    Stream(&'a [u8]),
    /// 149: send these packets once.
    QueryList(&'a [u8]),
    /// 150: pause the stream (`false`), or go on with the one that was asked for last.
    StreamRuns(bool),
    /// 173: stop listening; to Off.
    Stop,
    /// Brushes, digits, schedules, scripts, and what else is on board.
    Other {
        /// Its opcode.
        opcode: u8,
        /// Its arguments.
        arguments: &'a [u8],
    },
}

/// Of how many bytes the arguments of an opcode are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Arguments {
    Fixed(usize),
    /// As many as the first says, behind it.
    Counted,
    /// A number and twice as many as the second says, behind it.
    Notes,
}

/// `None` for what is no opcode. Those of Create 1 alone (147, 151 to 158) are among them; 136 has an argument there, and none anywhere
/// else.
fn arguments(opcode: u8) -> Option<Arguments> {
    Some(match opcode {
        7 | 128 | 130..=136 | 143 | 153 | 154 | 173 => Arguments::Fixed(0),
        129 | 138 | 141 | 142 | 147 | 150 | 151 | 155 | 158 | 165 => Arguments::Fixed(1),
        156 | 157 | 162 => Arguments::Fixed(2),
        139 | 144 | 168 => Arguments::Fixed(3),
        137 | 145 | 146 | 163 | 164 => Arguments::Fixed(4),
        167 => Arguments::Fixed(15),
        148 | 149 | 152 => Arguments::Counted,
        140 => Arguments::Notes,
        _ => return None,
    })
}

impl<'a> Command<'a> {
    /// Appends it. Of lists that are too long the beginning goes.
    pub fn emit(&self, into: &mut Vec<u8>) {
        match *self {
            Self::Reset => into.push(7),
            Self::Start => into.push(128),
            Self::Baud(code) => into.extend([129, code]),
            Self::Safe => into.push(131),
            Self::Full => into.push(132),
            Self::Power => into.push(133),
            Self::Spot => into.push(134),
            Self::Clean => into.push(135),
            Self::Max => into.push(136),
            Self::Drive { velocity, radius } => emit_pair(137, velocity, radius, into),
            Self::Leds { lights, colour, intensity } => into.extend([139, lights, colour, intensity]),
            Self::Song { number, notes } => {
                let notes = &notes[..notes.len().min(LONGEST_SONG)];
                into.extend([140, number, notes.len().to_le_bytes()[0]]);
                into.extend(notes.as_flattened());
            }
            Self::Play(number) => into.extend([141, number]),
            Self::Sensors(packet) => into.extend([142, packet]),
            Self::SeekDock => into.push(143),
            Self::DriveDirect { right, left } => emit_pair(145, right, left, into),
            Self::DrivePwm { right, left } => emit_pair(146, right, left, into),
            Self::Stream(packets) => emit_list(148, packets, into),
            Self::QueryList(packets) => emit_list(149, packets, into),
            Self::StreamRuns(runs) => into.extend([150, u8::from(runs)]),
            Self::Stop => into.push(173),
            Self::Other { opcode, arguments } => {
                into.push(opcode);
                into.extend(arguments);
            }
        }
    }

    /// Understands a whole command.
    ///
    /// # Errors
    /// If its first byte is no opcode, an argument can't be, or there are too few.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, PacketError> {
        let mut fields = Fields(bytes);
        let opcode = fields.u8("opcode")?;
        Ok(match opcode {
            7 => Self::Reset,
            128 => Self::Start,
            129 => Self::Baud(fields.u8("code")?),
            130 | 131 => Self::Safe,
            132 => Self::Full,
            133 => Self::Power,
            134 => Self::Spot,
            135 => Self::Clean,
            136 => Self::Max,
            137 => Self::Drive { velocity: fields.i16_be("velocity")?, radius: fields.i16_be("radius")? },
            139 => Self::Leds { lights: fields.u8("lights")?, colour: fields.u8("colour")?, intensity: fields.u8("intensity")? },
            140 => {
                let number = fields.u8("number of the song")?;
                let count = usize::from(fields.u8("number of notes")?);
                let notes = fields.0.as_chunks::<2>().0.get(..count).ok_or(PacketError::TooShort { field: "notes" })?;
                Self::Song { number, notes }
            }
            141 => Self::Play(fields.u8("number of the song")?),
            142 => Self::Sensors(fields.u8("packet")?),
            143 => Self::SeekDock,
            145 => Self::DriveDirect { right: fields.i16_be("right wheel")?, left: fields.i16_be("left wheel")? },
            146 => Self::DrivePwm { right: fields.i16_be("right wheel")?, left: fields.i16_be("left wheel")? },
            148 => Self::Stream(fields.counted("packets")?),
            149 => Self::QueryList(fields.counted("packets")?),
            150 => match fields.u8("state")? {
                state @ 0..=1 => Self::StreamRuns(state == 1),
                state => return Err(PacketError::BadValue { field: "the stream's state", value: state.into() }),
            },
            173 => Self::Stop,
            _ => match length(bytes) {
                Length::Bytes(length) => {
                    let arguments = bytes.get(1..length).ok_or(PacketError::TooShort { field: "arguments" })?;
                    Self::Other { opcode, arguments }
                }
                Length::Unknown => return Err(PacketError::TooShort { field: "arguments" }),
                Length::None => return Err(PacketError::OtherKind { found: opcode, wanted: "a command" }),
            },
        })
    }
}

fn emit_pair(opcode: u8, first: i16, second: i16, into: &mut Vec<u8>) {
    into.push(opcode);
    into.extend(first.to_be_bytes());
    into.extend(second.to_be_bytes());
}

fn emit_list(opcode: u8, packets: &[u8], into: &mut Vec<u8>) {
    let packets = &packets[..packets.len().min(usize::from(u8::MAX))];
    into.extend([opcode, packets.len().to_le_bytes()[0]]);
    into.extend(packets);
}

/// How long the command is that begins with these bytes, of which there is one at least.
enum Length {
    /// It is none.
    None,
    /// It takes more bytes to say.
    Unknown,
    Bytes(usize),
}

fn length(begun: &[u8]) -> Length {
    match (begun.first().copied().and_then(arguments), begun) {
        (None, _) => Length::None,
        (Some(Arguments::Fixed(count)), _) => Length::Bytes(1 + count),
        (Some(Arguments::Counted), [_, count, ..]) => Length::Bytes(2 + usize::from(*count)),
        // A song that can't be is a false beginning, not a command that swallows half a second of what follows.
        (Some(Arguments::Notes), [_, _, count, ..]) if usize::from(*count) > LONGEST_SONG => Length::None,
        (Some(Arguments::Notes), [_, _, count, ..]) => Length::Bytes(3 + 2 * usize::from(*count)),
        (Some(_), _) => Length::Unknown,
    }
}

/// Finds the commands in a stream of bytes that comes in pieces, as a base does.
#[derive(Debug, Clone)]
pub struct Listener {
    held: [u8; LONGEST],
    len: usize,
    counts: Counts,
}

impl Default for Listener {
    fn default() -> Self {
        Self { held: [0; LONGEST], len: 0, counts: Counts::default() }
    }
}

impl Listener {
    /// Takes in what has come, and shows each command that is complete.
    pub fn push(&mut self, bytes: &[u8], mut show: impl FnMut(Command<'_>)) {
        for byte in bytes {
            self.held[self.len] = *byte;
            self.len += 1;
            // What is complete or none makes room, so that there is always some for the next byte.
            while self.len > 0 {
                match length(&self.held[..self.len]) {
                    Length::None => {
                        self.counts.noise += 1;
                        self.drop_first(1);
                    }
                    Length::Bytes(length) if self.len >= length => {
                        match Command::parse(&self.held[..length]) {
                            Ok(command) => {
                                self.counts.frames += 1;
                                show(command);
                            }
                            Err(_) => self.counts.broken += 1,
                        }
                        self.drop_first(length);
                    }
                    Length::Bytes(_) | Length::Unknown => break,
                }
            }
        }
    }

    /// What it has seen since it was made: commands, commands with an argument that can't be, and bytes that were no command.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    fn drop_first(&mut self, count: usize) {
        self.held.copy_within(count..self.len, 0);
        self.len -= count;
    }
}

#[cfg(test)]
mod tests;
