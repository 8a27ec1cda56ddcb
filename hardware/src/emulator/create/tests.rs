#![allow(clippy::unwrap_used)]

use orienteer_runtime::{geometry::Pose, random::Streams, topics::flags};

use super::*;
use crate::{
    base::odometry::OdometryConfig,
    emulator::Rig,
    line::Conversation,
    oi::{Profile, STOP, Session, State},
    sim::{Arena, SimBase, SimBodyConfig},
    wire::oi::{
        packet,
        sensors::{Sensors, bumps},
        stream::Framer,
    },
    world::World,
};

const WORLD: &str = "
name = 'hall'
[[room]]
corners = [[0.0, 0.0], [40.0, 0.0], [40.0, 4.0], [0.0, 4.0]]
";

/// A Create in the left part of a hall of 40 × 4 m.
fn rig(model: &str, start: Pose) -> Rig<CreateEmulator> {
    let plan = toml::from_str(WORLD).unwrap();
    let arena = Arena::new(World::from_plan(&plan, &|_| unreachable!()).unwrap(), Streams::new(1)).unwrap();
    let base = CreateEmulator::body();
    let config = SimBodyConfig { base: base.clone(), odometry: OdometryConfig::exact() };
    let body = arena.add("create", start, config).unwrap();
    Rig::new(CreateEmulator::new(Model::of(model).unwrap()), arena, SimBase::new(body, base.platform()), None)
}

fn along_the_hall() -> Pose {
    Pose::new(2.0, 2.0, 0.0)
}

/// Both ends of the wire, in simulated time.
struct Both {
    rig: Rig<CreateEmulator>,
    session: Session,
    back: Vec<u8>,
    cut: bool,
}

impl Both {
    fn new(model: &str, start: Pose) -> Self {
        let profile = Profile::new(Model::of(model).unwrap(), &presets::create2().platform());
        let mut both = Self { rig: rig(model, start), session: Session::new(profile), back: vec![], cut: false };
        both.drive(1.0, Twist::STOP);
        assert_eq!((both.session.state(), both.rig.emulator().mode()), (State::Open, Mode::Safe), "{model}");
        both
    }

    fn beat(&mut self) {
        let now = self.rig.now();
        let mut sent = Vec::new();
        self.session.transmit(now, &mut sent);
        self.back.clear();
        if self.cut {
            sent.clear();
        }
        self.rig.beat(&sent, &mut self.back);
        if self.cut {
            self.back.clear();
        }
        self.session.receive(self.rig.now(), &self.back);
    }

    fn drive(&mut self, seconds: f64, twist: Twist) {
        for _ in 0..(seconds * 100.0).round() as u64 {
            self.session.drive(self.rig.now(), twist);
            self.beat();
        }
    }

    fn odometry(&self) -> Odometry {
        self.session.readings().odometry().unwrap()
    }

    fn speed(&self) -> f64 {
        self.rig.truth().twist.linear
    }

    /// Drives until something happens.
    fn until(&mut self, twist: Twist, happens: impl Fn(&Self) -> bool) {
        for _ in 0..10_000 {
            if happens(self) {
                return;
            }
            self.drive(0.01, twist);
        }
        panic!("nothing happens");
    }
}

const AHEAD: Twist = Twist { linear: 0.3, angular: 0.0 };

#[test]
fn the_driver_s_odometry_is_what_the_body_did() {
    for model in ["create2", "roomba", "create1"] {
        let mut both = Both::new(model, along_the_hall());
        both.drive(30.0, Twist::new(0.4, 0.0));
        both.drive(3.0, Twist::new(0.2, 0.35));
        both.drive(2.0, Twist::new(-0.1, -0.5));
        both.drive(1.0, Twist::STOP);
        let (truth, odometry) = (both.rig.truth(), both.odometry());
        let moved = along_the_hall().between(truth.pose);
        assert!(moved.x > 11.0 && truth.collisions == 0, "{model}: {truth:?}");
        // Create 1 counts its turns in degrees.
        let (far, turned) = if model == "create1" { (0.25, 0.02) } else { (0.01, 0.005) };
        assert!(moved.distance(&odometry.pose) < far, "{model}: {moved:?} {:?}", odometry.pose);
        assert!((moved.heading - odometry.pose.heading).abs() < turned && truth.twist.is_stop(), "{model}: {truth:?}");
        assert!((odometry.battery - 14.4).abs() < 1e-6 && odometry.flags == flags::ENABLED, "{odometry:?}");
    }
}

