#![allow(clippy::unwrap_used)]

use std::f64::consts::FRAC_PI_2;

use orienteer_runtime::{geometry::Pose, random::Streams, topics::Echo};

use super::*;
use crate::{
    arcos::{Profile, Session, State},
    base::{odometry::OdometryConfig, presets},
    emulator::Rig,
    line::Conversation,
    rings,
    sim::{Arena, SimBase, SimBodyConfig, SimSonar},
    world::World,
};

const WORLD: &str = "
name = 'hall'
[[room]]
corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 4.0], [0.0, 4.0]]
";

/// A Pioneer in the middle of the left half of a hall of 10 × 4 m, which looks along it.
fn rig(model: &str) -> Rig<ArcosEmulator> {
    let plan = toml::from_str(WORLD).unwrap();
    let arena = Arena::new(World::from_plan(&plan, &|_| unreachable!()).unwrap(), Streams::new(1)).unwrap();
    let base = presets::by_name("p3dx").unwrap();
    let ring = rings::find("p3dx-16").unwrap();
    let config = SimBodyConfig { base: base.clone(), odometry: OdometryConfig::exact() };
    let body = arena.add("pioneer", Pose::new(2.0, 2.0, 0.0), config).unwrap();
    let make = Make::new(Units::of(model).unwrap(), &base, 16);
    let sonar = SimSonar::new(arena.clone(), "pioneer", body.clone(), ring.ring, &ring.model).unwrap();
    Rig::new(ArcosEmulator::new(make), arena, SimBase::new(body, base.platform()), sonar)
}

/// Both ends of the wire, in simulated time.
struct Both {
    rig: Rig<ArcosEmulator>,
    session: Session,
    sent: Vec<u8>,
    back: Vec<u8>,
    scans: Vec<SonarScan>,
    /// Sent once, beside what the session says.
    extra: Vec<u8>,
}

impl Both {
    fn new(model: &str) -> Self {
        let profile = Profile { units: None, acceleration: 0.3, angular_acceleration: 1.745, transducers: 16, max_range: 5.0 };
        let session = Session::new(profile);
        Self { rig: rig(model), session, sent: vec![], back: vec![], scans: vec![], extra: vec![] }
    }

    fn beat(&mut self) {
        let now = self.rig.now();
        self.sent.clear();
        self.session.transmit(now, &mut self.sent);
        self.sent.append(&mut self.extra);
        self.back.clear();
        self.rig.beat(&self.sent, &mut self.back);
        self.session.receive(self.rig.now(), &self.back);
        if let Some(readings) = self.session.readings_mut() {
            readings.fetch(&mut self.scans);
        }
    }

    fn run(&mut self, seconds: f64) {
        (0..(seconds * 100.0).round() as u64).for_each(|_| self.beat());
    }

    fn drive(&mut self, seconds: f64, twist: Twist) {
        for _ in 0..(seconds * 100.0).round() as u64 {
            self.session.drive(self.rig.now(), twist);
            self.beat();
        }
    }

    fn odometry(&mut self) -> Odometry {
        self.session.readings().and_then(|readings| readings.odometry()).unwrap()
    }
}

#[test]
fn the_driver_s_odometry_is_what_the_body_did() {
    for model in ["p3dx-sh", "p3dx", "p2dx"] {
        let mut both = Both::new(model);
        both.run(0.5);
        assert_eq!(both.session.state(), State::Open, "{model}");
        both.drive(10.0, Twist::new(0.3, 0.0));
        both.drive(3.0, Twist::new(0.2, 0.35));
        both.run(3.0);
        let (truth, odometry) = (both.rig.truth(), both.odometry());
        let moved = Pose::new(2.0, 2.0, 0.0).between(truth.pose);
        assert!(moved.x > 3.0, "{model}: {moved:?}");
        assert!(moved.distance(&odometry.pose) < 0.01, "{model}: {moved:?} {:?}", odometry.pose);
        assert!((moved.heading - odometry.pose.heading).abs() < 0.01 && truth.twist.is_stop(), "{model}: {truth:?}");
    }
}

