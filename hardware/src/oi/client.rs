//! A session over a line.

use orienteer_runtime::{geometry::Twist, time::Time, topics::Odometry};

use super::{Profile, Session, State, session::GONE};
use crate::{
    line::{self, Address, Conversation, Line, Minding, Stage, Stream},
    wire::{Counts, oi::STOP_ANYHOW},
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

impl Conversation for Session {
    const LANGUAGE: &'static str = "OI";
    const STRANGER: &'static str = "a Pioneer or AmigoBot";

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
        if self.state() != State::Greeting {
            Session::close(self, into);
        }
    }

    fn stage(&self) -> Stage {
        match self.state() {
            State::Greeting | State::Opening => Stage::Unanswered,
            State::Open => Stage::Open,
        }
    }

    fn unanswered(&self) -> u8 {
        Session::unanswered(self)
    }

    fn odometry(&self) -> Option<Odometry> {
        self.readings().odometry()
    }

    fn counts(&self) -> Counts {
        Session::counts(self)
    }
}
