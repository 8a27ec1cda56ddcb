//! Two fleets at wall time, of which one takes its steps when the other has sensed, and is waited for until it has answered.
#![allow(clippy::unwrap_used)]

mod fleet_support;

use std::{ops::ControlFlow, thread, time::Duration};

use fleet_support::{Count, plan, robot};
use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Outputs, Phase, Wiring},
    clock::Pace,
    fleet::{self, FleetPlan, FleetReport, Leader},
    host::{Factory, NodePlan},
    link::{Backend, Bell, Bus, BusOptions, Publisher, Subscriber},
    robot::RobotPlan,
    time::Time,
    topics::MissionPulse,
};

const PERIOD: Duration = Duration::from_millis(50);

/// Counts what it asks, and which of it was answered before it acts.
#[derive(Default)]
struct Asker {
    asked: u64,
    answered: u64,
}

impl Behaviour for Asker {
    fn step(&mut self, _now: Time, inputs: &Inputs, out: &mut Outputs) {
        if inputs.phase == Phase::Sense {
            self.asked += 1;
            out.publish(Count { value: self.asked });
        } else {
            let answers = inputs.each::<MissionPulse>();
            self.answered += u64::from(answers.iter().any(|answer| answer.echo == self.asked));
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("asked", self.asked as f64);
        last_words.fact("answered", self.answered as f64);
    }
}

/// Answers what it has been asked in the other run.
struct Answerer {
    run: String,
    ports: Option<(Subscriber<Count>, Publisher<MissionPulse>, Bell)>,
}

impl Behaviour for Answerer {
    fn step(&mut self, _now: Time, _inputs: &Inputs, _out: &mut Outputs) {
        let open = || {
            let bus = Bus::attach(&self.run, &BusOptions::default()).ok()?.robot("robot-0").ok()?.open();
            Some((bus.subscriber().ok()?, bus.publisher().ok()?, bus.bell().ok()?))
        };
        self.ports = self.ports.take().or_else(open);
        if let Some((asked, answers, bell)) = &mut self.ports {
            asked.drain(|count: &Count| _ = answers.publish(MissionPulse { echo: count.value, ..MissionPulse::default() }));
            bell.ring();
        }
    }
}

/// A robot with this node and no other.
fn robot_with(bus: &Bus, phases: Vec<Phase>, wiring: Wiring, factory: Factory) -> RobotPlan {
    let mut robot = robot(0, bus, None);
    let context = robot.nodes[0].context.clone();
    robot.nodes = vec![NodePlan { context, phases, wiring, claims: false, deadline: PERIOD, factory }];
    robot
}

fn fly(plan: FleetPlan, duration: f64) -> FleetReport {
    let observer = Box::new(|_| ControlFlow::Continue(()));
    let duration = Some(Duration::from_secs_f64(duration));
    fleet::run(FleetPlan { pace: Pace::Wall, period: PERIOD, duration, observer, ..plan }).unwrap()
}

#[test]
fn what_a_leader_has_sensed_is_answered_before_it_acts() {
    let run = format!("leader-{}", std::process::id());
    let leader = run.clone();
    let led = thread::spawn(move || {
        let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
        let (to, run) = (leader.clone(), leader);
        let factory: Factory = Box::new(move |_| Ok(Box::new(Answerer { run: to.clone(), ports: None })));
        let robot = robot_with(&bus, vec![Phase::Behave], Wiring::default(), factory);
        fly(FleetPlan { leader: Some(Leader { run, robot: "robot-0".into() }), ..plan(vec![robot], 1) }, 5.0)
    });
    let bus = Bus::open(Backend::Shared, &BusOptions { run: Some(run), ..BusOptions::default() }).unwrap();
    let mut wiring = Wiring::default();
    wiring.reads::<MissionPulse>().writes::<Count>();
    let factory: Factory = Box::new(|_| Ok(Box::<Asker>::default()));
    let robot = robot_with(&bus, vec![Phase::Sense, Phase::Act], wiring, factory);
    // So short that an answer at the follower's own beat would hardly ever come in time.
    let robot = RobotPlan { answered_within: Some(PERIOD / 10), ..robot };
    let report = fly(plan(vec![robot], 1), 4.0);
    let led = led.join().unwrap();
    let fact = |name| report.robots[0].fact(name).unwrap();
    assert!(fact("asked") >= 60.0, "{}", fact("asked"));
    // A quarter passes before they have found each other.
    assert!(fact("answered") >= 0.5 * fact("asked"), "{} of {}", fact("answered"), fact("asked"));
    // It goes on alone when the leader has gone, and takes no more steps than its own clock would.
    assert!(led.time.as_secs_f64() >= 5.0 && (80..=102).contains(&led.steps), "{led:?}");
}