#[test]
fn sonars_hear_the_walls_a_few_in_each_packet() {
    let mut both = Both::new("p3dx-sh");
    both.run(3.0);
    let last = both.scans.last().unwrap();
    // The first looks squarely at the wall to the left, and stands 13.6 cm from the middle.
    let Echo::Range(left) = last.echo(0) else { panic!("{last:?}") };
    assert!(last.len() == 16 && (left - 1.864).abs() < 0.03, "{last:?}");
    let heard = both.scans.iter().skip(10).map(|scan| scan.fired.count_ones());
    assert!(heard.clone().all(|heard| matches!(heard, 4 | 6)), "100 ms are two or three shots of each array");
    // Only two are asked for.
    both.session.fire([0, 8]);
    both.run(1.0);
    both.scans.clear();
    both.run(1.0);
    assert_eq!(both.scans.iter().fold(0, |all, scan| all | scan.fired), 1 | 1 << 8);
}

#[test]
fn a_client_that_falls_silent_is_watched_for_two_seconds() {
    let mut both = Both::new("p3dx-sh");
    both.drive(5.0, Twist::new(0.3, 0.0));
    let rig = &mut both.rig;
    for beat in 0..400 {
        rig.beat(&[], &mut Vec::new());
        let speed = rig.truth().twist.linear;
        match beat {
            0..175 => assert!(speed > 0.29, "{beat}: {speed}"),
            305.. => assert!(speed == 0.0, "{beat}: {speed}"),
            _ => {}
        }
    }
}

#[test]
fn motors_are_off_until_they_are_enabled_and_after_the_session() {
    let mut rig = rig("p3dx-sh");
    let mut said = Vec::new();
    for number in 0..3 {
        emit_sync(number, &mut said);
    }
    Command::new(Code::Open, Argument::None).emit(&mut said);
    Command::new(Code::Velocity, Argument::Integer(300)).emit(&mut said);
    rig.beat(&said, &mut Vec::new());
    let go_on = |rig: &mut Rig<ArcosEmulator>, code, argument| {
        let mut said = Vec::new();
        Command::new(code, argument).emit(&mut said);
        rig.beat(&said, &mut Vec::new());
        (0..100).for_each(|_| rig.beat(&[], &mut Vec::new()));
        rig.truth().twist.linear
    };
    assert_eq!(go_on(&mut rig, Code::Pulse, Argument::None), 0.0);
    assert!(rig.emulator().status().contains("motors off"));
    assert!(go_on(&mut rig, Code::Enable, Argument::Integer(1)) > 0.25);
    assert_eq!(go_on(&mut rig, Code::EmergencyStop, Argument::None), 0.0);
    assert!(go_on(&mut rig, Code::Velocity, Argument::Integer(-300)) < -0.25);
    assert_eq!(go_on(&mut rig, Code::Close, Argument::None), 0.0);
    assert_eq!(go_on(&mut rig, Code::Velocity, Argument::Integer(300)), 0.0, "that is no greeting");
    assert_eq!(rig.emulator().status(), "waits for a client");
}

