//! ARCOS, the language of Pioneer, AmigoBot and PeopleBot bases (P2OS, AROS and AmigOS speak it, too).
//!
//! | direction | what | where |
//! |---|---|---|
//! | either | frames: `FA FB`, length, payload, checksum | [`frame`] |
//! | to the base | commands | [`command`] |
//! | from the base | its name, when it is greeted | [`greeting`] |
//! | from the base | where it is and what it feels, ten times a second or more often | [`information`] |
//! | from the base | its limits and settings, when it is asked | [`settings`] |
//! | – | what a unit is, model by model, and counters that wrap | [`units`] |
//!
//! A session begins with SYNC0, SYNC1 and SYNC2, each of which the base answers with the same; the last answer carries its name.
//! OPEN starts the stream of information packets. The base stops by itself when it has heard nothing for two seconds (its
//! watchdog), and PULSE says that somebody is still there. Motors are off until ENABLE.
//!
//! Sources: Pioneer 3 Operations Manual (MobileRobots 2006), chapter 6; where it is silent, the behaviour of ARIA, the maker's
//! own client library.
//!
//! ```
//! use orienteer_hardware::wire::arcos::{command::{Argument, Code, Command}, frame::Framer};
//!
//! let mut bytes = Vec::new();
//! Command::new(Code::Velocity, Argument::Integer(-200)).emit(&mut bytes);
//! assert_eq!(bytes, [0xFA, 0xFB, 0x06, 0x0B, 0x1B, 0xC8, 0x00, 0xD3, 0x1B]);
//!
//! let mut framer = Framer::default();
//! framer.push(&[0x00, 0xFA, 0x17], |_| unreachable!("that was noise"));
//! framer.push(&bytes, |frame| {
//!     let heard = Command::parse(frame).map(|command| command.argument);
//!     assert_eq!(heard, Ok(Argument::Integer(-200)));
//! });
//! assert_eq!((framer.counts().frames, framer.counts().noise), (1, 3));
//! ```

pub mod command;
pub mod frame;
pub mod greeting;
pub mod information;
pub mod settings;
pub mod units;
