//! Frames for the rare control messages between processes.
//!
//! ```text
//! offset  0       4          6        8            12         16
//!         "ORNT"  version    kind     length       checksum   body
//!                 u16        u16      u32          u32        `length` bytes
//! ```
//!
//! All numbers are little-endian. The body is the message as bincode encodes it with integers of
//! fixed size, at most [`MAX_BODY`] bytes; the
//! checksum is the CRC-32 (IEEE 802.3) of the twelve bytes before it and of the body. `kind` is the message type's
//! [`Message::KIND`]. A frame must be exactly as long as it says.
//!
//! bincode encodes no field names: a message type is a plain struct or enum without serde's `tag`, `untagged`, `flatten` or
//! `skip_serializing_if`, and [`VERSION`] counts up with every change to one.

use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use serde::{Serialize, de::DeserializeOwned};
use thiserror::Error;

/// Begins every frame.
pub const MAGIC: [u8; 4] = *b"ORNT";
/// Of the frame and of all messages together.
pub const VERSION: u16 = 1;
/// Bytes before the body.
pub const HEADER: usize = 16;
/// The most bytes of a body.
pub const MAX_BODY: usize = 1 << 20;

/// Without a limit a hostile length makes bincode ask for as much memory as it says. Integers have a fixed size because bincode
/// counts them at their full size against the limit: a body of short integers well below it could be made, but not be read.
const CONFIG: Configuration<LittleEndian, Fixint, Limit<MAX_BODY>> =
    bincode::config::standard().with_fixed_int_encoding().with_limit::<MAX_BODY>();

/// A message that travels in a frame.
pub trait Message: Serialize + DeserializeOwned {
    /// Tells one type of message from another.
    const KIND: u16;
}

/// Why a frame was not made or not accepted.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FrameError {
    /// The message is longer than [`MAX_BODY`], or is of a type that bincode cannot encode.
    #[error("the message cannot be encoded: {0}")]
    Unencodable(String),
    /// Not a frame.
    #[error("this is not a frame of ours")]
    NotAFrame,
    /// From another version of the program.
    #[error("the frame has version {found}, this program speaks version {VERSION}")]
    Version {
        /// The frame's version.
        found: u16,
    },
    /// Shorter or longer than it says, or longer than is allowed.
    #[error("the frame says it has {said} bytes, and there are {found}")]
    Length {
        /// What it says, header included.
        said: u64,
        /// What there is.
        found: usize,
    },
    /// Damaged on the way.
    #[error("the frame's checksum is wrong")]
    Checksum,
    /// Another message than expected.
    #[error("the frame holds a message of kind {found}, not {expected}")]
    Kind {
        /// What it holds.
        found: u16,
        /// What it should hold.
        expected: u16,
    },
    /// The body is whole but does not make sense as this message.
    #[error("the message cannot be decoded: {0}")]
    Undecodable(String),
}

/// Puts a message in a frame.
///
/// # Errors
/// [`FrameError::Unencodable`].
pub fn encode<M: Message>(message: &M) -> Result<Vec<u8>, FrameError> {
    let unencodable = |error: bincode::error::EncodeError| FrameError::Unencodable(error.to_string());
    let mut frame = vec![0; HEADER];
    bincode::serde::encode_into_std_write(message, &mut frame, CONFIG).map_err(unencodable)?;
    let length = frame.len() - HEADER;
    let length = u32::try_from(length)
        .ok()
        .filter(|_| length <= MAX_BODY)
        .ok_or_else(|| FrameError::Unencodable(format!("it has {length} bytes, and {MAX_BODY} are the most")))?;
    frame[..4].copy_from_slice(&MAGIC);
    frame[4..6].copy_from_slice(&VERSION.to_le_bytes());
    frame[6..8].copy_from_slice(&M::KIND.to_le_bytes());
    frame[8..12].copy_from_slice(&length.to_le_bytes());
    let sum = checksum(&frame);
    frame[12..16].copy_from_slice(&sum.to_le_bytes());
    Ok(frame)
}

/// Takes the message out of a frame, or says why it is not to be trusted.
///
/// # Errors
/// Every [`FrameError`] but [`FrameError::Unencodable`].
pub fn decode<M: Message>(frame: &[u8]) -> Result<M, FrameError> {
    let Some((header, body)) = frame.split_first_chunk::<HEADER>() else {
        return Err(FrameError::NotAFrame);
    };
    let [m0, m1, m2, m3, v0, v1, k0, k1, l0, l1, l2, l3, c0, c1, c2, c3] = *header;
    if [m0, m1, m2, m3] != MAGIC {
        return Err(FrameError::NotAFrame);
    }
    let version = u16::from_le_bytes([v0, v1]);
    if version != VERSION {
        return Err(FrameError::Version { found: version });
    }
    let length = u32::from_le_bytes([l0, l1, l2, l3]);
    if usize::try_from(length) != Ok(body.len()) || body.len() > MAX_BODY {
        return Err(FrameError::Length { said: u64::from(length) + HEADER as u64, found: frame.len() });
    }
    if u32::from_le_bytes([c0, c1, c2, c3]) != checksum(frame) {
        return Err(FrameError::Checksum);
    }
    let kind = u16::from_le_bytes([k0, k1]);
    if kind != M::KIND {
        return Err(FrameError::Kind { found: kind, expected: M::KIND });
    }
    match bincode::serde::decode_from_slice(body, CONFIG) {
        Ok((message, used)) if used == body.len() => Ok(message),
        Ok((_, used)) => Err(FrameError::Undecodable(format!("{} bytes are left over", body.len() - used))),
        Err(error) => Err(FrameError::Undecodable(error.to_string())),
    }
}

/// Of everything but the checksum itself.
fn checksum(frame: &[u8]) -> u32 {
    let (header, body) = frame.split_at(HEADER);
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&header[..12]);
    hasher.update(body);
    hasher.finalize()
}
