//! A session over a line.

use orienteer_runtime::{
    geometry::Twist,
    time::Time,
    topics::{LineState, Odometry},
};

use super::{Profile, Session, State, session::GONE};
use crate::{
    driver::DriverError,
    line::{Address, Line, Minding, Standing, Stream},
    wire::oi::STOP_ANYHOW,
};

/// A base that was greeted so often, twice a second, does not listen at this speed.
const ENOUGH: u8 = 3;
/// One base at the end of a line, greeted and driven as long as it is [polled](Client::poll), a hundred times a second.
pub struct Client {
    line: Line,
    session: Session,
    /// The speeds to be tried in turn, and which of them is being tried.
    bauds: Vec<u32>,
    trying: usize,
    /// The base has spoken over this line, at whatever time.
    known: bool,
    /// When it was polled last, and when a whole frame came last.
    now: Time,
    frame: Option<Time>,
    heard: Vec<u8>,
    said: Vec<u8>,
}

impl Client {
    /// Greets whoever is at this address, as soon as it is polled. A serial port without `baud` is tried at the speeds of the model.
    ///
    /// The line is minded: the program begins with [`mind_if_asked`](crate::line::mind_if_asked).
    #[must_use]
    pub fn new(address: Address, baud: Option<u32>, profile: Profile) -> Self {
        let bauds = baud.map_or_else(|| profile.model.bauds.to_vec(), |baud| vec![baud]);
        let minding = Minding { stop: STOP_ANYHOW.to_vec(), silence: GONE };
        Self::on(Line::new(address, bauds[0]).minded(minding), bauds, profile)
    }

    /// Greets whoever is at the other end of this stream, which nobody minds.
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
            frame: None,
            heard: Vec::new(),
            said: Vec::new(),
        }
    }

    /// How the base is spoken to.
    #[must_use]
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Carries what has come and what is to be sent, and gives the newest odometry.
    ///
    /// # Errors
    /// [`Waiting`](DriverError::Waiting) before the base has answered for the first time, then
    /// [`LinkLost`](DriverError::LinkLost) when it does not.
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
            self.frame = Some(now);
        }
        if standing != Standing::Down {
            self.say(Session::transmit);
            self.try_another_speed();
        }
        let open = standing != Standing::Down && self.session.state() == State::Open;
        match self.session.readings().odometry() {
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
            age: self.frame.map_or(-1.0, |frame| self.now.secs_since(frame)),
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
        if self.session.state() != State::Greeting {
            self.say(|session, _, into| session.close(into));
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
        let why = match (standing, self.session.state()) {
            (Standing::Down, _) => self.line.trouble().to_owned(),
            _ => match (self.line.address(), &self.bauds[..]) {
                (Address::Serial { .. }, [baud]) => format!("nobody answers at {baud} baud"),
                (Address::Serial { .. }, _) => "nobody answers at any speed".to_owned(),
                (Address::Tcp { .. }, _) => "nobody answers".to_owned(),
            },
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
