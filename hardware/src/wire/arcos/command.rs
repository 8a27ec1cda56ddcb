//! What a client tells the base.
//!
//! Numbers go as a sign and a magnitude: the type of the argument says whether it is positive or negative.

use super::frame::{self, Frame};
use crate::wire::{PacketError, fields::Fields};

/// What is commanded. Units are those of the wire; [`units`](super::units) says what they are worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Code {
    /// Nothing: says that the client is still there. Before a session, SYNC0.
    Pulse = 0,
    /// Begin the session: start the stream of information packets. Before a session, SYNC1.
    Open = 1,
    /// End the session. Before a session, SYNC2.
    Close = 2,
    /// Fire the sonars in this order: one byte each, transducers counted from 1.
    Polling = 3,
    /// Motors on (1) or off (0).
    Enable = 4,
    /// Acceleration, if positive, or deceleration, if negative, mm/s².
    Acceleration = 5,
    /// Greatest speed, mm/s.
    TopSpeed = 6,
    /// Count positions from here.
    Origin = 7,
    /// Drive so far, mm.
    Move = 8,
    /// Greatest turn rate, °/s.
    TopTurnRate = 10,
    /// Drive at this speed, mm/s.
    Velocity = 11,
    /// Turn to this heading, °.
    Heading = 12,
    /// Turn by this, °.
    HeadingChange = 13,
    /// Ask for the [`settings`](super::settings): 1.
    Settings = 18,
    /// Turn at this rate, °/s, counter-clockwise.
    TurnRate = 21,
    /// Angular acceleration, if positive, or deceleration, if negative, °/s².
    AngularAcceleration = 23,
    /// Sonar on (1) or off (0).
    Sonar = 28,
    /// Slow down to a stop.
    Stop = 29,
    /// Speeds of the wheels, each in a byte of its own: see [`Command::wheels`].
    Wheels = 32,
    /// Stall when a bumper is pressed: 0 never, 1 at the front, 2 at the rear, 3 both.
    BumpStall = 44,
    /// Speed of the serial port: 0 to 4 for 9600, 19200, 38400, 57600, 115200 baud.
    Baud = 50,
    /// Stop at once, with no regard to deceleration.
    EmergencyStop = 55,
}

impl Code {
    /// All of them, by number.
    pub const ALL: [Self; 22] = [
        Self::Pulse,
        Self::Open,
        Self::Close,
        Self::Polling,
        Self::Enable,
        Self::Acceleration,
        Self::TopSpeed,
        Self::Origin,
        Self::Move,
        Self::TopTurnRate,
        Self::Velocity,
        Self::Heading,
        Self::HeadingChange,
        Self::Settings,
        Self::TurnRate,
        Self::AngularAcceleration,
        Self::Sonar,
        Self::Stop,
        Self::Wheels,
        Self::BumpStall,
        Self::Baud,
        Self::EmergencyStop,
    ];

    /// The command of this number; `None` for those that no driver or emulator here has a use for.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|code| *code as u8 == number)
    }
}

/// What a command comes with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Argument<'a> {
    /// Nothing.
    None,
    /// A number between -65535 and 65535; what is beyond goes as the nearest of these.
    Integer(i32),
    /// Bytes, 196 at most.
    Text(&'a [u8]),
}

/// A command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Command<'a> {
    /// What.
    pub code: Code,
    /// With what.
    pub argument: Argument<'a>,
}

const POSITIVE: u8 = 0x3B;
const NEGATIVE: u8 = 0x1B;
const TEXT: u8 = 0x2B;
/// What is left of a payload for text, after the kind, the type and the length.
const LONGEST_TEXT: usize = frame::MOST - 3;

impl<'a> Command<'a> {
    /// A command.
    #[must_use]
    pub fn new(code: Code, argument: Argument<'a>) -> Self {
        Self { code, argument }
    }

    /// Speeds of the left and the right wheel, in units of 20 mm/s on most models.
    #[must_use]
    pub fn wheels(left: i8, right: i8) -> Self {
        let word = i16::from_be_bytes([left.cast_unsigned(), right.cast_unsigned()]);
        Self::new(Code::Wheels, Argument::Integer(word.into()))
    }

    /// The speeds in a command of [`wheels`](Self::wheels), left and right.
    #[must_use]
    pub fn as_wheels(&self) -> Option<(i8, i8)> {
        let (Code::Wheels, Argument::Integer(word)) = (self.code, self.argument) else { return None };
        // Its low 16 bits, whether they went as a sign and a magnitude or as they are.
        #[allow(clippy::cast_possible_truncation)]
        let [left, right] = (word as i16).to_be_bytes();
        Some((left.cast_signed(), right.cast_signed()))
    }

