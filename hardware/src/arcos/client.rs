//! A session over a line: what the drivers of one base share.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use orienteer_runtime::{
    geometry::Twist,
    time::Time,
    topics::{Odometry, SonarScan},
};

use super::{Profile, Session, State};
use crate::{
    driver::DriverError,
    line::{self, Address, Conversation, Line, Stage, Stream},
    wire::Counts,
};

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
    ///
    /// # Errors
    /// If the base does not answer.
    pub fn scans(&mut self, into: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        if let Some(readings) = self.session().readings_mut() {
            readings.fetch(into);
        }
        self.check()
    }
}

impl Conversation for Session {
    const LANGUAGE: &'static str = "ARCOS";
    const STRANGER: &'static str = "a Create or Roomba";

    fn begin_anew(&mut self) {
        Session::begin_anew(self);
    }

    fn receive(&mut self, now: Time, bytes: &[u8]) {
        Session::receive(self, now, bytes);
    }

    fn transmit(&mut self, now: Time, into: &mut Vec<u8>) {
        Session::transmit(self, now, into);
    }

    fn drive(&mut self, now: Time, twist: Twist) {
        Session::drive(self, now, twist);
    }

    fn halt(&mut self, into: &mut Vec<u8>) {
        Session::halt(self, into);
    }

    fn close(&mut self, into: &mut Vec<u8>) {
        if self.state() != State::Greeting(0) {
            Session::close(self, into);
        }
    }

    fn stage(&self) -> Stage {
        match self.state() {
            State::Greeting(_) => Stage::Unanswered,
            State::Opening => Stage::Answered,
            State::Open => Stage::Open,
        }
    }

    fn unanswered(&self) -> u8 {
        Session::unanswered(self)
    }

    fn odometry(&self) -> Option<Odometry> {
        self.readings().and_then(super::Readings::odometry)
    }

    fn counts(&self) -> Counts {
        Session::counts(self)
    }

    fn refusal(&self) -> Option<String> {
        let greeting = self.greeting().filter(|_| self.is_strange())?;
        Some(format!("calls itself `{}`; nobody knows its units: give its `model`", greeting.model))
    }
}

/// A client that the drivers of a base and of its sonar share, each on its own thread.
#[derive(Clone)]
pub(crate) struct SharedClient(Arc<Mutex<Client>>);

impl SharedClient {
    pub fn new(client: Client) -> Self {
        Self(Arc::new(Mutex::new(client)))
    }

    /// Nobody holds it for longer than a few bytes take. A panic in between has left it usable: the session begins anew when it must.
    pub fn lock(&self) -> MutexGuard<'_, Client> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
