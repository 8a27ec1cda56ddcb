//! One client's conversation with a base: greeting, keeping it alive, driving it, and beginning again when it has gone.

use std::time::Duration;

use orienteer_runtime::{
    geometry::Twist,
    time::Time,
    topics::{Odometry, flags},
};
use smallvec::SmallVec;

use super::Readings;
use crate::{
    line::{Conversation, Stage},
    wire::{
        Counts, PacketError,
        arcos::{
            command::{Argument, Code, Command},
            frame::{Frame, Framer},
            greeting::{Greeting, emit_sync},
            information::Information,
            units::Units,
        },
    },
};

/// A greeting that is not answered for so long is sent again.
const ANSWER: Duration = Duration::from_millis(500);
/// A base that says nothing for so long has gone: it should speak ten times a second.
const SILENCE: Duration = Duration::from_secs(1);
/// For how long a velocity holds that nobody renews. The base itself would keep it as long as anybody speaks.
const HOLDS: Duration = Duration::from_millis(250);
/// The base hears something at least this often. It stops by itself after two seconds of nothing.
const ALIVE: Duration = Duration::from_millis(200);

/// How often the base is reminded of one of its limits.
const REMINDER: Duration = Duration::from_millis(250);

/// Orders of firing are no longer than this: twice round the largest ring.
const LONGEST_ORDER: usize = 64;

/// What a base is and how it is to be driven.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Its units; `None` to take them by the model that it greets with.
    pub units: Option<Units>,
    /// Acceleration and deceleration, m/s².
    pub acceleration: f64,
    /// Angular acceleration and deceleration, rad/s².
    pub angular_acceleration: f64,
    /// Number of transducers; without any, none is switched on.
    pub transducers: usize,
    /// Range of a transducer that hears nothing, m.
    pub max_range: f64,
}

/// How a session stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// The base has not answered this greeting yet, 0 to 2.
    Greeting(u8),
    /// It has greeted back, and has not said where it is yet.
    Opening,
    /// It says where it is, and obeys.
    Open,
}

/// A client's side of a session, without any I/O: [`receive`](Session::receive) what has come, then send what
/// [`transmit`](Session::transmit) gives; at least ten times a second.
///
/// A velocity that is not renewed with [`drive`](Session::drive) for a quarter of a second is replaced by a stop.
#[derive(Debug, Clone)]
pub struct Session {
    profile: Profile,
    framer: Framer,
    state: State,
    greeting: Option<Greeting>,
    /// Frames of a session that were not understood, and what was wrong with the newest if it should have been.
    unknown: u64,
    parse_error: Option<PacketError>,
    /// When the base was greeted last, or spoke last.
    since: Option<Time>,
    readings: Option<Readings>,
    wanted: Twist,
    /// When `wanted` was said last.
    renewed: Option<Time>,
    /// The velocity that the base was told last, mm/s and °/s.
    told: Option<(i32, i32)>,
    /// When the base was told anything.
    spoke: Option<Time>,
    /// How often the base was greeted anew.
    attempts: u8,
    /// The order in which transducers fire, counted from 1; the base's own if there is none.
    firing: SmallVec<[u8; 32]>,
    /// The base was not told of that order yet.
    retell_firing: bool,
    /// When the base was told again what opened the session.
    reminded: Option<Time>,
    /// Which of its limits the base is told next.
    limit: usize,
    /// The motors were seen on in this session.
    enabled: bool,
}

impl Session {
    /// Nothing has been said yet.
    #[must_use]
    pub fn new(profile: Profile) -> Self {
        Self {
            profile,
            framer: Framer::default(),
            state: State::Greeting(0),
            greeting: None,
            unknown: 0,
            parse_error: None,
            since: None,
            readings: None,
            wanted: Twist::STOP,
            renewed: None,
            told: None,
            spoke: None,
            attempts: 0,
            firing: SmallVec::new(),
            retell_firing: false,
            reminded: None,
            limit: 0,
            enabled: false,
        }
    }

    /// What the base is and how it is to be driven.
    #[must_use]
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The base has so many transducers that hear up to `max_range` m. To be said before anything is sent.
    pub fn equip(&mut self, transducers: usize, max_range: f64) {
        (self.profile.transducers, self.profile.max_range) = (transducers, max_range);
    }

    /// The transducers, counted from 0, fire in this order from now on.
    pub fn fire(&mut self, order: impl IntoIterator<Item = u8>) {
        self.firing = order.into_iter().map(|transducer| transducer.saturating_add(1)).take(LONGEST_ORDER).collect();
        self.retell_firing = true;
    }

