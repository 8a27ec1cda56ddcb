//! One client's conversation with a base: greeting, driving it, heeding what it feels, and beginning again when it has gone.

use std::time::Duration;

use orienteer_runtime::{
    geometry::{Limits, Twist},
    robot_model::Platform,
    time::Time,
    topics::Odometry,
};

use super::Readings;
use crate::{
    base::profile::ramp,
    line::{Conversation, Stage},
    wire::{
        Counts,
        oi::{
            STOP,
            command::{Command, TOP_SPEED},
            sensors::Sensors,
            stream::Framer,
            units::Model,
        },
    },
};

/// A greeting after which no frame has come for so long is sent again.
const ANSWER: Duration = Duration::from_millis(500);
/// A base from which no frame has come for so long has gone: that is 20 of them.
const SILENCE: Duration = Duration::from_millis(300);
/// So long the oldest Roombas heed nothing after a command that changes their mode (20 ms in their specification).
const SETTLES: Duration = Duration::from_millis(40);
/// For how long a velocity holds that nobody renews. The base itself would keep it for ever.
const HOLDS: Duration = Duration::from_millis(250);
/// The base is told its speeds at least this often, so that whoever minds the line knows that somebody is there.
const ALIVE: Duration = Duration::from_millis(100);
/// A client that says nothing for so long is as good as gone, to whoever minds the line; the base is told to stand then.
pub(super) const GONE: Duration = Duration::from_millis(250);
/// A base in Passive mode is asked for Safe so often.
const SAFE_AGAIN: Duration = Duration::from_millis(500);
/// Wheels that were down for so long stay down: hands are away by then.
const PUT_DOWN: Duration = Duration::from_secs(1);
/// What somebody else has left half said swallows these.
const FILLER: [u8; 16] = [0; 16];

/// What a base is and how it is to be driven.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// What its numbers are worth.
    pub model: Model,
    /// The greatest speeds.
    pub limits: Limits,
    /// Acceleration and deceleration, m/s².
    pub acceleration: f64,
    /// Angular acceleration and deceleration, rad/s².
    pub angular_acceleration: f64,
}

impl Profile {
    /// A base of this model that is driven as its platform says.
    #[must_use]
    pub fn new(model: Model, platform: &Platform) -> Self {
        let Platform { limits, acceleration, angular_acceleration, .. } = *platform;
        Self { model, limits, acceleration, angular_acceleration }
    }
}

/// How a session stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// The base is told to listen.
    Greeting,
    /// It was asked to say what it senses, and has not yet.
    Opening,
    /// It says what it senses.
    Open,
}

/// A client's side of a session, without any I/O: [`receive`](Session::receive) what has come, then send what
/// [`transmit`](Session::transmit) gives; a hundred times a second, since speeds change from one to the next.
///
/// A velocity that is not renewed with [`drive`](Session::drive) for a quarter of a second is replaced by a stop.
#[derive(Debug, Clone)]
pub struct Session {
    profile: Profile,
    framer: Framer,
    state: State,
    /// When the base was told to listen or to speak, or spoke last.
    since: Option<Time>,
    /// How often the base was greeted anew.
    attempts: u8,
    sensors: Sensors,
    readings: Readings,
    wanted: Twist,
    /// When `wanted` was said last.
    renewed: Option<Time>,
    /// On the way to `wanted`, under the accelerations.
    pace: Twist,
    /// When `pace` was that.
    paced: Option<Time>,
    /// What the wheels were told last, right and left, mm/s.
    told: Option<(i16, i16)>,
    /// When they were told.
    spoke: Option<Time>,
    reflexes: Reflexes,
}

/// What keeps the base from going as it is told.
#[derive(Debug, Clone, Default)]
struct Reflexes {
    /// Something was touched in this moment.
    startled: bool,
    /// It has to be told to stand before it is moved again.
    must_rest: bool,
    /// A wheel hung down then.
    dropped: Option<Time>,
    /// It was asked for Safe then.
    asked: Option<Time>,
}

