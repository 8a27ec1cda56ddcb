//! A session over a line: what the drivers of one base share.

use orienteer_runtime::topics::SonarScan;

use super::{Profile, Session};
use crate::line::{self, Address, Line, Stream};

/// The speeds of a serial port that are tried, the factory's own first, baud.
pub const BAUDS: [u32; 5] = [9600, 19_200, 38_400, 57_600, 115_200];

/// One base at the end of a line, greeted and kept alive as long as it is [polled](line::Client::poll), ten times a second or more often.
pub type Client = line::Client<Session>;

impl Client {
    /// Greets whoever is at this address, as soon as it is polled. A serial port without `baud` is tried at [all speeds](BAUDS).
    #[must_use]
    pub fn new(address: Address, baud: Option<u32>, profile: Profile) -> Self {
        let bauds = baud.map_or_else(|| BAUDS.to_vec(), |baud| vec![baud]);
        Self::on(Line::new(address, bauds[0]), bauds, Session::new(profile))
    }

    /// Greets whoever is at the other end of this stream.
    #[must_use]
    pub fn over(stream: Box<dyn Stream>, profile: Profile) -> Self {
        Self::on(Line::over("a stream", stream), vec![0], Session::new(profile))
    }

    /// Appends the scans that have come, oldest first.
    pub fn scans(&mut self, into: &mut Vec<SonarScan>) {
        if let Some(readings) = self.session().readings_mut() {
            readings.fetch(into);
        }
    }
}