    /// How it stands.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    /// What the base has greeted with, if it has.
    #[must_use]
    pub fn greeting(&self) -> Option<&Greeting> {
        self.greeting.as_ref()
    }

    /// True if the base has greeted with a model whose units nobody knows: it is left alone then.
    #[must_use]
    pub fn is_strange(&self) -> bool {
        self.greeting.as_ref().is_some_and(|greeting| self.units_of(greeting).is_none())
    }

    fn units_of(&self, greeting: &Greeting) -> Option<Units> {
        self.profile.units.or_else(|| Units::of(&greeting.model))
    }

    /// What the base has said of itself; `None` before it was greeted.
    #[must_use]
    pub fn readings(&self) -> Option<&Readings> {
        self.readings.as_ref()
    }

    /// The same, to fetch the scans from.
    pub fn readings_mut(&mut self) -> Option<&mut Readings> {
        self.readings.as_mut()
    }

    fn hear(&mut self, now: Time, frame: Frame<'_>) {
        match self.state {
            // Some bases answer a greeting only when it is its turn, so theirs says how far they are.
            State::Greeting(_) if matches!(frame.kind, 0 | 1) && frame.body.is_empty() => {
                (self.state, self.since, self.attempts) = (State::Greeting(frame.kind + 1), None, 0);
            }
            State::Greeting(_) => {
                if let Ok(greeting) = Greeting::parse(frame) {
                    self.meet(now, greeting);
                }
            }
            State::Opening | State::Open => {
                // Answers to what nobody here has asked for may come, too: to another program on the same line, or in a language that
                // is newer than this.
                self.parse_error = match Information::parse(frame) {
                    Ok(packet) => {
                        (self.state, self.since) = (State::Open, Some(now));
                        if let Some(readings) = &mut self.readings {
                            readings.follow(now, &packet);
                        }
                        None
                    }
                    Err(error) => {
                        self.unknown += 1;
                        Information::is_in(frame).then_some(error).or(self.parse_error)
                    }
                };
            }
        }
    }

    fn meet(&mut self, now: Time, greeting: Greeting) {
        let units = self.units_of(&greeting);
        self.greeting = Some(greeting);
        let Some(units) = units else {
            // It is in a session now: closed before the next greeting.
            (self.state, self.since, self.attempts) = (State::Greeting(0), Some(now), 0);
            return;
        };
        match &mut self.readings {
            Some(readings) => readings.begin_anew(units),
            None => self.readings = Some(Readings::new(units, self.profile.transducers, self.profile.max_range)),
        }
        (self.state, self.since) = (State::Opening, None);
    }

    /// Begins with the greeting. The base may be in a session that somebody has left, or half through a greeting of which the
    /// answer got lost; the closing word is the third greeting, too.
    fn greet_anew(&mut self, into: &mut Vec<u8>) {
        let step = self.attempts % 2;
        self.attempts = self.attempts.wrapping_add(1);
        self.state = State::Greeting(step);
        if step == 0 {
            Command::new(Code::Close, Argument::None).emit(into);
        }
        emit_sync(step, into);
    }

    /// Starts the stream of information, with wheels that stand, and only then the motors.
    fn open(&mut self, into: &mut Vec<u8>) {
        Command::new(Code::Open, Argument::None).emit(into);
        self.limits().iter().for_each(|command| command.emit(into));
        for (code, number) in
            [(Code::Velocity, 0), (Code::TurnRate, 0), (Code::Sonar, i32::from(self.profile.transducers > 0)), (Code::Enable, 1)]
        {
            Command::new(code, Argument::Integer(number)).emit(into);
        }
        self.told = Some((0, 0));
        self.retell_firing = !self.firing.is_empty();
        (self.limit, self.enabled) = (0, false);
    }

    /// How hard the base accelerates and brakes, along and turning.
    fn limits(&self) -> [Command<'static>; 4] {
        let linear = (self.profile.acceleration * 1000.0).round() as i32;
        let angular = self.profile.angular_acceleration.to_degrees().round() as i32;
        [
            (Code::Acceleration, linear),
            (Code::Acceleration, -linear),
            (Code::AngularAcceleration, angular),
            (Code::AngularAcceleration, -angular),
        ]
        .map(|(code, number)| Command::new(code, Argument::Integer(number)))
    }