/// Through zero on the way back, and through their end after 29 m.
#[test]
fn counters_wrap_in_the_middle_of_a_drive() {
    let mut both = Both::new("create2", along_the_hall());
    both.drive(2.0, Twist::new(-0.2, 0.0));
    both.drive(76.0, Twist::new(0.4, 0.0));
    both.drive(1.0, Twist::STOP);
    let moved = along_the_hall().between(both.rig.truth().pose);
    assert!(moved.x > 29.5, "65536 counts are 29.14 m: {moved:?}");
    assert!(moved.distance(&both.odometry().pose) < 0.02, "{moved:?} {:?}", both.odometry().pose);
}

#[test]
fn measured_speeds_are_those_of_the_body() {
    let mut both = Both::new("create2", along_the_hall());
    both.drive(3.0, Twist::new(0.3, 0.4));
    for _ in 0..100 {
        both.drive(0.01, Twist::new(0.3, 0.4));
        let (measured, truth) = (both.odometry().twist, both.rig.truth().twist);
        assert!(
            (measured.linear - truth.linear).abs() < 0.006 && (measured.angular - truth.angular).abs() < 0.06,
            "{measured:?}"
        );
    }
}

#[test]
fn a_bump_is_felt_where_it_is_and_stops_the_base_at_once() {
    // Headings at which the wall on the left of the hall is met with the left, with both halves, and with the right.
    for (degrees, felt) in [(30.0_f64, bumps::LEFT), (90.0, bumps::LEFT | bumps::RIGHT), (150.0, bumps::RIGHT)] {
        let mut both = Both::new("create2", Pose::new(5.0, 3.0, degrees.to_radians()));
        both.until(AHEAD, |both| both.rig.truth().collisions > 0);
        // The wall has stopped the body. Were it soft, the wheels would be told to stand within a frame and the way of the bytes.
        let beats = (0..).position(|_| {
            both.session.drive(both.rig.now(), AHEAD);
            both.beat();
            both.rig.emulator().wheels.speeds() == (0, 0)
        });
        assert!(beats.is_some_and(|beats| beats <= 3), "{beats:?} beats of 10 ms");
        assert_eq!(both.rig.emulator().senses.sensors().bumps_and_drops, felt, "{degrees}");
        let touched = flags::ENABLED | flags::CONTACT | flags::CONTACT_AHEAD;
        assert_eq!(both.odometry().flags, touched, "{degrees}: a touch is no stall");
        // Ahead is blocked, back is not, and away from the wall all is well.
        both.drive(1.0, AHEAD);
        assert_eq!(both.rig.emulator().wheels.speeds(), (0, 0));
        for _ in 0..200 {
            both.drive(0.01, Twist::new(-0.1, 0.0));
            assert_eq!(both.odometry().flags & flags::STALLED, 0, "it is free to go back");
        }
        assert!(both.speed() < -0.09 && both.odometry().flags == flags::ENABLED, "{:?}", both.odometry());
    }
}

#[test]
fn behind_there_is_no_bumper_but_wheels_that_strain() {
    let mut both = Both::new("create2", Pose::new(1.0, 2.0, 0.0));
    both.drive(5.0, Twist::new(-0.3, 0.0));
    assert_eq!(both.rig.truth().collisions, 1);
    assert_eq!(both.odometry().flags, flags::ENABLED | flags::STALLED);
    both.drive(1.0, Twist::STOP);
    assert_eq!(both.odometry().flags, flags::ENABLED);
}

