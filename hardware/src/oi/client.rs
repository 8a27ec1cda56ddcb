//! A session over a line.

use super::{Profile, Session, session::GONE};
use crate::{
    line::{self, Address, Line, Minding, Stream},
    wire::oi::STOP_ANYHOW,
};

/// One base at the end of a line, greeted and driven as long as it is [polled](line::Client::poll), a hundred times a second.
pub type Client = line::Client<Session>;

impl Client {
    /// Greets whoever is at this address, as soon as it is polled. A serial port without `baud` is tried at the speeds of the model.
    ///
    /// The line is minded: the program begins with [`mind_if_asked`](crate::line::mind_if_asked).
    #[must_use]
    pub fn new(address: Address, baud: Option<u32>, profile: Profile) -> Self {
        let bauds = baud.map_or_else(|| profile.model.bauds.to_vec(), |baud| vec![baud]);
        let minding = Minding { stop: STOP_ANYHOW.to_vec(), silence: GONE };
        Self::on(Line::new(address, bauds[0]).minded(minding), bauds, Session::new(profile))
    }

    /// Greets whoever is at the other end of this stream, which nobody minds.
    #[must_use]
    pub fn over(stream: Box<dyn Stream>, profile: Profile) -> Self {
        Self::on(Line::over("a stream", stream), vec![0], Session::new(profile))
    }
}