    /// Says again what opened the session, bit by bit: the base acknowledges nothing, and one that brakes as its maker set it would
    /// run into what it should have stopped before. Motors are switched on until they were seen on, and not after that: whoever
    /// switches them off means it.
    fn remind(&mut self, into: &mut Vec<u8>) {
        let limits = self.limits();
        limits[self.limit].emit(into);
        self.limit = (self.limit + 1) % limits.len();
        if self.state != State::Open {
            // What is known of the motors is from before.
            return;
        }
        let odometry = self.readings.as_ref().and_then(Readings::odometry);
        self.enabled |= odometry.is_some_and(|odometry| odometry.flags & flags::ENABLED != 0);
        if !self.enabled {
            Command::new(Code::Enable, Argument::Integer(1)).emit(into);
        }
    }

    /// Says the velocity when it changes, and every now and then that somebody is there.
    fn steer(&mut self, now: Time, into: &mut Vec<u8>) {
        if std::mem::take(&mut self.retell_firing) {
            Command::new(Code::Polling, Argument::Text(&self.firing)).emit(into);
        }
        let holds = self.renewed.is_some_and(|renewed| now.since(renewed) < HOLDS);
        let twist = if holds && self.state == State::Open { self.wanted } else { Twist::STOP };
        let velocity = ((twist.linear * 1000.0).round() as i32, twist.angular.to_degrees().round() as i32);
        let quiet = self.spoke.is_none_or(|spoke| now.since(spoke) >= ALIVE);
        if self.told != Some(velocity) || quiet {
            Command::new(Code::Velocity, Argument::Integer(velocity.0)).emit(into);
            Command::new(Code::TurnRate, Argument::Integer(velocity.1)).emit(into);
            (self.told, self.spoke) = (Some(velocity), Some(now));
        }
        if self.reminded.is_none_or(|reminded| now.since(reminded) >= REMINDER) {
            self.reminded = Some(now);
            self.remind(into);
        }
    }
}

impl Conversation for Session {
    const LANGUAGE: &'static str = "ARCOS";
    const STRANGER: &'static str = "a Create or Roomba";

    fn begin_anew(&mut self) {
        self.framer.reset();
        (self.state, self.since, self.attempts) = (State::Greeting(0), None, 0);
    }

    fn receive(&mut self, now: Time, bytes: &[u8]) {
        // The framer goes aside while it shows frames to the rest.
        let mut framer = std::mem::take(&mut self.framer);
        framer.push(bytes, |frame| self.hear(now, frame));
        self.framer = framer;
    }

    fn transmit(&mut self, now: Time, into: &mut Vec<u8>) {
        let waited = |limit: Duration| self.since.is_none_or(|since| now.since(since) >= limit);
        match self.state {
            State::Greeting(step) if waited(ANSWER) => {
                match (self.since, step) {
                    (None, 1..) => emit_sync(step, into),
                    _ => self.greet_anew(into),
                }
                self.since = Some(now);
            }
            State::Greeting(_) => {}
            State::Opening if self.since.is_none() => {
                self.open(into);
                (self.since, self.spoke) = (Some(now), Some(now));
            }
            State::Opening | State::Open if waited(SILENCE) => {
                self.attempts = 0;
                self.greet_anew(into);
                self.since = Some(now);
            }
            State::Opening | State::Open => self.steer(now, into),
        }
    }

    fn drive(&mut self, now: Time, twist: Twist) {
        let wanted = if twist.is_finite() { twist } else { Twist::STOP };
        (self.wanted, self.renewed) = (wanted, Some(now));
    }

    fn halt(&mut self, into: &mut Vec<u8>) {
        (self.wanted, self.renewed) = (Twist::STOP, None);
        if matches!(self.state, State::Opening | State::Open) {
            self.told = None;
            Command::new(Code::Stop, Argument::None).emit(into);
        }
    }

    fn close(&mut self, into: &mut Vec<u8>) {
        if self.state != State::Greeting(0) {
            for code in [Code::Stop, Code::Close] {
                Command::new(code, Argument::None).emit(into);
            }
            self.begin_anew();
        }
    }

    fn stage(&self) -> Stage {
        match self.state {
            State::Greeting(_) => Stage::Unanswered,
            State::Opening => Stage::Answered,
            State::Open => Stage::Open,
        }
    }

    fn unanswered(&self) -> u8 {
        self.attempts
    }

    fn odometry(&self) -> Option<Odometry> {
        self.readings().and_then(Readings::odometry)
    }

    fn counts(&self) -> Counts {
        Counts { unknown: self.unknown, ..self.framer.counts() }
    }

    fn parse_error(&self) -> Option<PacketError> {
        self.parse_error
    }

    fn refusal(&self) -> Option<String> {
        let greeting = self.greeting().filter(|_| self.is_strange())?;
        Some(format!("calls itself `{}`; nobody knows its units: give its `model`", greeting.model))
    }
}

#[cfg(test)]
mod tests;