    /// Appends the frame.
    pub fn emit(&self, into: &mut Vec<u8>) {
        let mut body = [0; frame::MOST];
        let len = match self.argument {
            Argument::None => 0,
            Argument::Integer(number) => {
                let magnitude = u16::try_from(number.unsigned_abs()).unwrap_or(u16::MAX);
                body[0] = if number < 0 { NEGATIVE } else { POSITIVE };
                body[1..3].copy_from_slice(&magnitude.to_le_bytes());
                3
            }
            Argument::Text(text) => {
                let text = &text[..text.len().min(LONGEST_TEXT)];
                body[0] = TEXT;
                // At most 197.
                #[allow(clippy::cast_possible_truncation)]
                {
                    body[1] = text.len() as u8;
                }
                body[2..2 + text.len()].copy_from_slice(text);
                2 + text.len()
            }
        };
        frame::emit(self.code as u8, &body[..len], into);
    }

    /// Understands a frame.
    ///
    /// # Errors
    /// If it is of no known kind, or its argument of no known type or too short.
    pub fn parse(frame: Frame<'a>) -> Result<Self, PacketError> {
        let code = Code::from_number(frame.kind)
            .ok_or(PacketError::OtherKind { found: frame.kind, wanted: "a command that is known here" })?;
        if frame.body.is_empty() {
            return Ok(Self::new(code, Argument::None));
        }
        let mut fields = Fields(frame.body);
        let kind = fields.u8("argument's type")?;
        let argument = match kind {
            POSITIVE => Argument::Integer(fields.u16("number")?.into()),
            NEGATIVE => Argument::Integer(-i32::from(fields.u16("number")?)),
            TEXT => Argument::Text(fields.counted("text")?),
            _ => return Err(PacketError::BadValue { field: "the argument's type", value: kind.into() }),
        };
        Ok(Self::new(code, argument))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn back(bytes: &[u8]) -> Vec<Result<(Code, String), PacketError>> {
        frame::each(bytes, |frame| Command::parse(frame).map(|command| (command.code, format!("{:?}", command.argument))))
    }

    fn argument() -> impl Strategy<Value = (Option<i32>, Option<Vec<u8>>)> {
        prop_oneof![
            Just((None, None)),
            (-65535i32..=65535).prop_map(|number| (Some(number), None)),
            proptest::collection::vec(any::<u8>(), 0..=LONGEST_TEXT).prop_map(|text| (None, Some(text))),
        ]
    }

    proptest! {
        #[test]
        fn commands_come_back(code in proptest::sample::select(&Code::ALL[..]), (number, text) in argument()) {
            let argument = number.map(Argument::Integer).or(text.as_deref().map(Argument::Text)).unwrap_or(Argument::None);
            let mut bytes = Vec::new();
            Command::new(code, argument).emit(&mut bytes);
            prop_assert_eq!(back(&bytes), [Ok((code, format!("{argument:?}")))]);
        }

        #[test]
        fn wheels_come_back(left: i8, right: i8) {
            let command = Command::wheels(left, right);
            prop_assert_eq!(command.as_wheels(), Some((left, right)));
            // Some clients send the two bytes as they are, as one positive number.
            let raw = i32::from(u16::from_be_bytes([left.cast_unsigned(), right.cast_unsigned()]));
            prop_assert_eq!(Command::new(Code::Wheels, Argument::Integer(raw)).as_wheels(), Some((left, right)));
        }

        #[test]
        fn nonsense_is_refused_and_not_feared(kind: u8, body in proptest::collection::vec(any::<u8>(), 0..12)) {
            let _ = Command::parse(Frame { kind, body: &body });
        }
    }

    #[test]
    fn what_is_too_large_goes_as_the_largest() {
        let mut bytes = Vec::new();
        Command::new(Code::Move, Argument::Integer(-70_000)).emit(&mut bytes);
        assert_eq!(back(&bytes), [Ok((Code::Move, "Integer(-65535)".to_owned()))]);
    }

    #[test]
    fn every_code_has_its_number() {
        assert!(Code::ALL.is_sorted_by_key(|code| *code as u8));
        assert_eq!((Code::from_number(11), Code::from_number(9)), (Some(Code::Velocity), None));
    }
}
