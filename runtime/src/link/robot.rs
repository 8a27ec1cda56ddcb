//! The topics of one robot.

use std::{any::Any, cell::RefCell, collections::BTreeMap, fmt, rc::Rc, sync::Arc};

use super::{
    Bell, Doorbell, LinkError, PayloadLayout, Publisher, Subscriber,
    bus::{Claim, Fabric},
    direct::DirectTopic,
    iox::IoxTopic,
    ports::{Topic, WriterNumber},
};
use crate::topics::{Payload, limits};

/// One robot's topics, on the thread on which its actors live. Cheap to clone.
#[derive(Clone)]
pub struct RobotBus {
    inner: Rc<Inner>,
}

struct Inner {
    topics: RefCell<BTreeMap<&'static str, Entry>>,
    claim: Arc<Claim>,
}

/// A topic that has been used.
struct Entry {
    /// An `Rc<dyn Topic<P>>` for the topic's own `P`.
    topic: Box<dyn Any>,
    layout: PayloadLayout,
    next_writer: WriterNumber,
}

/// How many writers a topic may have.
pub(super) fn most_writers<P: Payload>() -> usize {
    if P::MANY_WRITERS { limits::NODES } else { 1 }
}

impl RobotBus {
    pub(super) fn new(claim: Arc<Claim>) -> Self {
        Self { inner: Rc::new(Inner { topics: RefCell::default(), claim }) }
    }

    /// The robot's name.
    #[must_use]
    pub fn robot(&self) -> &str {
        self.inner.claim.robot()
    }

    /// Makes a writer of `P`'s topic.
    ///
    /// # Errors
    /// [`LinkError::TooManyWriters`], [`LinkError::IncompatiblePayload`] if the topic carries another type, and with `shared`
    /// links [`LinkError::OutOfDescriptors`] and [`LinkError::OutOfSharedMemory`].
    pub fn publisher<P: Payload>(&self) -> Result<Publisher<P>, LinkError> {
        let (topic, number) = self.topic::<P>()?;
        let writer = topic.writer(self.inner.claim.bus().first_writer + number)?;
        if let Some(entry) = self.inner.topics.borrow_mut().get_mut(P::TOPIC) {
            entry.next_writer = number + 1;
        }
        Ok(Publisher::new(writer))
    }

    /// Makes a reader of `P`'s topic, which gets what is published from now on.
    ///
    /// # Errors
    /// [`LinkError::TooManyReaders`]; otherwise as [`RobotBus::publisher`].
    pub fn subscriber<P: Payload>(&self) -> Result<Subscriber<P>, LinkError> {
        let (topic, _) = self.topic::<P>()?;
        Ok(Subscriber::new(topic.reader()?))
    }

    /// Makes the bell that tells other processes of news from this robot. With links that no other process can hear it does
    /// nothing.
    ///
    /// # Errors
    /// [`LinkError::OutOfDescriptors`], [`LinkError::TooManyProcesses`], [`LinkError::Transport`].
    pub fn bell(&self) -> Result<Bell, LinkError> {
        Bell::new(Arc::clone(&self.inner.claim))
    }

    /// Makes a doorbell that hears the bells of other processes. Must be called inside a tokio runtime.
    ///
    /// # Errors
    /// [`LinkError::NeedsShared`] with other links, [`LinkError::NoRuntime`]; otherwise as [`RobotBus::bell`].
    pub fn doorbell(&self) -> Result<Doorbell, LinkError> {
        Doorbell::new(Arc::clone(&self.inner.claim))
    }

    fn topic<P: Payload>(&self) -> Result<(Rc<dyn Topic<P>>, WriterNumber), LinkError> {
        let mut topics = self.inner.topics.borrow_mut();
        if let Some(entry) = topics.get(P::TOPIC) {
            return match entry.topic.downcast_ref::<Rc<dyn Topic<P>>>() {
                Some(topic) => Ok((Rc::clone(topic), entry.next_writer)),
                None => Err(LinkError::IncompatiblePayload {
                    robot: self.robot().to_owned(),
                    topic: P::TOPIC,
                    found: entry.layout.clone(),
                    wanted: PayloadLayout::of::<P>(),
                }),
            };
        }
        let topic = self.open_topic::<P>()?;
        let entry = Entry { topic: Box::new(Rc::clone(&topic)), layout: PayloadLayout::of::<P>(), next_writer: 0 };
        topics.insert(P::TOPIC, entry);
        Ok((topic, 0))
    }

    fn open_topic<P: Payload>(&self) -> Result<Rc<dyn Topic<P>>, LinkError> {
        check_topic_name(P::TOPIC)?;
        let claim = Arc::clone(&self.inner.claim);
        Ok(match &self.inner.claim.bus().fabric {
            Fabric::Shared { node, reserved, .. } => Rc::new(IoxTopic::open(node, claim, Some(Arc::clone(reserved)))?),
            Fabric::Local { node } => Rc::new(IoxTopic::open(node, claim, None)?),
            Fabric::Direct => Rc::new(DirectTopic::new(claim)),
        })
    }
}

fn check_topic_name(name: &'static str) -> Result<(), LinkError> {
    let level = |level: &str| !level.is_empty() && level.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_.".contains(&b));
    if name.len() <= 128 && name.split('/').all(level) {
        return Ok(());
    }
    let reason = "it is not made of up to 128 letters, digits, `-`, `_`, `.` and single slashes between them";
    Err(LinkError::BadName { kind: "topic", name: name.to_owned(), reason })
}

impl fmt::Debug for RobotBus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "RobotBus({})", self.robot())
    }
}
