#![allow(clippy::unwrap_used)]

use super::*;
use crate::wire::arcos::{frame, information::flags};

/// A base on the other end of the wire: greets, speaks every 100 ms, and remembers what it was told.
struct Base {
    framer: Framer,
    /// How far the greeting has come; 3 in a session.
    step: u8,
    opened: bool,
    motors: bool,
    velocity: (i32, i32),
    firing: Vec<u8>,
    /// All commands since the last look.
    told: Vec<Code>,
    /// Accelerations and decelerations: along, and turning.
    limits: [i32; 4],
    model: &'static str,
}

impl Base {
    fn new(model: &'static str) -> Self {
        Self {
            framer: Framer::default(),
            step: 0,
            opened: false,
            motors: false,
            velocity: (0, 0),
            firing: Vec::new(),
            told: Vec::new(),
            limits: [0; 4],
            model,
        }
    }

    /// Hears bytes and answers.
    fn answer(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut answer = Vec::new();
        let mut framer = std::mem::take(&mut self.framer);
        framer.push(bytes, |frame| self.hear(frame, &mut answer));
        self.framer = framer;
        answer
    }

    fn hear(&mut self, frame: Frame<'_>, answer: &mut Vec<u8>) {
        if self.step < 3 {
            if frame.kind == self.step && frame.body.is_empty() {
                match self.step {
                    2 => Greeting { name: "lenny".into(), class: "Pioneer".into(), model: self.model.into() }.emit(answer),
                    step => emit_sync(step, answer),
                }
                self.step += 1;
            }
            return;
        }
        let command = Command::parse(frame).unwrap();
        self.told.push(command.code);
        match (command.code, command.argument) {
            (Code::Open, _) => self.opened = true,
            (Code::Close, _) => *self = Self { told: std::mem::take(&mut self.told), ..Self::new(self.model) },
            (Code::Enable, Argument::Integer(on)) => self.motors = on == 1,
            (Code::Velocity, Argument::Integer(speed)) => self.velocity.0 = speed,
            (Code::TurnRate, Argument::Integer(rate)) => self.velocity.1 = rate,
            (Code::Acceleration, Argument::Integer(limit)) => self.limits[usize::from(limit < 0)] = limit,
            (Code::AngularAcceleration, Argument::Integer(limit)) => self.limits[2 + usize::from(limit < 0)] = limit,
            (Code::Polling, Argument::Text(order)) => self.firing = order.to_vec(),
            _ => {}
        }
    }

    fn speak(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        if self.opened {
            let flags = if self.motors { flags::MOTORS } else { 0 };
            Information { flags, ..Information::default() }.emit(&mut bytes);
        }
        bytes
    }
}

fn profile() -> Profile {
    Profile { units: None, acceleration: 0.3, angular_acceleration: 1.7, transducers: 16, max_range: 5.0 }
}

/// Both ends, stepped every 10 ms.
struct Line {
    session: Session,
    base: Base,
    beat: u64,
    /// Nothing gets through from the base.
    deaf: bool,
}

impl Line {
    fn new(model: &'static str) -> Self {
        Self { session: Session::new(profile()), base: Base::new(model), beat: 0, deaf: false }
    }

    fn now(&self) -> Time {
        Time::START + Duration::from_millis(10 * self.beat)
    }

    fn beat(&mut self) {
        let now = self.now();
        let mut sent = Vec::new();
        self.session.transmit(now, &mut sent);
        let mut heard = self.base.answer(&sent);
        if self.beat.is_multiple_of(10) {
            heard.extend(self.base.speak());
        }
        if !self.deaf {
            self.session.receive(now, &heard);
        }
        self.beat += 1;
    }

    fn run(&mut self, seconds: f64) {
        (0..(seconds * 100.0) as u64).for_each(|_| self.beat());
    }

    fn drive(&mut self, seconds: f64, twist: Twist) {
        for _ in 0..(seconds * 100.0) as u64 {
            self.session.drive(self.now(), twist);
            self.beat();
        }
    }
}

const AHEAD: Twist = Twist::new(0.25, -0.5);

