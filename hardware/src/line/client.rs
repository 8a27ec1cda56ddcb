//! A client's side of a conversation with a base, on a line.
//!
//! Every family of bases is greeted, kept alive and driven in its own language, which is a [`Conversation`] without any I/O. What all have
//! in common is the [`Client`]: the line, the speed of a serial port that nobody has told, and the words for what is wrong.

use orienteer_runtime::{
    geometry::Twist,
    time::Time,
    topics::{LineState, Odometry},
};

use super::{Address, Conversation, Line, Stage, Standing};
use crate::{driver::DriverError, wire::Counts};

/// A base that was greeted so often, twice a second, does not listen at this speed.
const ENOUGH: u8 = 3;

/// One base at the end of a line, greeted, kept alive and driven as long as it is [polled](Client::poll): a hundred times a second is good.
pub struct Client<C: Conversation> {
    line: Line,
    session: C,
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

impl<C: Conversation> Client<C> {
    /// Greets whoever is at the end of this line, as soon as it is polled. A serial port is tried at these speeds in turn, baud; it is open
    /// at the first of them.
    #[must_use]
    pub fn on(line: Line, bauds: Vec<u32>, session: C) -> Self {
        Self {
            line,
            session,
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
    pub fn session(&mut self) -> &mut C {
        &mut self.session
    }

    /// Carries what has come and what is to be sent, and gives the newest odometry.
    ///
    /// # Errors
    /// [`Waiting`](DriverError::Waiting) before the base has answered for the first time, then
    /// [`LinkLost`](DriverError::LinkLost) when it does not; [`Refused`](DriverError::Refused) if it can't be driven.
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
            self.say(C::transmit);
            self.try_another_speed();
        }
        let open = standing != Standing::Down && self.session.stage() == Stage::Open;
        match self.session.odometry() {
            Some(odometry) if open => {
                self.known = true;
                Ok(odometry)
            }
            _ => Err(self.trouble(standing)),
        }
    }

    /// An error unless the base says where it is.
    ///
    /// # Errors
    /// As [`poll`](Self::poll).
    pub fn check(&self) -> Result<(), DriverError> {
        if self.session.stage() == Stage::Open { Ok(()) } else { Err(self.trouble(Standing::Open)) }
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
            unknown: counts.unknown,
            broken: counts.broken,
            noise: counts.noise,
        }
    }

    /// Wants this velocity.
    pub fn drive(&mut self, now: Time, twist: Twist) {
        self.now = now;
        self.session.drive(now, twist);
        if self.session.stage() == Stage::Open {
            self.say(C::transmit);
        }
    }

    /// Tells the base to stop at once.
    pub fn halt(&mut self) {
        self.say(|session, _, into| session.halt(into));
    }

    /// Ends the conversation.
    pub fn close(&mut self) {
        self.say(|session, _, into| session.close(into));
    }

    fn say(&mut self, what: impl FnOnce(&mut C, Time, &mut Vec<u8>)) {
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
        let device = self.line.address().to_string();
        if let Some(why) = self.session.refusal() {
            return DriverError::Refused { what: format!("the base at {device} {why}") };
        }
        let why = match (standing, self.session.stage()) {
            (Standing::Down, _) => self.line.trouble().to_owned(),
            (_, Stage::Unanswered) => self.silence(),
            _ => match self.session.parse_error() {
                Some(error) => format!("what it says is not understood: {error}"),
                None => "it has not said where it is".to_owned(),
            },
        };
        if self.known { DriverError::LinkLost { device, why } } else { DriverError::Waiting { device, why } }
    }

    /// What a base that does not answer may be.
    fn silence(&self) -> String {
        let speed = match (self.line.address(), &self.bauds[..]) {
            (Address::Serial { .. }, [baud]) => format!(" at {baud} baud"),
            (Address::Serial { .. }, _) => " at any speed".to_owned(),
            (Address::Tcp { .. }, _) => String::new(),
        };
        let Counts { broken, noise, .. } = self.session.counts();
        if self.packet.is_none() && broken + noise > 0 {
            return format!("something answers, but not in {}{speed}; is it {}?", C::LANGUAGE, C::STRANGER);
        }
        format!("nobody answers{speed}; is it on, and does it speak {}?", C::LANGUAGE)
    }
}

impl<C: Conversation> Drop for Client<C> {
    fn drop(&mut self) {
        self.close();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::{io::Write, net::TcpListener, thread, time::Duration, time::Instant};

    use super::*;
    use crate::{arcos, base::presets, oi, wire::oi::units::Model};

    /// What is said of somebody who answers with these bytes, and never with others.
    fn told_of<C: Conversation>(session: C, answer: &[u8]) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("tcp://{}", listener.local_addr().unwrap()).parse().unwrap();
        let mut client = Client::on(Line::new(address, 9600), vec![9600], session);
        let began = Instant::now();
        let mut other = None;
        loop {
            assert!(began.elapsed() < Duration::from_secs(20), "it says nothing of it");
            let told = client.poll(Time::START + began.elapsed()).unwrap_err().to_string();
            match &other {
                None if client.line.opened() > 0 => {
                    let (mut stream, _) = listener.accept().unwrap();
                    stream.write_all(answer).unwrap();
                    other = Some(stream);
                }
                Some(_) if client.session.unanswered() > 0 && (answer.is_empty() || told.contains("something")) => return told,
                _ => thread::sleep(Duration::from_millis(2)),
            }
        }
    }

    #[test]
    fn who_speaks_another_language_is_told_from_nobody() {
        let profile =
            arcos::Profile { units: None, acceleration: 0.3, angular_acceleration: 1.7, transducers: 0, max_range: 0.0 };
        let pioneer = || arcos::Session::new(profile.clone());
        let create = || oi::Session::new(oi::Profile::new(Model::CREATE_2, &presets::create2().platform()));
        // A frame of the one's stream, and the other's answer to a greeting.
        let (frame, greeting) = ([19, 2, 7, 0, 228], [0xFA, 0xFB, 0x03, 0x00, 0x00, 0x00]);
        assert!(told_of(pioneer(), &frame).ends_with("something answers, but not in ARCOS; is it a Create or Roomba?"));
        assert!(told_of(create(), &greeting).ends_with("something answers, but not in OI; is it a Pioneer or AmigoBot?"));
        assert!(told_of(pioneer(), &[]).ends_with("nobody answers; is it on, and does it speak ARCOS?"));
        assert!(told_of(create(), &[]).ends_with("nobody answers; is it on, and does it speak OI?"));
    }
}