impl Session {
    /// Nothing has been said yet.
    #[must_use]
    pub fn new(profile: Profile) -> Self {
        let framer = Framer::new(profile.model.packets);
        Self {
            framer: if profile.model.headless_sum { framer.or_with_headless_sum() } else { framer },
            state: State::Greeting,
            since: None,
            attempts: 0,
            sensors: Sensors::default(),
            readings: Readings::new(profile.model),
            wanted: Twist::STOP,
            renewed: None,
            pace: Twist::STOP,
            paced: None,
            told: None,
            spoke: None,
            reflexes: Reflexes::default(),
            profile,
        }
    }

    /// How it stands.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    /// What the base is and how it is driven.
    #[must_use]
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// What the base has said of itself.
    #[must_use]
    pub fn readings(&self) -> &Readings {
        &self.readings
    }

    fn hear(&mut self, now: Time, sensors: &Sensors) {
        if self.state == State::Greeting {
            return;
        }
        let touched = |sensors: &Sensors| sensors.bumps() || sensors.cliff();
        self.reflexes.startled |= touched(sensors) && !touched(&self.sensors);
        if sensors.drops() {
            self.reflexes.dropped = Some(now);
        }
        self.sensors = *sensors;
        (self.state, self.since, self.attempts) = (State::Open, Some(now), 0);
        self.readings.follow(now, sensors, self.pace);
    }

    /// Tells the base to listen, which takes it to Passive: wheels that somebody has left turning stop.
    fn greet(&mut self, now: Time, into: &mut Vec<u8>) {
        into.extend(FILLER);
        Command::Start.emit(into);
        self.attempts = self.attempts.saturating_add(1);
        (self.state, self.since) = (State::Greeting, Some(now));
        // Should it not even hear that, and its frames come again, it begins standing all the same.
        (self.pace, self.paced, self.told, self.reflexes) = (Twist::STOP, None, None, Reflexes::default());
        self.readings.begin_anew();
    }

    /// Says the speeds of the wheels when they change, and every now and then; asks for motors that are off.
    fn steer(&mut self, now: Time, into: &mut Vec<u8>) {
        let holds = self.renewed.is_some_and(|renewed| now.since(renewed) < HOLDS);
        let wanted = if holds { self.wanted } else { Twist::STOP };
        let pause = self.paced.replace(now).map_or(Duration::ZERO, |paced| now.since(paced));
        if !self.sensors.mode.obeys() {
            (self.pace, self.told, self.reflexes.must_rest) = (Twist::STOP, None, true);
            self.ask_for_motors(now, wanted, into);
            return;
        }
        self.pace = match self.permitted(wanted) {
            // Who was held up comes back to a base that stands.
            Some(_) if pause >= GONE => Twist::STOP,
            Some(twist) => {
                let seconds = pause.as_secs_f64();
                let Profile { acceleration, angular_acceleration, .. } = self.profile;
                let linear = ramp(self.pace.linear, twist.linear, acceleration, seconds).0;
                Twist::new(linear, ramp(self.pace.angular, twist.angular, angular_acceleration, seconds).0)
            }
            None => Twist::STOP,
        };
        let wheels = self.wheels();
        if self.told != Some(wheels) || self.spoke.is_none_or(|spoke| now.since(spoke) >= ALIVE) {
            Command::DriveDirect { right: wheels.0, left: wheels.1 }.emit(into);
            (self.told, self.spoke) = (Some(wheels), Some(now));
        }
    }

    /// What the base may do of what is wanted; `None` if it has to stand at once.
    fn permitted(&mut self, wanted: Twist) -> Option<Twist> {
        let touched = self.sensors.bumps() || self.sensors.cliff();
        if self.sensors.drops() {
            self.reflexes.must_rest = true;
        } else if wanted.is_stop() {
            self.reflexes.must_rest = false;
        }
        // What leads ahead is not cut to what it has of turning: that would be another curve.
        let blocked = touched && wanted.linear > 0.0;
        let stands = std::mem::take(&mut self.reflexes.startled) || self.reflexes.must_rest || blocked;
        (!stands).then_some(wanted)
    }

