//! Create, Roomba and other bases that speak iRobot's [Open Interface](crate::wire::oi): the client's side.
//!
//! A [`Session`] gets the bytes that have come and gives those that are to be sent, without any I/O. [`Readings`] makes of the base's
//! packets what a robot reads. A [`Client`] joins a session to a [line](mod@crate::line), and [`CreateBase`] is a driver with one.
//!
//! # What the base does not do, and who does it
//!
//! | | who |
//! |---|---|
//! | speed up and brake gently | the session: it changes speeds by no more than the platform's accelerations |
//! | stop when it touches something or a wheel drops | the session, with the very bytes that say so; in Safe mode the base itself, for drops and cliffs |
//! | stop when nobody speaks to it any more | a [minder](crate::line::Minder) beside the line, with [`STOP_ANYHOW`](crate::wire::oi::STOP_ANYHOW) |
//!
//! # What it feels
//!
//! * A **bump** is [`CONTACT`](orienteer_runtime::topics::flags::CONTACT), and ahead. The base stops, and goes ahead no more until the bumper is
//!   free; it may turn, and back off, as far as [protection](crate::base::protection) lets it.
//! * A **cliff** is the same. There is nothing to touch, but all that protection makes of a contact is right here: not that way, and
//!   straight back is good. As an emergency stop it would hold the base at the edge for ever. The sensors look ahead, as the bumper
//!   does.
//! * A **wheel that drops** is [`EMERGENCY_STOP`](orienteer_runtime::topics::flags::EMERGENCY_STOP): the base hangs on an edge or in
//!   somebody's hands, and no motion is good. When the wheels have been down for a second, the motors go on again, with the wheels told
//!   to stand.
//! * A wheel's motor that draws too much, and a caster that ceases to turn while the base goes straight ahead, are
//!   [`STALLED`](orienteer_runtime::topics::flags::STALLED).

mod client;
mod driver;
mod readings;
mod session;

pub use client::Client;
pub use driver::CreateBase;
pub use readings::Readings;
pub use session::{Profile, Session, State};

pub use crate::wire::oi::STOP;
