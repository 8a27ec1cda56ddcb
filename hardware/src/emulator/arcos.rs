//! A base that speaks [ARCOS](crate::wire::arcos).
//!
//! It obeys as its manual says: motors are off until they are enabled, speeds change by the accelerations that were set, and a base that
//! has heard nothing for the time of its watchdog stops, until it hears something again; then it goes on as it was told last.

mod feelings;
mod motors;

use std::time::Duration;

use orienteer_runtime::{
    geometry::{Pose, Twist},
    time::Time,
    topics::{FiringProgram, FixedVec, Odometry, SonarScan},
};

use super::Emulator;
use crate::{
    base::kinematics::BaseConfig,
    wire::{
        Counts,
        arcos::{
            command::{Argument, Code, Command},
            frame::{Frame, Framer},
            greeting::{Greeting, emit_sync},
            settings::Settings,
            units::Units,
        },
    },
};
use feelings::Feelings;
use motors::Motors;

/// What an emulated base is.
#[derive(Debug, Clone, PartialEq)]
pub struct Make {
    /// How it greets.
    pub greeting: Greeting,
    /// What it counts in.
    pub units: Units,
    /// What it says of itself when it is asked; the limits in it are kept, and so is the watchdog.
    pub settings: Settings,
}

impl Make {
    /// A base of this model with this body, which can't do more than the body can.
    #[must_use]
    pub fn new(units: Units, body: &BaseConfig, transducers: usize) -> Self {
        // What a body can do fits by far.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let whole = |number: f64| number.round().clamp(0.0, f64::from(u16::MAX)) as u16;
        let (speed, turn_rate) = (whole(body.speed * 1000.0), whole(body.turn_rate.to_degrees()));
        let (linear, angular) = (whole(body.acceleration * 1000.0), whole(body.angular_acceleration.to_degrees()));
        let greeting = Greeting { name: "emulated".into(), class: "Pioneer".into(), model: units.model.into() };
        let settings = Settings {
            class: greeting.class.clone(),
            model: greeting.model.clone(),
            serial_number: "0".into(),
            name: greeting.name.clone(),
            greatest_turn_rate: turn_rate,
            greatest_speed: speed,
            cycle: 100,
            front_sonar: transducers > 0,
            rear_sonar: transducers > 8,
            watchdog: 2000,
            top_turn_rate: turn_rate,
            top_speed: speed,
            angular_acceleration: angular,
            angular_deceleration: angular,
            acceleration: linear,
            deceleration: linear,
            sonar_cycle: 40,
            ..Settings::default()
        };
        Self { greeting, units, settings }
    }
}

/// How far a client has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The next greeting is of this number.
    Greeting(u8),
    /// In a session that was not opened yet: nothing is sent.
    Greeted,
    Open,
}

/// An emulated base that speaks ARCOS.
///
/// Its motors are off until they are enabled, its speeds change by the accelerations that were set, and when it has heard nothing for the
/// time of its watchdog it stops, until it hears something again.
pub struct ArcosEmulator {
    make: Make,
    framer: Framer,
    stage: Stage,
    /// Frames of a session that are no command.
    unknown: u64,
    /// When anything came that makes sense.
    heard: Time,
    motors: Motors,
    feelings: Feelings,
    /// Where positions are counted from; where the base is when it is looked at next, if there is none.
    origin: Option<Pose>,
    firing: Option<FiringProgram>,
    /// Answers that wait to be sent.
    answers: Vec<u8>,
}

impl ArcosEmulator {
    /// A base that waits to be greeted.
    #[must_use]
    pub fn new(make: Make) -> Self {
        Self {
            framer: Framer::default(),
            stage: Stage::Greeting(0),
            unknown: 0,
            heard: Time::START,
            motors: Motors::new(&make.settings, make.units),
            feelings: Feelings::new(&make),
            origin: None,
            firing: None,
            answers: Vec::new(),
            make,
        }
    }

    fn hear_frame(&mut self, now: Time, frame: Frame<'_>) {
        match self.stage {
            Stage::Greeting(step) => self.be_greeted(step, frame),
            Stage::Greeted | Stage::Open => {
                // Commands of another kind are not for this base, but somebody is there.
                self.heard = now;
                match Command::parse(frame) {
                    Ok(command) => self.obey(&command),
                    Err(_) => self.unknown += 1,
                }
            }
        }
    }

