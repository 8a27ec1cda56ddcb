//! iRobot's Open Interface: both ends of a Create's wire.
//!
//! Its commands have no checksum, so noise does move a base. What noise must not do is to make a wheel faster than it can be, nor a
//! client's session move a base that nobody told it to.

use std::time::Duration;

use orienteer_hardware::{
    base::presets,
    emulator::{CreateEmulator, Emulator},
    line::Conversation,
    oi::{Profile, Session},
    wire::oi::{
        command::{Command, Listener},
        packet::Id,
        sensors::Sensors,
        stream::{self, Framer},
        units::Model,
    },
};
use orienteer_runtime::{time::Time, topics::Odometry};
use rand::{Rng, RngExt};
use rand_pcg::Pcg64;

use super::{BEHIND, Language, PORTION, Portion};

/// What a Create 2 is asked for.
const PACKETS: &[Id] = Model::CREATE_2.packets;
/// No wheel is faster, m/s, whatever it is told.
const FASTEST: f64 = 0.5;

pub(super) struct OpenInterface;

impl Language for OpenInterface {
    const NAME: &'static str = "OI";
    const LONGEST: f64 = stream::LONGEST as f64;
    const MOVED: &'static str = "portions by which a session moves its base unasked, or a base moves too fast";

    fn frames(random: &mut Pcg64, bytes: &mut Vec<u8>) {
        while bytes.len() < PORTION {
            stream::emit(PACKETS, &sensors(random), bytes);
        }
    }

    fn word(random: &mut Pcg64, into: &mut Vec<u8>) {
        let list: [u8; 9] = random.random();
        match random.random_range(0..8) {
            0 => Command::Start.emit(into),
            1 => [Command::Safe, Command::Full][random.random_range(0..2)].emit(into),
            2 => Command::Drive { velocity: random.random(), radius: random.random() }.emit(into),
            3 => Command::DriveDirect { right: random.random(), left: random.random() }.emit(into),
            4 => Command::QueryList(&list).emit(into),
            5 => Command::Stream(&PACKETS.iter().map(|id| *id as u8).collect::<Vec<_>>()).emit(into),
            6 => Command::Song { number: list[0], notes: list.as_chunks::<2>().0 }.emit(into),
            _ => stream::emit(PACKETS, &sensors(random), into),
        }
    }

    fn listen(bytes: &[u8], _portion: Portion) -> (u64, bool) {
        let (mut framer, mut listener, mut said) = (Framer::new(PACKETS), Listener::default(), Listener::default());
        framer.push(bytes, &mut Sensors::default(), |_| {});
        listener.push(bytes, |_| {});
        let mut session = Session::new(Profile::new(Model::CREATE_2, &presets::create2().platform()));
        let mut emulator = CreateEmulator::new(Model::CREATE_2);
        let (mut now, mut sent, mut wrong) = (Time::START, Vec::new(), false);
        for piece in bytes.chunks(97) {
            now = now + Duration::from_millis(10);
            session.receive(now, piece);
            sent.clear();
            session.transmit(now, &mut sent);
            said.push(&sent, |command| {
                wrong |= matches!(command, Command::DriveDirect { right, left } if (right, left) != (0, 0));
            });
            emulator.receive(now, piece);
            let twist = emulator.drive(now, &Odometry::default());
            let half = twist.angular.abs() * Model::CREATE_2.tread / 2.0;
            wrong |= twist.linear.abs() + half > FASTEST + 1e-9;
            sent.clear();
            emulator.transmit(now, &Odometry::default(), &mut sent);
        }
        (framer.counts().frames, wrong)
    }

    fn resume(random: &mut Pcg64, torn: bool) -> (usize, usize) {
        // A frame that was torn before one of its last bytes is made whole by the next one in one of 256 cases, and nobody could tell.
        loop {
            if let Some(resumed) = resume(random, torn) {
                return resumed;
            }
        }
    }
}

/// `None` if a frame came out that nobody has sent.
fn resume(random: &mut Pcg64, torn: bool) -> Option<(usize, usize)> {
    let mut framer = Framer::new(PACKETS);
    let mut garbage: Vec<u8> = (0..random.random_range(0..300)).map(|_| random.random()).collect();
    if torn {
        let before = garbage.len();
        stream::emit(PACKETS, &sensors(random), &mut garbage);
        garbage.truncate(random.random_range(before..garbage.len()));
    }
    let mut heard = Sensors::default();
    framer.push(&garbage, &mut heard, |_| {});
    let (mut out, mut come, mut late) = (0, 0, 0);
    for _ in 0..BEHIND {
        let (sent, mut bytes) = (sensors(random), Vec::new());
        stream::emit(PACKETS, &sent, &mut bytes);
        let own = bytes.len();
        for byte in bytes {
            come += 1;
            let before = out;
            framer.push(&[byte], &mut heard, |heard| out += usize::from(*heard == sent));
            if before == 0 && out > 0 {
                late = come - own;
            }
        }
    }
    (framer.counts().frames == out as u64).then_some((BEHIND - out, late))
}

/// What a Create 2 is asked for, with anything in it that can be.
fn sensors(random: &mut Pcg64) -> Sensors {
    let mut sensors = Sensors::default();
    for id in PACKETS {
        let mut bytes = [0; 2];
        random.fill_bytes(&mut bytes);
        if *id == Id::Mode {
            bytes[0] %= 4;
        }
        // Every byte is one that its packet may have.
        let _ = sensors.read(&[*id], &bytes[..id.size()]);
    }
    sensors
}
