//! Which topics a node reads and writes.

use crate::{
    agent::{
        inputs::{ReadPort, ReadSlot},
        outputs::{WritePort, WriteSlot},
    },
    fleet::{self, TeamHearer, TeamTeller},
    link::{LinkError, RobotBus},
    recording::Track,
    topics::{Payload, TeamPayload},
};

/// The topics that a node reads and writes, in the order in which it declares them.
#[derive(Debug, Clone, Default)]
pub struct Wiring {
    reads: Vec<Port>,
    writes: Vec<Port>,
    tells: Vec<TeamPort>,
    hears: Vec<TeamPort>,
    draws_map: bool,
}

/// Whether a node can do without a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// Somebody on the robot has to write it.
    Required,
    /// It is read if somebody writes it.
    Optional,
}

/// One declared topic. Knows how to make the ports of its payload type.
#[derive(Debug, Clone, Copy)]
pub struct Port {
    /// The topic's name.
    pub topic: &'static str,
    /// True if many nodes may write it.
    pub many_writers: bool,
    /// Whether a reader can do without it.
    pub need: Need,
    pub(super) reader: fn(Option<&RobotBus>) -> Result<Box<dyn ReadPort>, LinkError>,
    pub(super) writer: fn(Option<&RobotBus>) -> Result<Box<dyn WritePort>, LinkError>,
    pub(crate) tap: fn(&RobotBus) -> Result<Box<dyn Tap>, LinkError>,
}

/// One topic that robots tell each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TeamPort {
    pub(crate) topic: &'static str,
    /// So many words on it can be heard in one step.
    pub(crate) queue: usize,
    pub(crate) teller: fn(&RobotBus) -> Result<Box<dyn TeamTeller>, LinkError>,
    pub(crate) hearer: fn(&RobotBus) -> Result<Box<dyn TeamHearer>, LinkError>,
}

impl TeamPort {
    fn of<P: TeamPayload>() -> Self {
        Self { topic: P::TOPIC, queue: P::Heard::QUEUE, teller: fleet::teller::<P>, hearer: fleet::hearer::<P> }
    }

    fn add(self, ports: &mut Vec<Self>) {
        if ports.iter().all(|other| other.topic != self.topic) {
            ports.push(self);
        }
    }
}

impl Port {
    fn of<P: Payload>(need: Need) -> Self {
        Self {
            topic: P::TOPIC,
            many_writers: P::MANY_WRITERS,
            need,
            reader: |bus| Ok(Box::new(ReadSlot::<P>::new(bus.map(RobotBus::subscriber).transpose()?))),
            writer: |bus| Ok(Box::new(WriteSlot::<P>::new(bus.map(RobotBus::publisher).transpose()?))),
            tap: |bus| Ok(Box::new(bus.subscriber::<P>()?)),
        }
    }
}

impl Wiring {
    /// Declares that the node reads the topic of `P` and can't do without it.
    pub fn reads<P: Payload>(&mut self) -> &mut Self {
        Self::add(&mut self.reads, Port::of::<P>(Need::Required));
        self
    }

    /// Declares that the node reads the topic of `P` if there is anybody who writes it.
    pub fn reads_if_any<P: Payload>(&mut self) -> &mut Self {
        Self::add(&mut self.reads, Port::of::<P>(Need::Optional));
        self
    }

    /// Declares that the node writes the topic of `P`.
    pub fn writes<P: Payload>(&mut self) -> &mut Self {
        Self::add(&mut self.writes, Port::of::<P>(Need::Required));
        self
    }

    /// Declares that the node writes the topic of `P`, and that all robots of the mission are told.
    pub fn tells<P: TeamPayload>(&mut self) -> &mut Self {
        TeamPort::of::<P>().add(&mut self.tells);
        self.writes::<P>()
    }

    /// Declares that the node reads what all robots of the mission told, its own among them: the topic of [`P::Heard`](TeamPayload::Heard).
    pub fn hears<P: TeamPayload>(&mut self) -> &mut Self {
        TeamPort::of::<P>().add(&mut self.hears);
        self.reads_if_any::<P::Heard>()
    }

    /// Declares that the node records pictures of a grid map. One node of a robot may do so: the map is called `map`.
    pub fn draws_map(&mut self) -> &mut Self {
        self.draws_map = true;
        self
    }

    fn add(ports: &mut Vec<Port>, port: Port) {
        if ports.iter().all(|other| other.topic != port.topic) {
            ports.push(port);
        }
    }

    /// Adds all topics that `other` writes.
    pub(crate) fn absorb_writes(&mut self, other: &Wiring) {
        for port in &other.writes {
            Self::add(&mut self.writes, *port);
        }
    }

    /// Adds all topics that `other` tells and hears.
    pub(crate) fn absorb_exchange(&mut self, other: &Wiring) {
        other.tells.iter().for_each(|port| port.add(&mut self.tells));
        other.hears.iter().for_each(|port| port.add(&mut self.hears));
    }

    /// The topics told to other robots.
    pub(crate) fn told_ports(&self) -> &[TeamPort] {
        &self.tells
    }

    /// The topics heard of other robots.
    pub(crate) fn heard_ports(&self) -> &[TeamPort] {
        &self.hears
    }

    /// True if the node records pictures of a grid map.
    #[must_use]
    pub fn draws_a_map(&self) -> bool {
        self.draws_map
    }

    /// The topics read.
    #[must_use]
    pub fn read_ports(&self) -> &[Port] {
        &self.reads
    }

    /// The topics written.
    #[must_use]
    pub fn write_ports(&self) -> &[Port] {
        &self.writes
    }
}

/// Copies a topic into a recording.
pub(crate) trait Tap: 'static {
    /// Records all samples that have come since the last call.
    fn drain(&mut self, track: &mut Track);
}

impl<P: Payload> Tap for crate::link::Subscriber<P> {
    fn drain(&mut self, track: &mut Track) {
        self.collect(|sample| track.record(sample));
    }
}
