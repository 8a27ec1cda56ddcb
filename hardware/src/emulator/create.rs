//! A base that speaks iRobot's [Open Interface](crate::wire::oi).
//!
//! It obeys as its specification says. It listens to nothing but Start until it was started, and moves only in Safe and Full. In Safe it
//! goes to Passive when a wheel drops, or when the floor is missing where it is going. Its wheels take a speed at once; how fast they come
//! up to it is for the [body](CreateEmulator::body). **It has no watchdog**: it keeps its last speed for ever, whether anybody is at the
//! other end or not.
//!
//! What it has not: brushes, light bumpers, virtual walls, a charger. Commands to clean or to dock take it to Passive, where it stands.

mod senses;
mod wheels;

use orienteer_runtime::{geometry::Twist, time::Time, topics::Odometry};
use smallvec::SmallVec;

use super::Emulator;
use crate::{
    base::{kinematics::BaseConfig, presets},
    wire::{
        Counts,
        oi::{
            command::{Command, Listener},
            packet::{Id, members},
            sensors::Mode,
            stream::{self, PERIOD},
            units::Model,
        },
    },
};
use senses::Senses;
use wheels::Wheels;

/// How fast the wheels of an emulated base come up to their speed, m/s²: a fifth of a second to the greatest.
const WHEELS: f64 = 2.5;

/// An emulated Create or Roomba.
pub struct CreateEmulator {
    model: Model,
    listener: Listener,
    mode: Mode,
    wheels: Wheels,
    senses: Senses,
    /// It hangs in somebody's hand.
    lifted: bool,
    /// The floor is missing at the front.
    at_edge: bool,
    stream: Streaming,
    /// Answers that wait to be sent: what was asked for, packet by packet.
    asked: Vec<Id>,
}

/// What is sent each 15 ms.
#[derive(Debug, Clone, Default)]
struct Streaming {
    packets: SmallVec<[Id; 16]>,
    runs: bool,
    next: Time,
}

impl CreateEmulator {
    /// A base of this model that has just been switched on.
    #[must_use]
    pub fn new(model: Model) -> Self {
        Self {
            model,
            listener: Listener::default(),
            mode: Mode::Off,
            wheels: Wheels::new(model.tread),
            senses: Senses::new(),
            lifted: false,
            at_edge: false,
            stream: Streaming::default(),
            asked: Vec::new(),
        }
    }

    /// What such a base is and can do: its wheels follow quickly, and yet not at once.
    #[must_use]
    pub fn body() -> BaseConfig {
        let body = presets::create2();
        BaseConfig { acceleration: WHEELS, angular_acceleration: 2.0 * WHEELS / Model::CREATE_2.tread, ..body }
    }

    /// Lifts it, so that its wheels drop, or puts it down. A lifted base does not move.
    pub fn lift(&mut self, lifted: bool) {
        self.lifted = lifted;
    }

    /// Takes the floor away before its front, or puts it back.
    pub fn hold_at_edge(&mut self, at_edge: bool) {
        self.at_edge = at_edge;
    }

    /// Its mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    fn obey(&mut self, command: Command<'_>) {
        if self.mode == Mode::Off && command != Command::Start {
            return;
        }
        match command {
            Command::Start | Command::Spot | Command::Clean | Command::Max | Command::SeekDock => self.go_to(Mode::Passive),
            Command::Safe if self.lifted => self.go_to(Mode::Passive),
            Command::Safe => self.go_to(Mode::Safe),
            Command::Full => self.go_to(Mode::Full),
            Command::Power => {
                self.go_to(Mode::Passive);
                self.stream.runs = false;
            }
            Command::Stop | Command::Reset => {
                self.go_to(Mode::Off);
                self.stream = Streaming::default();
                if command == Command::Reset {
                    self.senses = Senses::new();
                }
            }
            Command::Sensors(packet) => self.ask(&[packet]),
            Command::QueryList(packets) => self.ask(packets),
            Command::Stream(packets) => {
                let known = packets.iter().filter_map(|number| Id::from_number(*number)).filter(|id| *id <= self.model.last);
                self.stream.packets = known.collect();
                self.stream.runs = true;
            }
            Command::StreamRuns(runs) => self.stream.runs = runs,
            Command::Drive { .. } | Command::DriveDirect { .. } | Command::DrivePwm { .. } if self.mode.obeys() => {
                self.wheels.obey(command);
            }
            Command::Song { .. } | Command::Play(_) | Command::Leds { .. } | Command::Baud(_) | Command::Other { .. } => {}
            Command::Drive { .. } | Command::DriveDirect { .. } | Command::DrivePwm { .. } => {}
        }
    }

    /// Whatever the wheels were told is forgotten where they are not to be told anything.
    fn go_to(&mut self, mode: Mode) {
        self.mode = mode;
        if !mode.obeys() {
            self.wheels.stand();
        }
    }

    /// Packets that this model has are answered, with nothing between them; of the others nobody hears anything.
    fn ask(&mut self, packets: &[u8]) {
        let last = self.model.last;
        let known = packets.iter().filter_map(|number| members(*number)).filter(|ids| ids.iter().all(|id| *id <= last)).flatten();
        self.asked.extend(known);
    }

    /// What Safe mode is for. The edge is ahead, and while the base turns one of its cliff sensors comes over it.
    fn protect_itself(&mut self) {
        let (right, left) = self.wheels.speeds();
        let over_the_edge = self.at_edge && (right > 0 || left > 0);
        if self.mode == Mode::Safe && (self.lifted || over_the_edge) {
            self.go_to(Mode::Passive);
        }
    }
}

impl Emulator for CreateEmulator {
    fn receive(&mut self, _now: Time, bytes: &[u8]) {
        let mut listener = std::mem::take(&mut self.listener);
        listener.push(bytes, |command| self.obey(command));
        self.listener = listener;
    }

    fn feel(&mut self, at: Option<f64>) {
        self.senses.touch(at);
    }

    fn drive(&mut self, _now: Time, odometry: &Odometry) -> Twist {
        self.senses.follow(odometry, self.model.tread);
        self.protect_itself();
        if self.lifted { Twist::STOP } else { self.wheels.twist() }
    }

    fn transmit(&mut self, now: Time, odometry: &Odometry, into: &mut Vec<u8>) {
        let Self { senses, stream, wheels, .. } = self;
        senses.note(now, self.mode, wheels, odometry.twist);
        senses.ground(self.lifted, self.at_edge);
        senses.streams(stream.packets.len());
        for id in self.asked.drain(..) {
            senses.sensors().emit(id, into);
            senses.told(id);
        }
        if !stream.runs || stream.packets.is_empty() || self.mode == Mode::Off {
            stream.next = now + PERIOD;
        } else if now >= stream.next {
            stream::emit(&stream.packets, senses.sensors(), into);
            stream.packets.iter().for_each(|id| senses.told(*id));
            // One that is late is followed by the next all the sooner, so that they come each 15 ms on average.
            stream.next = stream.next + PERIOD;
        }
    }

    fn counts(&self) -> Counts {
        self.listener.counts()
    }

    fn status(&self) -> String {
        match self.mode {
            Mode::Off => "off".to_owned(),
            Mode::Passive => "passive".to_owned(),
            Mode::Safe => "in safe mode".to_owned(),
            Mode::Full => "in full mode".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests;