    /// Asks for Safe, if nothing speaks against it: motors never go on with a velocity that is still wanted.
    fn ask_for_motors(&mut self, now: Time, wanted: Twist, into: &mut Vec<u8>) {
        let past = |then: Option<Time>, limit| then.is_none_or(|then| now.since(then) >= limit);
        let is_down = !self.sensors.drops() && past(self.reflexes.dropped, PUT_DOWN);
        if is_down && wanted.is_stop() && past(self.reflexes.asked, SAFE_AGAIN) {
            Command::Safe.emit(into);
            self.reflexes.asked = Some(now);
        }
    }

    /// Speeds of the right and the left wheel, mm/s, on the same curve as the pace if one of them can't be as fast.
    fn wheels(&self) -> (i16, i16) {
        let half = self.pace.angular * self.profile.model.tread / 2.0;
        let (right, left) = (1000.0 * (self.pace.linear + half), 1000.0 * (self.pace.linear - half));
        let top = f64::from(TOP_SPEED);
        let share = (top / right.abs().max(left.abs())).min(1.0);
        // At most 500.
        #[allow(clippy::cast_possible_truncation)]
        let whole = |speed: f64| (speed * share).round() as i16;
        (whole(right), whole(left))
    }
}

impl Conversation for Session {
    const LANGUAGE: &'static str = "OI";
    const STRANGER: &'static str = "a Pioneer or AmigoBot";

    fn begin_anew(&mut self) {
        self.framer.reset();
        (self.state, self.since, self.attempts) = (State::Greeting, None, 0);
    }

    fn receive(&mut self, now: Time, bytes: &[u8]) {
        // The framer goes aside while it shows frames to the rest.
        let mut framer = std::mem::replace(&mut self.framer, Framer::new(&[]));
        let mut sensors = self.sensors;
        framer.push(bytes, &mut sensors, |sensors| self.hear(now, sensors));
        self.framer = framer;
    }

    fn transmit(&mut self, now: Time, into: &mut Vec<u8>) {
        let waited = |limit: Duration| self.since.is_none_or(|since| now.since(since) >= limit);
        match (self.state, self.since) {
            (State::Greeting, None) => self.greet(now, into),
            (State::Greeting, Some(_)) if waited(SETTLES) => {
                let packets: Vec<u8> = self.framer.packets().iter().map(|id| *id as u8).collect();
                Command::Stream(&packets).emit(into);
                (self.state, self.since) = (State::Opening, Some(now));
            }
            (State::Greeting, Some(_)) => {}
            (State::Opening, _) if waited(ANSWER) => self.greet(now, into),
            (State::Opening, _) => {}
            (State::Open, _) if waited(SILENCE) => self.greet(now, into),
            (State::Open, _) => self.steer(now, into),
        }
    }

    fn drive(&mut self, now: Time, twist: Twist) {
        (self.wanted, self.renewed) = (twist.within(self.profile.limits), Some(now));
    }

    fn halt(&mut self, into: &mut Vec<u8>) {
        (self.wanted, self.renewed, self.pace, self.told) = (Twist::STOP, None, Twist::STOP, None);
        into.extend(STOP);
    }

    fn close(&mut self, into: &mut Vec<u8>) {
        if self.state != State::Greeting {
            self.halt(into);
            Command::StreamRuns(false).emit(into);
            Command::Start.emit(into);
            self.begin_anew();
        }
    }

    fn stage(&self) -> Stage {
        match self.state {
            State::Greeting | State::Opening => Stage::Unanswered,
            State::Open => Stage::Open,
        }
    }

    fn unanswered(&self) -> u8 {
        self.attempts
    }

    fn odometry(&self) -> Option<Odometry> {
        self.readings.odometry()
    }

    fn counts(&self) -> Counts {
        self.framer.counts()
    }
}

#[cfg(test)]
mod tests;