#[test]
fn a_base_that_is_lifted_stands_and_goes_on_when_it_is_put_down() {
    let mut both = Both::new("create2", along_the_hall());
    both.drive(2.0, AHEAD);
    both.rig.emulator_mut().lift(true);
    both.drive(0.03, AHEAD);
    assert_eq!(both.rig.emulator().mode(), Mode::Passive);
    both.drive(0.3, AHEAD);
    assert!(both.speed() == 0.0 && both.odometry().flags & flags::EMERGENCY_STOP != 0);
    both.rig.emulator_mut().lift(false);
    both.drive(3.0, AHEAD);
    assert_eq!(both.speed(), 0.0, "nobody has told it to stand");
    both.drive(2.0, Twist::STOP);
    assert_eq!((both.rig.emulator().mode(), both.odometry().flags), (Mode::Safe, flags::ENABLED));
    both.drive(2.0, AHEAD);
    assert!((both.speed() - 0.3).abs() < 1e-3);
}

#[test]
fn at_an_edge_it_goes_no_further_and_backs_off() {
    let mut both = Both::new("create2", along_the_hall());
    both.drive(2.0, AHEAD);
    both.rig.emulator_mut().hold_at_edge(true);
    both.drive(0.5, AHEAD);
    assert!(both.speed() == 0.0 && both.odometry().flags & flags::CONTACT != 0);
    both.drive(1.0, Twist::STOP);
    assert_eq!(
        (both.rig.emulator().mode(), both.odometry().flags),
        (Mode::Safe, flags::ENABLED | flags::CONTACT | flags::CONTACT_AHEAD)
    );
    both.drive(1.0, AHEAD);
    assert_eq!((both.speed(), both.rig.emulator().mode()), (0.0, Mode::Safe), "it was not even told to");
    both.drive(1.0, Twist::new(-0.05, 0.0));
    assert!(both.speed() < -0.04);
}

/// It has no watchdog: who falls silent has to be spoken for.
#[test]
fn a_line_that_is_cut_leaves_it_going_until_it_is_mended() {
    let mut both = Both::new("create2", along_the_hall());
    both.drive(2.0, AHEAD);
    both.cut = true;
    both.drive(10.0, AHEAD);
    assert!(both.session.state() != State::Open && (both.speed() - 0.3).abs() < 1e-3, "{}", both.speed());
    let before = both.odometry();
    both.cut = false;
    both.until(AHEAD, |both| both.session.state() == State::Open);
    both.drive(0.02, AHEAD);
    let (right, left) = both.rig.emulator().wheels.speeds();
    assert!(right == left && (0..20).contains(&right), "it begins standing: {right} mm/s");
    let after = both.odometry();
    assert!(before.pose.distance(&after.pose) < 0.05, "what it did alone nobody has counted: {before:?} {after:?}");
    both.drive(2.0, AHEAD);
    assert!((both.speed() - 0.3).abs() < 1e-3);
}

/// Somebody who knows nothing of sessions.
fn told(rig: &mut Rig<CreateEmulator>, said: &[u8], seconds: f64) -> Vec<u8> {
    let mut back = Vec::new();
    rig.beat(said, &mut back);
    (1..(seconds * 100.0).round() as u64).for_each(|_| rig.beat(&[], &mut back));
    back
}

