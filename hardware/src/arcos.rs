//! Pioneer, AmigoBot and other bases that speak [ARCOS](crate::wire::arcos): the client's side.
//!
//! A [`Session`] gets the bytes that have come and gives those that are to be sent, without any I/O. [`Readings`] makes of the base's
//! packets what a robot reads: odometry and scans in metres and radians. A [`Client`] joins a session to a
//! [line](mod@crate::line), and [`ArcosBase`] and [`ArcosSonar`] share one as drivers.

mod client;
mod drivers;
mod readings;
mod session;

pub use client::{BAUDS, Client};
pub(crate) use drivers::Mailbox;
pub use drivers::{ArcosBase, ArcosSonar};
pub use readings::Readings;
pub use session::{Profile, Session, State};
