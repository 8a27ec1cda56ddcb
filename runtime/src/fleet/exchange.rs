//! What the robots of a mission tell each other.
//!
//! At the end of a step each robot's words are collected; the conductor puts them in the order of the robots, and at the beginning of the next step every robot
//! publishes all of them on its own links. So all robots hear the same words in the same order, their own among them, whatever thread they live on.
//! Words are boxed: they are for what is rare, such as a place that was found. Who says nothing allocates nothing.

use std::any::Any;

use crate::{
    agent::Wiring,
    link::{LinkError, Publisher, RobotBus, Subscriber},
    robot::RobotPlan,
    topics::TeamPayload,
};

/// What a robot said.
pub(crate) struct Word {
    /// The robot's place in the plan.
    pub robot: usize,
    topic: &'static str,
    sample: Box<dyn Any + Send + Sync>,
}

impl Word {
    /// The same, as said by this robot.
    pub(crate) fn of(self, robot: usize) -> Self {
        Self { robot, ..self }
    }
}

/// Collects what a robot tells the others.
pub(crate) trait Teller: 'static {
    /// Appends what was said since the last call. Who says it is filled in later.
    fn collect(&mut self, words: &mut Vec<Word>);
}

/// Publishes on a robot's links what all robots said.
pub(crate) trait Hearer: 'static {
    /// Publishes those of the words that it is for.
    fn hear(&mut self, words: &[Word]) -> Result<(), LinkError>;
}

impl<P: TeamPayload> Teller for Subscriber<P> {
    fn collect(&mut self, words: &mut Vec<Word>) {
        Subscriber::collect(self, |sample| words.push(Word { robot: 0, topic: P::TOPIC, sample: Box::new(*sample) }));
    }
}

/// An hearer for one topic.
struct HearerFor<P: TeamPayload>(Publisher<P::Heard>);

impl<P: TeamPayload> Hearer for HearerFor<P> {
    fn hear(&mut self, words: &[Word]) -> Result<(), LinkError> {
        for word in words.iter().filter(|word| word.topic == P::TOPIC) {
            if let Some(sample) = word.sample.downcast_ref::<P>() {
                self.0.publish(sample.heard(word.robot as u32))?;
            }
        }
        Ok(())
    }
}

/// A teller for one topic.
pub(crate) fn teller<P: TeamPayload>(bus: &RobotBus) -> Result<Box<dyn Teller>, LinkError> {
    Ok(Box::new(bus.subscriber::<P>()?))
}

/// An hearer for one topic.
pub(crate) fn hearer<P: TeamPayload>(bus: &RobotBus) -> Result<Box<dyn Hearer>, LinkError> {
    Ok(Box::new(HearerFor::<P>(bus.publisher()?)))
}

/// A robot's tellers and hearers.
#[derive(Default)]
pub(crate) struct Exchange {
    tellers: Vec<Box<dyn Teller>>,
    hearers: Vec<Box<dyn Hearer>>,
}

impl Exchange {
    pub(crate) fn new(tellers: Vec<Box<dyn Teller>>, hearers: Vec<Box<dyn Hearer>>) -> Self {
        Self { tellers, hearers }
    }

    /// What the robot said since the last call.
    pub(crate) fn said(&mut self) -> Vec<Word> {
        let mut words = Vec::new();
        self.tellers.iter_mut().for_each(|teller| teller.collect(&mut words));
        words
    }

    /// Publishes on the robot's links what all said.
    pub(crate) fn hear(&mut self, words: &[Word]) {
        for hearer in &mut self.hearers {
            if let Err(error) = hearer.hear(words) {
                tracing::error!("what other robots said can't be passed on: {error}");
            }
        }
    }
}

/// More robots tell each other something than can be heard in one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crowd {
    /// What they tell.
    pub topic: &'static str,
    /// The first robot that is too many, by its place in the plan.
    pub robot: usize,
    /// So many can.
    pub most: usize,
}

impl Crowd {
    /// What too many of these robots tell each other, if there is anything.
    #[must_use]
    pub fn find(robots: &[RobotPlan]) -> Option<Self> {
        let mut all = Wiring::default();
        robots.iter().flat_map(|robot| &robot.nodes).for_each(|node| all.absorb_exchange(&node.wiring));
        let tells = |robot: &RobotPlan, topic| {
            robot.nodes.iter().any(|node| node.wiring.told_ports().iter().any(|port| port.topic == topic))
        };
        all.told_ports().iter().find_map(|port| {
            let mut tellers = robots.iter().enumerate().filter(|(_, robot)| tells(robot, port.topic));
            tellers.nth(port.queue).map(|(robot, _)| Self { topic: port.topic, robot, most: port.queue })
        })
    }
}
