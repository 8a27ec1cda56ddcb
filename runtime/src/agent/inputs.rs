//! What a node may look at in a step.

use std::{
    any::{Any, TypeId},
    cell::{RefCell, RefMut},
};

use super::{Phase, Wiring, undeclared::Undeclared};
use crate::{
    link::{LinkError, RobotBus, Subscriber},
    topics::Payload,
};

/// Everything that a node may look at in one step.
///
/// Each topic that the node declared has its newest sample and the samples that came since the last step.
pub struct Inputs {
    /// The phase that is being stepped.
    pub phase: Phase,
    slots: Vec<Box<dyn ReadPort>>,
    undeclared: RefCell<Undeclared>,
}

impl Inputs {
    /// Inputs that are joined to a robot's topics.
    ///
    /// # Errors
    /// If a port can't be made.
    pub(crate) fn connect(wiring: &Wiring, bus: Option<&RobotBus>) -> Result<Self, LinkError> {
        let slots = wiring.read_ports().iter().map(|port| (port.reader)(bus)).collect::<Result<_, _>>()?;
        Ok(Self { phase: Phase::Behave, slots, undeclared: RefCell::default() })
    }

    /// Inputs that only hold what [`Inputs::put`] gives them: for tests.
    #[must_use]
    pub fn offline(wiring: &Wiring) -> Self {
        let slots = wiring.read_ports().iter().filter_map(|port| (port.reader)(None).ok()).collect();
        Self { phase: Phase::Behave, slots, undeclared: RefCell::default() }
    }

    /// The newest sample of a topic, however old; `None` before the first.
    #[must_use]
    pub fn latest<P: Payload>(&self) -> Option<&P> {
        self.slot::<P>().and_then(|slot| slot.samples.last())
    }

    /// The newest sample of a topic if it came since the last step.
    #[must_use]
    pub fn fresh<P: Payload>(&self) -> Option<&P> {
        self.slot::<P>().and_then(|slot| slot.fresh().last())
    }

    /// All samples of a topic that came since the last step, oldest first.
    #[must_use]
    pub fn each<P: Payload>(&self) -> &[P] {
        self.slot::<P>().map_or(&[], |slot| slot.fresh())
    }

    /// Adds a sample by hand, as if it had just come. Samples of topics that were not declared are dropped.
    pub fn put<P: Payload>(&mut self, sample: P) {
        if let Some(slot) = self.slots.iter_mut().find_map(|slot| slot.as_any_mut().downcast_mut::<ReadSlot<P>>()) {
            slot.add(&sample);
        }
    }

    /// Forgets which samples are new, as the host does between steps.
    pub fn settle(&mut self) {
        for slot in &mut self.slots {
            slot.settle();
        }
    }

    /// Shows the same samples as `other`, which was made from the same wiring.
    pub(super) fn copy_from(&mut self, other: &Inputs) {
        self.phase = other.phase;
        for (slot, other) in self.slots.iter_mut().zip(&other.slots) {
            slot.copy_from(other.as_ref());
        }
    }

    /// Fetches what has come on the links since the last call.
    pub(crate) fn refresh(&mut self) {
        for slot in &mut self.slots {
            slot.refresh();
        }
    }

    /// Topics that were asked for without having been declared.
    pub(crate) fn undeclared(&self) -> RefMut<'_, Undeclared> {
        self.undeclared.borrow_mut()
    }

    fn slot<P: Payload>(&self) -> Option<&ReadSlot<P>> {
        let found = self.slots.iter().find(|slot| slot.payload() == TypeId::of::<P>());
        if found.is_none() {
            self.undeclared().note(P::TOPIC);
        }
        found.and_then(|slot| slot.as_any().downcast_ref())
    }
}

/// The reading end of one topic, whatever its payload.
pub(super) trait ReadPort {
    fn payload(&self) -> TypeId;
    fn refresh(&mut self);
    fn settle(&mut self);
    fn copy_from(&mut self, other: &dyn ReadPort);
    fn as_any(&self) -> &dyn Any;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

pub(super) struct ReadSlot<P: Payload> {
    subscriber: Option<Subscriber<P>>,
    /// What came since the last step; if nothing did, what came before. The last is the newest of all.
    samples: Vec<P>,
    is_fresh: bool,
}

/// Samples for which there is room from the beginning. More come in a step only if a writer or this node was held up.
pub(super) const USUAL: usize = 4;

impl<P: Payload> ReadSlot<P> {
    pub(super) fn new(subscriber: Option<Subscriber<P>>) -> Self {
        Self { subscriber, samples: Vec::with_capacity(P::QUEUE.min(USUAL)), is_fresh: false }
    }

    fn fresh(&self) -> &[P] {
        if self.is_fresh { &self.samples } else { &[] }
    }

    fn add(&mut self, sample: &P) {
        Self::put(&mut self.samples, &mut self.is_fresh, sample);
    }

    /// The first new sample takes the place of all old ones.
    fn put(samples: &mut Vec<P>, is_fresh: &mut bool, sample: &P) {
        if !std::mem::replace(is_fresh, true) {
            samples.clear();
        }
        samples.push(*sample);
    }
}

impl<P: Payload> ReadPort for ReadSlot<P> {
    fn payload(&self) -> TypeId {
        TypeId::of::<P>()
    }

    fn refresh(&mut self) {
        self.is_fresh = false;
        if let Some(subscriber) = &mut self.subscriber {
            let (samples, is_fresh) = (&mut self.samples, &mut self.is_fresh);
            subscriber.collect(|sample| Self::put(samples, is_fresh, sample));
        }
    }

    fn settle(&mut self) {
        self.is_fresh = false;
    }

    fn copy_from(&mut self, other: &dyn ReadPort) {
        if let Some(other) = other.as_any().downcast_ref::<Self>() {
            self.samples.clone_from(&other.samples);
            self.is_fresh = other.is_fresh;
        }
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
