//! How a session begins.
//!
//! The client sends SYNC0, SYNC1 and SYNC2; the base answers each with the same, and the last with its name behind it. As frames
//! they are commands 0, 1 and 2 without argument: only the state of the session tells them from PULSE, OPEN and CLOSE.

use super::frame::{self, Frame};
use crate::wire::{PacketError, fields::Fields};

/// Appends the client's SYNC of this number, 0 to 2, or the base's answer to the first two.
pub fn emit_sync(number: u8, into: &mut Vec<u8>) {
    frame::emit(number, &[], into);
}

/// Who answers: three names, as the base has them in its memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Greeting {
    /// The name of this very robot, as its owner chose it.
    pub name: String,
    /// Its class: `Pioneer` and the like.
    pub class: String,
    /// Its model: `p3dx-sh` and the like. It says what the [`units`](super::units) are.
    pub model: String,
}

impl Greeting {
    /// Understands the answer to SYNC2.
    ///
    /// # Errors
    /// If it is another packet, or a name is missing.
    pub fn parse(frame: Frame<'_>) -> Result<Self, PacketError> {
        if frame.kind != 2 {
            return Err(PacketError::OtherKind { found: frame.kind, wanted: "the answer to SYNC2" });
        }
        let mut fields = Fields(frame.body);
        let mut name = |field| fields.text(field).map(|text| String::from_utf8_lossy(text).into_owned());
        Ok(Self { name: name("name")?, class: name("class")?, model: name("model")? })
    }

    /// Appends the frame of the answer to SYNC2. Each name goes up to its first zero, and 60 bytes of it at most.
    pub fn emit(&self, into: &mut Vec<u8>) {
        let mut body = Vec::new();
        for name in [&self.name, &self.class, &self.model] {
            body.extend(name.bytes().take(60).take_while(|byte| *byte != 0));
            body.push(0);
        }
        frame::emit(2, &body, into);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back() {
        let greeting = Greeting { name: "Lenny_4031".into(), class: "Pioneer".into(), model: "p3dx-sh".into() };
        let mut bytes = Vec::new();
        emit_sync(1, &mut bytes);
        greeting.emit(&mut bytes);
        let other = PacketError::OtherKind { found: 1, wanted: "the answer to SYNC2" };
        assert_eq!(frame::each(&bytes, Greeting::parse), [Err(other), Ok(greeting)]);
    }

    #[test]
    fn the_echo_of_a_loose_cable_is_no_greeting() {
        let mut bytes = Vec::new();
        emit_sync(2, &mut bytes);
        assert_eq!(frame::each(&bytes, Greeting::parse), [Err(PacketError::TooShort { field: "name" })]);
    }
}