#[test]
fn a_session_opens_and_the_base_obeys() {
    let mut line = Line::new("p3dx-sh");
    line.run(0.3);
    assert_eq!(line.session.state(), State::Open);
    assert_eq!(line.session.greeting().map(|greeting| greeting.name.as_str()), Some("lenny"));
    assert!(line.base.motors && line.base.velocity == (0, 0));
    assert!(
        line.base.told.iter().position(|code| *code == Code::Velocity)
            < line.base.told.iter().position(|code| *code == Code::Enable)
    );
    line.drive(0.1, AHEAD);
    assert_eq!(line.base.velocity, (250, -29));
    line.drive(0.1, Twist::new(f64::INFINITY, 0.1));
    assert_eq!(line.base.velocity, (0, 0));
    assert!(line.session.readings().and_then(crate::arcos::Readings::odometry).is_some());
}

/// A base acknowledges nothing: whatever opens a session may have got lost.
#[test]
fn what_got_lost_on_opening_is_said_again() {
    let mut line = Line::new("p3dx-sh");
    while !line.base.opened {
        line.beat();
    }
    (line.base.limits, line.base.motors) = ([0; 4], false);
    line.run(2.0);
    assert_eq!(line.base.limits, [300, -300, 97, -97]);
    assert!(line.base.motors);
}

/// It is a person's right to switch motors off.
#[test]
fn motors_that_were_on_are_not_switched_on_again() {
    let mut line = Line::new("p3dx-sh");
    line.run(1.0);
    assert!(line.base.motors);
    line.base.motors = false;
    line.run(3.0);
    assert!(!line.base.motors);
}

#[test]
fn a_velocity_that_nobody_renews_is_taken_back() {
    let mut line = Line::new("p3dx-sh");
    line.drive(1.0, AHEAD);
    line.run(0.24);
    assert_eq!(line.base.velocity, (250, -29));
    line.run(0.03);
    assert_eq!(line.base.velocity, (0, 0));
}

/// Its watchdog would stop it after two seconds of silence.
#[test]
fn the_base_hears_something_five_times_a_second() {
    let mut line = Line::new("p3dx-sh");
    line.drive(1.0, Twist::STOP);
    line.base.told.clear();
    line.drive(2.0, Twist::STOP);
    assert_eq!(line.base.told.iter().filter(|code| **code == Code::Velocity).count(), 10);
}

#[test]
fn a_base_that_goes_silent_is_greeted_again_and_stands_until_then() {
    let mut line = Line::new("p3dx-sh");
    line.drive(1.0, AHEAD);
    line.deaf = true;
    line.drive(1.2, AHEAD);
    assert!(matches!(line.session.state(), State::Greeting(_)), "{:?}", line.session.state());
    assert!(!line.base.opened && line.base.velocity == (0, 0), "whoever can still hear has been told that it is over");
    line.deaf = false;
    line.drive(2.0, AHEAD);
    assert_eq!((line.session.state(), line.base.velocity), (State::Open, (250, -29)));
}

/// Whichever answer is lost.
#[test]
fn a_greeting_whose_answer_got_lost_begins_again() {
    for deaf_from in 0..6 {
        let mut line = Line::new("p3dx-sh");
        (0..deaf_from).for_each(|_| line.beat());
        line.deaf = true;
        line.run(0.3);
        line.deaf = false;
        line.drive(3.0, AHEAD);
        assert_eq!((line.session.state(), line.base.velocity), (State::Open, (250, -29)), "deaf from beat {deaf_from}");
    }
}

#[test]
fn a_base_in_a_session_that_somebody_has_left_is_fetched_out_of_it() {
    let mut line = Line::new("p3dx-sh");
    line.drive(1.0, AHEAD);
    // The client dies, and another comes.
    line.session = Session::new(profile());
    line.run(0.3);
    assert_eq!((line.session.state(), line.base.velocity), (State::Open, (0, 0)));
}

