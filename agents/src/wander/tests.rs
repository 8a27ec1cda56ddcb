//! The agent over a base that does what a test says.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use orienteer_runtime::{
    arbitration::Clients,
    geometry::{Limits, Pose},
    random::Streams,
    robot_model::{Platform, Ring},
    topics::{ClientId, FiringProgram, MotionKind},
};

use super::*;

const PERIOD: Duration = Duration::from_millis(50);

fn robot(seed: u64) -> RobotContext {
    let platform = Platform {
        name: "test".into(),
        radius: 0.17,
        limits: Limits { linear: 0.5, angular: 4.0 },
        acceleration: 1.0,
        angular_acceleration: 5.0,
        turning_radius: 0.0,
    };
    let (name, program) = ("none".into(), FiringProgram::default());
    let ring = Ring { name, transducers: Vec::new(), min_range: 0.0, max_range: 0.0, slot_time: 1.0, program };
    RobotContext {
        robot: "create".into(),
        node: "wander".into(),
        client: ClientId(0),
        clients: Arc::new([("wander", 3)].into_iter().collect::<Clients>()),
        platform: Arc::new(platform),
        ring: Arc::new(ring),
        team: [].into(),
        start: Pose::default(),
        period: PERIOD,
        streams: Streams::new(seed),
    }
}

/// A wanderer and its base, stepped at 20 Hz.
struct Walk {
    wander: Wander,
    inputs: Inputs,
    out: Outputs,
    now: Time,
    travelled: f64,
}

impl Walk {
    fn new(seed: u64) -> Self {
        let mut wiring = Wiring::default();
        Wander::topics(&mut wiring);
        let wander = Wander::build(WanderConfig::default(), &robot(seed)).unwrap();
        let (inputs, out) = (Inputs::offline(&wiring), Outputs::offline(&wiring));
        Self { wander, inputs, out, now: Time::START, travelled: 0.0 }
    }

    /// A control period in which the base moves at this speed, m/s, and feels this. Returns what it is told.
    fn step(&mut self, speed: f64, feels: u32) -> MotionKind {
        self.now = self.now + PERIOD;
        self.travelled += speed * PERIOD.as_secs_f64();
        self.inputs.settle();
        self.inputs.put(Odometry { stamp: self.now, travelled: self.travelled, flags: feels, ..Odometry::default() });
        self.out.settle();
        self.wander.step(self.now, &self.inputs, &mut self.out);
        self.out.base.claim(self.now, 3 * PERIOD).motion.kind()
    }
}

const ON: MotionKind = MotionKind::Velocity(Twist { linear: 0.2, angular: 0.0 });
const BACK: MotionKind = MotionKind::Translate { distance: -0.12, speed: 0.1 };

#[test]
fn who_touches_something_backs_off_in_the_next_step() {
    let mut walk = Walk::new(1);
    walk.step(0.0, 0);
    assert!((0..100).all(|_| walk.step(0.2, 0) == ON));
    assert_eq!(walk.step(0.2, flags::CONTACT), BACK);
    assert_eq!((walk.wander.met.borrow().touched, walk.wander.met.borrow().held), (1, 0));
}

/// As by the base's own protection, before anything is touched.
#[test]
fn who_does_not_get_on_for_two_seconds_backs_off_too() {
    let mut walk = Walk::new(1);
    let began = walk.now;
    while walk.step(0.0, 0) != BACK {
        assert!(walk.now.secs_since(began) < 10.0);
    }
    assert!((2.0..2.3).contains(&walk.now.secs_since(began)), "{}", walk.now.secs_since(began));
    assert_eq!((walk.wander.met.borrow().touched, walk.wander.met.borrow().held), (0, 1));
}

#[test]
fn who_is_in_somebodys_hands_waits() {
    let mut walk = Walk::new(1);
    walk.step(0.0, 0);
    assert!((0..200).all(|_| walk.step(0.0, flags::EMERGENCY_STOP) == ON));
    assert!((0..20).all(|_| walk.step(0.2, 0) == ON));
}

#[test]
fn the_turns_must_make_sense() {
    let config = WanderConfig { least_turn_deg: 120.0, largest_turn_deg: 90.0, ..WanderConfig::default() };
    assert!(Wander::build(config, &robot(1)).unwrap_err().to_string().contains("least_turn_deg"));
}
