//! What goes over the wire to real devices: codecs without any I/O, one module for each protocol.
//!
//! A codec turns bytes into typed packets and back. It opens no port, keeps no time and starts nothing: drivers and emulators
//! do, from either end, and with the same types. What comes from a wire may be anything, so no parser panics, and each finds its
//! way back after garbage.

pub mod arcos;
mod fields;
pub mod oi;

/// What somebody who looks for packets in a stream of bytes has seen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Packets that were whole.
    pub frames: u64,
    /// Those of them that told nothing to whoever has read them.
    pub unknown: u64,
    /// What began like one and had a wrong checksum, or something in it that can't be.
    pub broken: u64,
    /// Bytes that belonged to none.
    pub noise: u64,
}

/// A packet that arrived whole and yet can't be understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PacketError {
    /// It ends too early.
    #[error("the packet ends before its {field}")]
    TooShort {
        /// The first field that is not there.
        field: &'static str,
    },
    /// It is a packet of another kind.
    #[error("a packet of kind {found:#04x} where {wanted} was expected")]
    OtherKind {
        /// Its kind.
        found: u8,
        /// What was expected.
        wanted: &'static str,
    },
    /// A field has a value that it can't have.
    #[error("{field} can't be {value:#x}")]
    BadValue {
        /// The field.
        field: &'static str,
        /// Its value.
        value: u32,
    },
}