#[test]
fn a_model_that_nobody_knows_is_left_alone() {
    let mut line = Line::new("spaceship");
    line.drive(2.0, AHEAD);
    assert!(line.session.is_strange() && !line.base.opened && line.base.velocity == (0, 0));
    let mut line = Line::new("spaceship");
    line.session = Session::new(Profile { units: Units::of("p3dx"), ..profile() });
    line.drive(1.0, AHEAD);
    assert_eq!((line.session.is_strange(), line.base.velocity), (false, (250, -29)));
}

#[test]
fn noise_and_strange_packets_disturb_nobody() {
    let mut line = Line::new("p3dx-sh");
    for n in 0..200_u32 {
        let mut noise = n.wrapping_mul(2_654_435_761).to_le_bytes().to_vec();
        frame::emit(0x90, b"a gripper", &mut noise);
        let now = line.now();
        line.session.receive(now, &noise);
        line.session.drive(now, AHEAD);
        line.beat();
    }
    assert_eq!((line.session.state(), line.base.velocity), (State::Open, (250, -29)));
    assert!(line.session.counts().noise > 0);
}

#[test]
fn an_order_of_firing_is_told_in_every_session() {
    let mut line = Line::new("p3dx-sh");
    line.session.fire([0, 15]);
    for _ in 0..2 {
        line.run(1.0);
        assert_eq!(line.base.firing, [1, 16]);
        line.base = Base::new("p3dx-sh");
        line.session.begin_anew();
    }
}

#[test]
fn a_halt_is_said_at_once() {
    let mut line = Line::new("p3dx-sh");
    let mut early = Vec::new();
    line.session.halt(&mut early);
    assert!(early.is_empty(), "nobody is there yet");
    line.drive(1.0, AHEAD);
    let mut halt = Vec::new();
    line.session.halt(&mut halt);
    line.base.told.clear();
    line.base.answer(&halt);
    assert_eq!(line.base.told, [Code::Stop]);
    line.beat();
    assert_eq!(line.base.velocity, (0, 0));
    line.drive(0.1, AHEAD);
    assert_eq!(line.base.velocity, (250, -29), "what is wanted afterwards counts");
}

#[test]
fn a_session_ends_with_a_stop() {
    let mut line = Line::new("p3dx-sh");
    line.drive(1.0, AHEAD);
    let mut last = Vec::new();
    line.session.close(&mut last);
    line.base.told.clear();
    line.base.answer(&last);
    assert_eq!(line.base.told, [Code::Stop, Code::Close]);
}

/// Its way is counted in its own units: 1 mm instead of 0.485 mm.
#[test]
fn another_base_on_the_same_line_is_measured_in_its_own_units() {
    let mut line = Line::new("p3dx");
    line.run(0.5);
    (line.base, line.deaf) = (Base::new("p3dx-sh"), true);
    line.run(1.5);
    line.deaf = false;
    line.run(2.0);
    assert_eq!(line.session.state(), State::Open);
    let before = line.session.odometry().unwrap().travelled;
    let mut bytes = Vec::new();
    Information { x: 1000, flags: flags::MOTORS, ..Information::default() }.emit(&mut bytes);
    line.session.receive(line.now(), &bytes);
    let way = line.session.odometry().unwrap().travelled - before;
    assert!((way - 1.0).abs() < 1e-9, "{way} m");
}

#[test]
fn packets_that_are_not_understood_are_counted_and_told_from_silence() {
    let mut line = Line::new("p3dx-sh");
    line.run(0.5);
    let mut bytes = Vec::new();
    frame::emit(0x90, &[1, 2, 3], &mut bytes);
    line.session.receive(line.now(), &bytes);
    assert_eq!((line.session.counts().unknown, line.session.parse_error()), (1, None), "nobody asked for that");
    bytes.clear();
    frame::emit(0x32, &[1, 2, 3], &mut bytes);
    line.session.receive(line.now(), &bytes);
    assert_eq!(line.session.counts().unknown, 2);
    assert_eq!(line.session.parse_error().unwrap().to_string(), "the packet ends before its y");
    line.run(0.2);
    assert_eq!(line.session.parse_error(), None, "it is understood again");
}
