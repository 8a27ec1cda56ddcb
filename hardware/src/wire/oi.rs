//! OI, the Open Interface of iRobot's Create and Roomba.
//!
//! | direction | what | where |
//! |---|---|---|
//! | to the base | commands, one after the other with nothing between them | [`command`] |
//! | from the base | which packets of sensors there are, and how long they are | [`packet`] |
//! | from the base | what they say | [`sensors`] |
//! | from the base | frames of packets, each 15 ms, once they are asked for | [`stream`] |
//! | – | what a count of a wheel is worth, model by model | [`units`] |
//!
//! Numbers are big-endian. Commands have no checksum and no end: how long one is follows from its first byte, so one that was cut off
//! swallows the beginning of the next. Only frames of the stream can be told from noise; answers to single questions are bytes that
//! mean what was asked for.
//!
//! The base is in one of four [modes](sensors::Mode). It moves only in Safe and Full. In Safe it stops and goes back to Passive by
//! itself when a wheel drops or a cliff opens ahead, or when it is charged. **It has no watchdog**: with the last speed that it was told
//! it goes on for ever.
//!
//! Sources: iRobot Create Open Interface (2006) for Create 1; iRobot Create 2 Open Interface Specification based on the Roomba 600
//! (2018) for everything newer. Where they contradict each other, the behaviour of libcreate, a client that drives both.
//!
//! ```
//! use orienteer_hardware::wire::oi::{STOP, command::{Command, Listener}};
//!
//! let mut bytes = vec![0xFF];
//! Command::DriveDirect { right: -200, left: 200 }.emit(&mut bytes);
//! assert_eq!(bytes[1..], [145, 0xFF, 0x38, 0x00, 0xC8]);
//! bytes.extend(STOP);
//!
//! let (mut listener, mut heard) = (Listener::default(), Vec::new());
//! listener.push(&bytes, |command| heard.push(format!("{command:?}")));
//! assert_eq!(heard, ["DriveDirect { right: -200, left: 200 }", "DriveDirect { right: 0, left: 0 }"]);
//! assert_eq!((listener.counts().frames, listener.counts().noise), (2, 1));
//! ```

pub mod command;
pub mod packet;
pub mod sensors;
pub mod stream;
pub mod units;

/// The bytes that stop the base: Drive Direct with both wheels at 0.
pub const STOP: [u8; 5] = [145, 0, 0, 0, 0];

/// The longest command that drivers here send has this many bytes behind its first, or fewer.
const LONGEST_REST: usize = 16;

/// [`STOP`] for whoever does not know what was said before: with zeros ahead, which no command begins with, so that one that was cut off
/// has something to swallow.
pub const STOP_ANYHOW: [u8; LONGEST_REST + STOP.len()] = {
    let mut bytes = [0; LONGEST_REST + STOP.len()];
    bytes[LONGEST_REST] = STOP[0];
    bytes
};
