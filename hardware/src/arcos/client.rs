//! A session over a line: what the drivers of one base share.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use orienteer_runtime::{
    geometry::Twist,
    time::Time,
    topics::{LineState, Odometry, SonarScan},
};

use super::{Profile, Session, State};
use crate::{
    driver::DriverError,
    line::{Address, Line, Standing, Stream},
};

/// The speeds of a serial port that are tried, the factory's own first, baud.
pub const BAUDS: [u32; 5] = [9600, 19_200, 38_400, 57_600, 115_200];
/// A base that was greeted so often, twice a second, does not listen at this speed.
const ENOUGH: u8 = 3;

/// One base at the end of a line, greeted and kept alive as long as it is [polled](Client::poll), ten times a second or more often.
pub struct Client {
    line: Line,
    session: Session,
    /// The speeds to be tried in turn, and which of them is being tried.
    bauds: Vec<u32>,
    trying: usize,
    /// The base has spoken over this line, at whatever time.
    known: bool,
    /// When it was polled last, and when a whole packet came last.
    now: Time,
    packet: Option<Time>,
    heard: Vec<u8>,
    said: Vec<u8>,
}

impl Client {
    /// Greets whoever is at this address, as soon as it is polled. A serial port without `baud` is tried at [all speeds](BAUDS).
    #[must_use]
    pub fn new(address: Address, baud: Option<u32>, profile: Profile) -> Self {
        let bauds = baud.map_or_else(|| BAUDS.to_vec(), |baud| vec![baud]);
        Self::on(Line::new(address, bauds[0]), bauds, profile)
    }

    /// Greets whoever is at the other end of this stream.
    #[must_use]
    pub fn over(stream: Box<dyn Stream>, profile: Profile) -> Self {
        Self::on(Line::over("a stream", stream), vec![0], profile)
    }

    fn on(line: Line, bauds: Vec<u32>, profile: Profile) -> Self {
        Self {
            line,
            session: Session::new(profile),
            bauds,
            trying: 0,
            known: false,
            now: Time::START,
            packet: None,
            heard: Vec::new(),
            said: Vec::new(),
        }
    }

    /// How the base is spoken to.
    pub fn session(&mut self) -> &mut Session {
        &mut self.session
    }

    /// Carries what has come and what is to be sent, and gives the newest odometry.
    ///
    /// # Errors
    /// [`Waiting`](DriverError::Waiting) before the base has answered for the first time, then
    /// [`LinkLost`](DriverError::LinkLost) when it does not; [`Refused`](DriverError::Refused) if nobody knows its units.
    pub fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        self.now = now;
        self.heard.clear();
        let standing = self.line.receive(now, &mut self.heard);
        if standing == Standing::Fresh {
            self.session.begin_anew();
        }
        let before = self.session.counts().frames;
        self.session.receive(now, &self.heard);
        if self.session.counts().frames > before {
            self.packet = Some(now);
        }
        if standing != Standing::Down {
            self.say(Session::transmit);
            self.try_another_speed();
        }
        let open = standing != Standing::Down && self.session.state() == State::Open;
        match self.session.readings().and_then(|readings| readings.odometry()) {
            Some(odometry) if open => {
                self.known = true;
                Ok(odometry)
            }
            _ => Err(self.trouble(standing)),
        }
    }

    /// How well the line carries.
    #[must_use]
    pub fn line_state(&self) -> LineState {
        let counts = self.session.counts();
        LineState {
            stamp: self.now,
            age: self.packet.map_or(-1.0, |packet| self.now.secs_since(packet)),
            opened: self.line.opened(),
            packets: counts.frames,
            broken: counts.broken,
            noise: counts.noise,
        }
    }

    /// Wants this velocity.
    pub fn drive(&mut self, now: Time, twist: Twist) {
        self.now = now;
        self.session.drive(now, twist);
        if self.session.state() == State::Open {
            self.say(Session::transmit);
        }
    }

    /// Tells the base to stop at once.
    pub fn halt(&mut self) {
        self.say(|session, _, into| session.halt(into));
    }

    /// Ends the session.
    pub fn close(&mut self) {
        if self.session.state() != State::Greeting(0) {
            self.say(|session, _, into| session.close(into));
        }
    }

    /// Appends the scans that have come, oldest first.
    ///
    /// # Errors
    /// If the base does not answer.
    pub fn scans(&mut self, into: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        if let Some(readings) = self.session.readings() {
            readings.fetch(into);
        }
        match self.session.state() {
            State::Open => Ok(()),
            _ => Err(self.trouble(Standing::Open)),
        }
    }

    fn say(&mut self, what: impl FnOnce(&mut Session, Time, &mut Vec<u8>)) {
        self.said.clear();
        what(&mut self.session, self.now, &mut self.said);
        self.line.send(self.now, &self.said);
    }

    fn try_another_speed(&mut self) {
        let serial = matches!(self.line.address(), Address::Serial { .. });
        if serial && self.bauds.len() > 1 && self.session.unanswered() > ENOUGH {
            self.trying = (self.trying + 1) % self.bauds.len();
            self.line.open_at(self.bauds[self.trying]);
        }
    }

    fn trouble(&self, standing: Standing) -> DriverError {
        if let Some(greeting) = self.session.greeting().filter(|_| self.session.is_strange()) {
            let what = format!(
                "the base at {} calls itself `{}`; nobody knows its units: give its `model`",
                self.line.address(),
                greeting.model
            );
            return DriverError::Refused { what };
        }
        let why = match (standing, self.session.state()) {
            (Standing::Down, _) => self.line.trouble().to_owned(),
            (_, State::Greeting(_)) => match (self.line.address(), &self.bauds[..]) {
                (Address::Serial { .. }, [baud]) => format!("nobody answers at {baud} baud"),
                (Address::Serial { .. }, _) => "nobody answers at any speed".to_owned(),
                (Address::Tcp { .. }, _) => "nobody answers".to_owned(),
            },
            _ => "it has not said where it is".to_owned(),
        };
        let device = self.line.address().to_string();
        if self.known { DriverError::LinkLost { device, why } } else { DriverError::Waiting { device, why } }
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.close();
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
