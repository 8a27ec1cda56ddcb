//! ARCOS: both ends of a Pioneer's wire.

use std::time::Duration;

use orienteer_hardware::{
    arcos::{Profile, Session},
    base::presets,
    emulator::{ArcosEmulator, Emulator, Make},
    line::Conversation,
    wire::arcos::{
        command::{Argument, Code, Command},
        frame::{self, Framer, HEADER},
        greeting::{Greeting, emit_sync},
        information::{Information, SonarReading},
        settings::Settings,
        units::Units,
    },
};
use orienteer_runtime::{time::Time, topics::Odometry};
use rand::{Rng, RngExt};
use rand_pcg::Pcg64;

use super::{BEHIND, Language, PORTION, Portion};

pub(super) struct Arcos;

impl Language for Arcos {
    const NAME: &'static str = "ARCOS";
    const LONGEST: f64 = 205.0;
    const MOVED: &'static str = "portions of noise by which an emulated base is moved";

    fn frames(random: &mut Pcg64, bytes: &mut Vec<u8>) {
        while bytes.len() < PORTION {
            let mut body = [0; frame::MOST];
            let length = random.random_range(0..frame::MOST);
            random.fill_bytes(&mut body[..length]);
            // Most kinds mean nothing; those that do shall come often.
            let kind = if random.random_bool(0.5) {
                random.random()
            } else {
                [0, 1, 2, 3, 11, 21, 0x20, 0x32, 0x33][random.random_range(0..9)]
            };
            frame::emit(kind, &body[..length], bytes);
        }
    }

    fn word(random: &mut Pcg64, into: &mut Vec<u8>) {
        let number = random.random_range(-70_000..70_000);
        match random.random_range(0..6) {
            0 => emit_sync(random.random_range(0..3), into),
            1 => Greeting { name: "a".into(), class: "Pioneer".into(), model: "p3dx-sh".into() }.emit(into),
            2 => Settings { watchdog: random.random(), name: "b".into(), ..Settings::default() }.emit(into),
            3 => information(random).emit(into),
            4 => {
                let text: [u8; 16] = random.random();
                Command::new(Code::Polling, Argument::Text(&text)).emit(into);
            }
            _ => Command::new(Code::ALL[random.random_range(0..Code::ALL.len())], Argument::Integer(number)).emit(into),
        }
    }

    fn listen(bytes: &[u8], portion: Portion) -> (u64, bool) {
        let mut framer = Framer::default();
        framer.push(bytes, |frame| {
            let _ = (Command::parse(frame).is_ok(), Information::parse(frame).is_ok());
            let _ = (Greeting::parse(frame).is_ok(), Settings::parse(frame).is_ok());
        });
        let profile =
            Profile { units: Units::of("p3dx"), acceleration: 0.3, angular_acceleration: 1.7, transducers: 16, max_range: 5.0 };
        let mut session = Session::new(profile);
        let mut emulator = emulator();
        let (mut now, mut sent, mut scans, mut moved) = (Time::START, Vec::new(), Vec::new(), false);
        for piece in bytes.chunks(97) {
            now = now + Duration::from_millis(10);
            session.receive(now, piece);
            session.transmit(now, &mut sent);
            if let Some(readings) = session.readings_mut() {
                readings.fetch(&mut scans);
            }
            emulator.receive(now, piece);
            moved |= !emulator.drive(now, &Odometry::default()).is_stop();
            let _ = emulator.firing();
            emulator.transmit(now, &Odometry::default(), &mut sent);
            sent.clear();
            scans.clear();
        }
        // Frames without noise around them may say anything, that it is to move included.
        (framer.counts().frames, moved && portion == Portion::Noise)
    }

    fn resume(random: &mut Pcg64, torn: bool) -> (usize, usize) {
        let mut framer = Framer::default();
        let mut garbage: Vec<u8> = (0..random.random_range(0..300)).map(|_| random.random()).collect();
        if torn {
            garbage.extend(HEADER);
            garbage.push(random.random());
        }
        framer.push(&garbage, |_| {});
        let packets: Vec<Information> = (0..BEHIND).map(|_| information(random)).collect();
        let (mut out, mut come, mut own, mut late) = (0, 0, 0, 0);
        for packet in &packets {
            let mut bytes = Vec::new();
            packet.emit(&mut bytes);
            if come == 0 {
                own = bytes.len();
            }
            for byte in bytes {
                come += 1;
                let before = out;
                framer.push(&[byte], |frame| {
                    out += usize::from(Information::parse(frame).as_ref() == Ok(&packets[out.min(BEHIND - 1)]))
                });
                if before == 0 && out > 0 {
                    late = come - own;
                }
            }
        }
        (BEHIND - out, late)
    }
}

fn information(random: &mut Pcg64) -> Information {
    let count = random.random_range(0..8);
    let sonars = (0..count).map(|_| SonarReading { transducer: random.random(), range: random.random() }).collect();
    Information {
        x: random.random(),
        y: random.random(),
        heading: random.random(),
        flags: random.random(),
        sonars,
        ..Information::default()
    }
}

fn emulator() -> ArcosEmulator {
    // Both names are built in.
    let (units, body) = (Units::of("p3dx-sh").unwrap_or(orienteer_hardware::wire::arcos::units::MODELS[0]), presets::p3dx());
    ArcosEmulator::new(Make::new(units, &body, 16))
}