/// What other clients use: ways, headings, wheels, and their own accelerations.
#[test]
fn ways_and_turns_end_where_they_should() {
    let mut both = Both::new("p3dx-sh");
    both.run(0.5);
    // The session itself would say its velocity; a client that says nothing is left by the session's state alone.
    let raw = |both: &mut Both, code, number, seconds: f64| {
        let mut said = Vec::new();
        Command::new(code, Argument::Integer(number)).emit(&mut said);
        both.rig.beat(&said, &mut Vec::new());
        for beat in 0..(seconds * 100.0) as u64 {
            let mut pulse = Vec::new();
            if beat % 50 == 0 {
                Command::new(Code::Pulse, Argument::None).emit(&mut pulse);
            }
            both.rig.beat(&pulse, &mut Vec::new());
        }
        both.rig.truth().pose
    };
    let pose = raw(&mut both, Code::Move, 1000, 10.0);
    assert!((pose.x - 3.0).abs() < 0.01, "{pose:?}");
    let pose = raw(&mut both, Code::Heading, 90, 6.0);
    assert!((pose.heading - FRAC_PI_2).abs() < 0.02, "{pose:?}");
    let pose = raw(&mut both, Code::HeadingChange, -90, 6.0);
    assert!(pose.heading.abs() < 0.02, "{pose:?}");
    let pose = raw(&mut both, Code::Move, -500, 10.0);
    assert!((pose.x - 2.5).abs() < 0.02, "{pose:?}");
    raw(&mut both, Code::Acceleration, 100, 0.1);
    raw(&mut both, Code::Velocity, 300, 1.0);
    let slow = both.rig.truth().twist.linear;
    assert!((slow - 0.1).abs() < 0.02, "{slow} after a second at 0.1 m/s²");
}

#[test]
fn a_wall_is_felt_as_a_stall() {
    let mut both = Both::new("p3dx-sh");
    // Straight on until it hits; the session knows nothing of walls.
    both.drive(40.0, Twist::new(0.3, 0.0));
    assert_eq!(both.rig.truth().collisions, 1);
    let stalls = |both: &mut Both| both.odometry().flags & orienteer_runtime::topics::flags::STALLED != 0;
    assert!(stalls(&mut both));
    // It rests there, backs off, and is free to do so.
    both.run(2.0);
    assert!(!stalls(&mut both) && both.rig.truth().twist.is_stop());
    both.drive(2.0, Twist::new(-0.2, 0.0));
    assert!(!stalls(&mut both) && both.rig.truth().twist.linear < -0.15);
}

#[test]
fn an_order_of_firing_is_one_for_each_array() {
    let slots = |order: &[u8]| program(order).slots.to_vec();
    assert_eq!(slots(&[1, 2, 9, 10]), [1 | 1 << 8, 1 << 1 | 1 << 9]);
    assert_eq!(slots(&[4, 0, 3, 16]), [1 << 3 | 1 << 15, 1 << 2 | 1 << 15]);
    assert_eq!(slots(&[200, 255, 0]), Vec::<u32>::new());
    assert!(slots(&[1; 196]).len() <= MAX_SLOTS);
}

#[test]
fn settings_are_told_on_demand() {
    let mut both = Both::new("p3dx-sh");
    both.run(0.5);
    Command::new(Code::Settings, Argument::Integer(1)).emit(&mut both.extra);
    both.beat();
    let mut told = None;
    let mut framer = Framer::default();
    framer.push(&both.back, |frame| told = told.take().or(Settings::parse(frame).ok()));
    let told = told.unwrap();
    assert_eq!((told.watchdog, told.greatest_speed, told.acceleration), (2000, 1200, 300));
}

/// Nobody takes leave: the base goes on until its watchdog bites, and is fetched out of its session by the next client.
#[test]
fn a_client_that_is_gone_is_not_noticed_but_the_next_one_is_heard() {
    let mut both = Both::new("p3dx-sh");
    both.run(0.5);
    both.drive(2.0, Twist::new(0.3, 0.0));
    let run = |rig: &mut Rig<ArcosEmulator>, seconds: f64| {
        (0..(seconds * 100.0) as u64).for_each(|_| rig.beat(&[], &mut Vec::new()));
        rig.truth().twist.linear
    };
    assert!(run(&mut both.rig, 1.5) > 0.25, "it knows of nobody who is gone");
    assert_eq!(run(&mut both.rig, 1.8), 0.0, "the watchdog has bitten");
    let Both { session, .. } = Both::new("p3dx-sh");
    both.session = session;
    both.run(1.0);
    assert_eq!((both.session.state(), both.rig.truth().twist.linear), (State::Open, 0.0));
    both.drive(2.0, Twist::new(0.3, 0.0));
    assert!(both.rig.truth().twist.linear > 0.25);
}
