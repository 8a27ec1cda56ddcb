//! What the robots of a mission tell each other.
//!
//! At the end of a step each robot's words are collected; the conductor puts them in the order of the robots, and at the beginning of the next step every robot
//! publishes all of them on its own links. So all robots hear the same words in the same order, their own among them, whatever thread they live on.
//! Words are boxed: they are for what is rare, such as a place that was found. Who says nothing allocates nothing.

use std::any::Any;

use crate::{
    link::{LinkError, Publisher, RobotBus, Subscriber},
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
pub(crate) trait Mouth: 'static {
    /// Appends what was said since the last call. Who says it is filled in later.
    fn collect(&mut self, words: &mut Vec<Word>);
}

/// Publishes on a robot's links what all robots said.
pub(crate) trait Ear: 'static {
    /// Publishes those of the words that it is for.
    fn hear(&mut self, words: &[Word]) -> Result<(), LinkError>;
}

impl<P: TeamPayload> Mouth for Subscriber<P> {
    fn collect(&mut self, words: &mut Vec<Word>) {
        Subscriber::collect(self, |sample| words.push(Word { robot: 0, topic: P::TOPIC, sample: Box::new(*sample) }));
    }
}

/// An ear for one topic.
struct EarFor<P: TeamPayload>(Publisher<P::Heard>);

impl<P: TeamPayload> Ear for EarFor<P> {
    fn hear(&mut self, words: &[Word]) -> Result<(), LinkError> {
        for word in words.iter().filter(|word| word.topic == P::TOPIC) {
            if let Some(sample) = word.sample.downcast_ref::<P>() {
                self.0.publish(sample.heard(word.robot as u32))?;
            }
        }
        Ok(())
    }
}

/// A mouth for one topic.
pub(crate) fn mouth<P: TeamPayload>(bus: &RobotBus) -> Result<Box<dyn Mouth>, LinkError> {
    Ok(Box::new(bus.subscriber::<P>()?))
}

/// An ear for one topic.
pub(crate) fn ear<P: TeamPayload>(bus: &RobotBus) -> Result<Box<dyn Ear>, LinkError> {
    Ok(Box::new(EarFor::<P>(bus.publisher()?)))
}

/// A robot's mouths and ears.
#[derive(Default)]
pub(crate) struct Exchange {
    mouths: Vec<Box<dyn Mouth>>,
    ears: Vec<Box<dyn Ear>>,
}

impl Exchange {
    pub(crate) fn new(mouths: Vec<Box<dyn Mouth>>, ears: Vec<Box<dyn Ear>>) -> Self {
        Self { mouths, ears }
    }

    /// What the robot said since the last call.
    pub(crate) fn said(&mut self) -> Vec<Word> {
        let mut words = Vec::new();
        self.mouths.iter_mut().for_each(|mouth| mouth.collect(&mut words));
        words
    }

    /// Publishes on the robot's links what all said.
    pub(crate) fn hear(&mut self, words: &[Word]) {
        for ear in &mut self.ears {
            if let Err(error) = ear.hear(words) {
                tracing::error!("what other robots said can't be passed on: {error}");
            }
        }
    }
}
