//! What robots tell each other: all hear the same, in the same order, one step later.
#![allow(clippy::unwrap_used)]

mod fleet_support;

use std::time::Duration;

use fleet_support::{node, plan, robot};
use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Outputs, Phase, Wiring},
    fleet::{self, FleetReport},
    link::{Backend, Bus, BusOptions},
    recording::Track,
    robot::RobotPlan,
    time::Time,
    topics::{TeamWhereabouts, Whereabouts},
};

const PERIOD: Duration = Duration::from_millis(50);

/// Tells the others something in every step, twice in every third, and checks what it hears.
struct Gossip {
    robots: u32,
    words: u32,
}

impl Gossip {
    fn wiring() -> Wiring {
        let mut wiring = Wiring::default();
        wiring.tells::<Whereabouts>().hears::<Whereabouts>();
        wiring
    }

    /// What a robot says in the step of this time.
    fn words(now: Time) -> impl Iterator<Item = Whereabouts> {
        let step = now.as_nanos() / PERIOD.as_nanos() as u64;
        (0..if step.is_multiple_of(3) { 2 } else { 1 }).map(move |word| Whereabouts {
            stamp: now,
            state: word,
            ..Whereabouts::default()
        })
    }
}

impl Behaviour for Gossip {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        let heard: Vec<(u32, Whereabouts)> =
            inputs.each::<TeamWhereabouts>().iter().map(|word| (word.robot, word.whereabouts)).collect();
        let before = now.as_nanos().checked_sub(PERIOD.as_nanos() as u64).map(Time::from_nanos);
        let said = |robot| before.into_iter().flat_map(Self::words).map(move |word| (robot, word));
        assert_eq!(heard, (0..self.robots).flat_map(said).collect::<Vec<_>>());
        self.words += heard.len() as u32;
        Self::words(now).for_each(|word| out.publish(word));
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("words", f64::from(self.words));
    }
}

/// A robot that does nothing but talk.
fn talker(number: usize, robots: u32, bus: &Bus) -> RobotPlan {
    let mut plan = robot(number, bus, None);
    let context = plan.nodes.swap_remove(0).context;
    let gossip =
        node(&context, 0, Phase::Behave, Gossip::wiring(), false, Box::new(move |_| Ok(Box::new(Gossip { robots, words: 0 }))));
    RobotPlan { nodes: vec![gossip], track: Track::new(number, &plan.name, None), ..plan }
}

fn talk(backend: Backend, threads: usize, robots: u32) -> FleetReport {
    let bus = Bus::open(backend, &BusOptions::default()).unwrap();
    let robots = (0..robots).map(|number| talker(number as usize, robots, &bus)).collect();
    fleet::run(plan(robots, threads)).unwrap()
}

#[test]
fn all_hear_the_same_in_the_order_of_the_robots_one_step_later() {
    for backend in [Backend::Direct, Backend::Local, Backend::Shared] {
        for threads in [1, 2, 3] {
            let report = talk(backend, threads, 3);
            for robot in &report.robots {
                // 101 steps, the last of which nobody hears of; 34 of the others are thirds.
                assert_eq!(robot.fact("words"), Some(f64::from(3 * (100 + 34))), "{backend:?} on {threads} threads");
                assert_eq!(robot.nodes.iter().map(|node| node.panics).sum::<u32>(), 0);
            }
        }
    }
}

#[test]
fn a_robot_alone_hears_itself() {
    let report = talk(Backend::Direct, 1, 1);
    assert_eq!(report.robots[0].fact("words"), Some(134.0));
}
