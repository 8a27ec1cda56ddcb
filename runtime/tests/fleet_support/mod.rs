//! A fleet of small robots with no hardware.
#![allow(dead_code, missing_docs, clippy::unwrap_used, clippy::expect_used)] // No test uses all of it.

use std::{ops::ControlFlow, sync::Arc, time::Duration};

use iceoryx2::prelude::ZeroCopySend;
use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Outputs, Phase, RobotContext, Wiring},
    arbitration::{
        Arbitration, Clients,
        sonar::{SafetyFloor, SonarArbiter},
    },
    clock::Pace,
    fleet::{self, FleetControl, FleetPlan, FleetReport, Still},
    geometry::{Limits, Pose, Twist},
    host::{Factory, NodePlan},
    link::{Backend, Bus, BusOptions},
    random::Streams,
    recording::Track,
    robot::RobotPlan,
    robot_model::{Platform, Ring},
    time::Time,
    topics::{BaseDecision, ClientId, FiringProgram, MotionKind, Payload},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("test::Count.v1")]
pub struct Count {
    #[serde(serialize_with = "fragile")]
    pub value: u64,
}

/// A count that can't be recorded.
pub const UNSPEAKABLE: u64 = u64::MAX;

fn fragile<S: Serializer>(value: &u64, serializer: S) -> Result<S::Ok, S::Error> {
    assert!(*value != UNSPEAKABLE, "as planned");
    serializer.serialize_u64(*value)
}

impl Payload for Count {
    const TOPIC: &'static str = "test/count";
}

/// Publishes a running count in the sense phase.
#[derive(Default)]
struct Counter(u64);

impl Behaviour for Counter {
    fn step(&mut self, _now: Time, _inputs: &Inputs, out: &mut Outputs) {
        self.0 += 1;
        out.publish(Count { value: self.0 });
    }
}

/// Sums what it hears, drives while the sum is odd, panics when told to.
struct Follower {
    sum: u64,
    panic_at: Option<u64>,
}

impl Behaviour for Follower {
    fn step(&mut self, _now: Time, inputs: &Inputs, out: &mut Outputs) {
        for count in inputs.each::<Count>() {
            self.sum += count.value;
            assert!(Some(count.value) != self.panic_at, "as planned");
        }
        out.base.drive(Twist::new(0.1, self.sum as f64 * 1e-6));
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("sum", self.sum as f64);
    }
}

/// Takes the base from the 40th to the 59th step.
struct Interrupter(u64);

impl Behaviour for Interrupter {
    fn step(&mut self, _now: Time, _inputs: &Inputs, out: &mut Outputs) {
        self.0 += 1;
        match self.0 {
            40..60 => out.base.drive(Twist::new(-0.2, 0.0)),
            60 => out.base.release(),
            _ => {}
        }
    }
}

/// Stands for the base: remembers what it was told.
#[derive(Default)]
struct Wheels {
    forward: u64,
    backward: u64,
}

impl Behaviour for Wheels {
    fn step(&mut self, now: Time, inputs: &Inputs, _out: &mut Outputs) {
        let decision = inputs.fresh::<BaseDecision>().unwrap();
        assert_eq!(decision.stamp, now, "arbitration comes before the base acts");
        match decision.motion.kind() {
            MotionKind::Velocity(twist) if twist.linear > 0.0 => self.forward += 1,
            MotionKind::Velocity(twist) if twist.linear < 0.0 => self.backward += 1,
            _ => {}
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("forward", self.forward as f64);
        last_words.fact("backward", self.backward as f64);
    }
}

pub fn node(context: &RobotContext, client: u16, phase: Phase, wiring: Wiring, claims: bool, factory: Factory) -> NodePlan {
    let client = ClientId(client);
    let node = Arc::from(context.clients.get(client).unwrap().name.as_str());
    let context = RobotContext { client, node, ..context.clone() };
    NodePlan { context, phases: vec![phase], wiring, claims, deadline: Duration::from_millis(50), factory }
}

pub fn robot(number: usize, bus: &Bus, panic_at: Option<u64>) -> RobotPlan {
    let name: Arc<str> = Arc::from(format!("robot-{number}"));
    let clients: Clients =
        [("counter", 0), ("follower", 5), ("interrupter", 9), ("arbitration", 0), ("wheels", 0)].into_iter().collect();
    let ring = Ring {
        name: "none".into(),
        transducers: Vec::new(),
        min_range: 0.1,
        max_range: 5.0,
        slot_time: 0.01,
        program: FiringProgram::default(),
    };
    let platform = Platform {
        name: "none".into(),
        radius: 0.3,
        limits: Limits::NONE,
        acceleration: 1.0,
        angular_acceleration: 1.0,
        turning_radius: 0.0,
    };
    let context = RobotContext {
        robot: name.clone(),
        node: Arc::from(""),
        client: ClientId::NONE,
        clients: Arc::new(clients),
        platform: Arc::new(platform),
        ring: Arc::new(ring),
        team: [].into(),
        start: Pose::default(),
        period: Duration::from_millis(50),
        streams: Streams::new(1),
    };
    let reads_count = || {
        let mut wiring = Wiring::default();
        wiring.reads::<Count>();
        wiring
    };
    let mut counts = Wiring::default();
    counts.writes::<Count>();
    let mut decisions = Wiring::default();
    decisions.reads::<BaseDecision>();
    let nodes = vec![
        node(&context, 0, Phase::Sense, counts, false, Box::new(|_| Ok(Box::new(Counter::default())))),
        node(&context, 1, Phase::Behave, reads_count(), true, Box::new(move |_| Ok(Box::new(Follower { sum: 0, panic_at })))),
        node(&context, 2, Phase::Behave, Wiring::default(), true, Box::new(|_| Ok(Box::new(Interrupter(0))))),
        node(
            &context,
            3,
            Phase::Arbitrate,
            Arbitration::wiring(),
            false,
            Box::new(|robot| {
                let sonar = SonarArbiter::new(&robot.clients, &robot.ring, SafetyFloor::none());
                Ok(Box::new(Arbitration::new(&robot.clients, sonar, robot.period)))
            }),
        ),
        node(&context, 4, Phase::Act, decisions, false, Box::new(|_| Ok(Box::new(Wheels::default())))),
    ];
    RobotPlan { nodes, bus: bus.robot(&name).unwrap(), track: Track::new(number, &name, None), name, answered_within: None }
}

pub fn plan(robots: Vec<RobotPlan>, threads: usize) -> FleetPlan {
    FleetPlan {
        robots,
        environment: Box::new(Still),
        period: Duration::from_millis(50),
        duration: Some(Duration::from_secs(5)),
        pace: Pace::AsFastAsPossible,
        leader: None,
        threads,
        recorder: None,
        control: FleetControl::default(),
        epoch: Default::default(),
        observer: Box::new(|_| ControlFlow::Continue(())),
    }
}

pub fn fly(backend: Backend, threads: usize, robots: usize, panic_at: Option<u64>) -> FleetReport {
    let bus = Bus::open(backend, &BusOptions::default()).unwrap();
    let robots = (0..robots).map(|number| robot(number, &bus, panic_at)).collect();
    fleet::run(plan(robots, threads)).unwrap()
}