#[test]
fn it_moves_only_in_safe_and_full_and_keeps_its_speed() {
    let mut rig = rig("create2", along_the_hall());
    let ahead = [145, 0, 200, 0, 200];
    let mut goes = |said: &[u8], seconds| {
        told(&mut rig, said, seconds);
        (rig.truth().twist.linear, rig.emulator().status())
    };
    assert_eq!(goes(&ahead, 1.0), (0.0, "off".into()));
    assert_eq!(goes(&[131], 1.0), (0.0, "off".into()));
    assert_eq!(goes(&[128], 1.0), (0.0, "passive".into()));
    assert_eq!(goes(&ahead, 1.0), (0.0, "passive".into()));
    assert_eq!(goes(&[131], 1.0), (0.0, "in safe mode".into()), "what it was told before is forgotten");
    assert_eq!(goes(&ahead, 30.0), (0.2, "in safe mode".into()), "no watchdog");
    assert_eq!(goes(&STOP, 1.0), (0.0, "in safe mode".into()));
    assert_eq!(goes(&[132, 145, 0, 200, 0, 200], 1.0), (0.2, "in full mode".into()));
    assert_eq!(goes(&[135], 1.0), (0.0, "passive".into()), "it does not clean");
    assert_eq!(goes(&[132, 137, 0xFF, 0x38, 0x80, 0], 1.0), (-0.2, "in full mode".into()));
    assert_eq!(goes(&[173], 1.0), (0.0, "off".into()));
}

#[test]
fn in_full_mode_it_looks_after_nothing() {
    let mut rig = rig("create2", along_the_hall());
    told(&mut rig, &[128, 132, 145, 0, 200, 0, 200], 1.0);
    rig.emulator_mut().hold_at_edge(true);
    told(&mut rig, &[], 1.0);
    assert_eq!(rig.truth().twist.linear, 0.2);
    rig.emulator_mut().lift(true);
    told(&mut rig, &[], 1.0);
    assert_eq!((rig.truth().twist.linear, rig.emulator().mode()), (0.0, Mode::Full), "its wheels turn in the air");
}

#[test]
fn questions_are_answered_and_streams_come_each_15_ms() {
    let mut rig = rig("create2", along_the_hall());
    assert_eq!(told(&mut rig, &[142, 35], 0.1), b"", "off");
    assert_eq!(told(&mut rig, &[128, 142, 35], 0.1), [1]);
    assert_eq!(told(&mut rig, &[149, 2, 22, 35], 0.1), [0x38, 0x40, 1]);
    for group in [0, 1, 2, 3, 4, 5, 6, 100, 101, 106, 107] {
        assert_eq!(Some(told(&mut rig, &[142, group], 0.1).len()), packet::size(group));
    }
    assert_eq!(told(&mut rig, &[142, 59], 0.1), b"", "there is none");
    let mut framer = Framer::new(&[Id::Mode, Id::Voltage]);
    let mut frames = |bytes: &[u8]| {
        let before = framer.counts().frames;
        framer.push(bytes, &mut Sensors::default(), |_| {});
        framer.counts().frames - before
    };
    let seconds = frames(&told(&mut rig, &[148, 2, 35, 22], 15.0));
    assert!((999..=1000).contains(&seconds), "{seconds} frames in 15 s");
    assert_eq!(told(&mut rig, &[150, 0], 1.0), b"");
    let seconds = frames(&told(&mut rig, &[150, 1], 1.5));
    assert!((99..=100).contains(&seconds), "{seconds} frames in 1.5 s");
}

#[test]
fn way_and_turn_count_from_when_they_were_told_and_lose_nothing() {
    let mut rig = rig("create2", along_the_hall());
    told(&mut rig, &[128, 131, 145, 0, 100, 0, 100], 0.5);
    let mut way = 0;
    for _ in 0..100 {
        let back = told(&mut rig, &[149, 2, 19, 20], 0.03);
        let [high, low, 0, 0] = back[..] else { panic!("{back:?}") };
        way += i32::from(i16::from_be_bytes([high, low]));
    }
    let travelled = 1000.0 * (rig.truth().pose.x - 2.0);
    assert!((f64::from(way) - travelled).abs() < 5.0, "{way} mm, {travelled} mm");
}

#[test]
fn create_1_knows_nothing_of_encoders() {
    let mut rig = rig("create1", along_the_hall());
    assert_eq!(told(&mut rig, &[128, 149, 3, 43, 35, 58], 0.1), [1]);
    assert_eq!(told(&mut rig, &[142, 6], 0.1).len(), 52);
    assert_eq!(told(&mut rig, &[142, 100], 0.1), b"");
}