    fn be_greeted(&mut self, step: u8, frame: Frame<'_>) {
        // A greeting that comes twice was not heard to be answered: it begins again.
        let expected = frame.kind == step || frame.kind == 0;
        if !frame.body.is_empty() || !expected {
            return;
        }
        match frame.kind {
            2 => {
                self.make.greeting.emit(&mut self.answers);
                (self.stage, self.origin) = (Stage::Greeted, None);
            }
            step => {
                emit_sync(step, &mut self.answers);
                self.stage = Stage::Greeting(step + 1);
            }
        }
    }

    fn obey(&mut self, command: &Command<'_>) {
        let number = match command.argument {
            Argument::Integer(number) => number,
            Argument::None | Argument::Text(_) => 0,
        };
        match (command.code, command.argument) {
            (Code::Pulse | Code::Baud, _) => {}
            (Code::Open, _) => self.stage = Stage::Open,
            (Code::Close, _) => self.end_session(),
            (Code::Polling, Argument::Text(order)) => self.firing = Some(program(order)),
            (Code::Polling, _) => self.firing = Some(FiringProgram::default()),
            (Code::Sonar, _) => self.feelings.listen(number & 1 != 0),
            (Code::Settings, _) => self.make.settings.emit(&mut self.answers),
            (Code::Origin, _) => self.origin = None,
            _ => self.motors.obey(command, number),
        }
    }

    /// Where the base is, in the frame of the session.
    fn here(&mut self, odometry: &Odometry) -> Pose {
        if self.origin.is_none() {
            self.motors.begin_here();
        }
        self.origin.get_or_insert(odometry.pose).between(odometry.pose)
    }

    fn end_session(&mut self) {
        self.stage = Stage::Greeting(0);
        self.motors.switch_off();
    }
}

impl Emulator for ArcosEmulator {
    fn receive(&mut self, now: Time, bytes: &[u8]) {
        let mut framer = std::mem::take(&mut self.framer);
        framer.push(bytes, |frame| self.hear_frame(now, frame));
        self.framer = framer;
    }

    fn drive(&mut self, now: Time, odometry: &Odometry) -> Twist {
        let watchdog = Duration::from_millis(self.make.settings.watchdog.into());
        let alone = !watchdog.is_zero() && now.since(self.heard) >= watchdog;
        let here = self.here(odometry);
        self.motors.drive(now, here, alone)
    }

    fn firing(&mut self) -> Option<FiringProgram> {
        self.firing.take()
    }

    fn hear(&mut self, scan: &SonarScan) {
        self.feelings.hear(scan);
    }

    fn transmit(&mut self, now: Time, odometry: &Odometry, into: &mut Vec<u8>) {
        into.append(&mut self.answers);
        if self.stage == Stage::Open {
            let here = self.here(odometry);
            self.feelings.tell(now, odometry, here, &self.motors, into);
        }
    }

    fn counts(&self) -> Counts {
        Counts { unknown: self.unknown, ..self.framer.counts() }
    }

    fn status(&self) -> String {
        match self.stage {
            Stage::Greeting(_) => "waits for a client".to_owned(),
            Stage::Greeted => "greeted".to_owned(),
            Stage::Open if self.motors.are_on() => "in a session, motors on".to_owned(),
            Stage::Open => "in a session, motors off".to_owned(),
        }
    }
}

/// An order of firing in which transducers, counted from 1, fire one after the other, each array by itself: those of the first eight, and
/// those behind them.
fn program(order: &[u8]) -> FiringProgram {
    let transducers = || order.iter().filter_map(|number| number.checked_sub(1));
    let of = |array: u8| transducers().filter(move |transducer| transducer / 8 == array).map(|transducer| 1 << transducer);
    let arrays: Vec<Vec<u32>> = (0..4).map(|array| of(array).collect()).collect();
    let longest = arrays.iter().map(Vec::len).max().unwrap_or(0).min(MAX_SLOTS);
    let mut slots = FixedVec::filled(0, longest);
    for (i, slot) in slots.iter_mut().enumerate() {
        // The shorter list comes round more often.
        *slot = arrays.iter().filter(|array| !array.is_empty()).fold(0, |slot, array| slot | array[i % array.len()]);
    }
    FiringProgram { slots, period: 0.0, rings: 1 }
}

const MAX_SLOTS: usize = orienteer_runtime::topics::MAX_TRANSDUCERS;

#[cfg(test)]
mod tests;
