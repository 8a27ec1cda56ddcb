//! Pioneer, AmigoBot and other bases that speak [ARCOS](crate::wire::arcos): the client's side, without any I/O.
//!
//! A [`Session`] gets the bytes that have come and gives those that are to be sent; whoever owns the port carries them. [`Readings`]
//! makes of the base's packets what a robot reads: odometry and scans in metres and radians.

mod readings;
mod session;

pub use readings::Readings;
pub use session::{Profile, Session, State};
