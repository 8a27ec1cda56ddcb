//! Rings on the heap of one thread.
//!
//! A writer has one ring, whoever reads it: publishing copies the sample once. A reader keeps, for each writer, the number of
//! the sample that it wants next; if the ring has gone round since, the oldest samples are lost, exactly as in a queue of the
//! same length.

use std::{
    cell::{Cell, RefCell},
    rc::{Rc, Weak},
    sync::Arc,
};

use super::{
    LinkError, RETIRED_WRITERS,
    bus::Claim,
    ports::{Arrival, Reader, Topic, Writer, WriterNumber},
    robot::most_writers,
};
use crate::topics::{Payload, limits};

/// The last samples of one writer.
struct Ring<P> {
    writer: WriterNumber,
    slots: Box<[Cell<P>]>,
    /// How many samples have been published.
    published: Cell<u64>,
    retired: Cell<bool>,
}

impl<P: Payload> Ring<P> {
    fn new(writer: WriterNumber) -> Self {
        let slots = (0..P::QUEUE.max(1)).map(|_| Cell::new(P::default())).collect();
        Self { writer, slots, published: Cell::new(0), retired: Cell::new(false) }
    }

    fn slot(&self, number: u64) -> &Cell<P> {
        // The remainder fits: it is less than the length of a slice.
        #[allow(clippy::cast_possible_truncation)]
        &self.slots[(number % self.slots.len() as u64) as usize]
    }

    fn push(&self, sample: P) {
        let number = self.published.get();
        self.slot(number).set(sample);
        self.published.set(number + 1);
    }

    /// The oldest sample that is still there and not older than `wanted`.
    fn oldest_since(&self, wanted: u64) -> u64 {
        wanted.max(self.published.get().saturating_sub(self.slots.len() as u64))
    }
}

/// How far a reader has read a ring.
struct Feed<P> {
    ring: Rc<Ring<P>>,
    next: u64,
}

impl<P: Payload> Feed<P> {
    fn is_empty(&self) -> bool {
        self.next == self.ring.published.get()
    }
}

type Inbox<P> = RefCell<Vec<Feed<P>>>;

/// What the ports of one topic share.
struct Hub<P> {
    rings: RefCell<Vec<Rc<Ring<P>>>>,
    inboxes: RefCell<Vec<Weak<Inbox<P>>>>,
    readers: Cell<usize>,
    /// How many samples all writers together have published: a reader that has seen as many need not ask each ring.
    published: Cell<u64>,
    claim: Arc<Claim>,
}

/// A topic of one robot, on one thread.
pub(super) struct DirectTopic<P> {
    hub: Rc<Hub<P>>,
}

impl<P: Payload> DirectTopic<P> {
    pub(super) fn new(claim: Arc<Claim>) -> Self {
        let hub =
            Hub { rings: RefCell::default(), inboxes: RefCell::default(), readers: Cell::new(0), published: Cell::new(0), claim };
        Self { hub: Rc::new(hub) }
    }
}

impl<P: Payload> Topic<P> for DirectTopic<P> {
    fn writer(&self, number: WriterNumber) -> Result<Box<dyn Writer<P>>, LinkError> {
        let limit = most_writers::<P>();
        if self.hub.rings.borrow().len() >= limit {
            return Err(LinkError::TooManyWriters { robot: self.hub.claim.robot().into(), topic: P::TOPIC, limit });
        }
        let ring = Rc::new(Ring::new(number));
        self.hub.rings.borrow_mut().push(Rc::clone(&ring));
        self.hub.inboxes.borrow_mut().retain(|inbox| match inbox.upgrade() {
            Some(inbox) => {
                inbox.borrow_mut().push(Feed { ring: Rc::clone(&ring), next: 0 });
                true
            }
            None => false,
        });
        Ok(Box::new(DirectWriter { ring, hub: Rc::clone(&self.hub) }))
    }

    fn reader(&self) -> Result<Box<dyn Reader<P>>, LinkError> {
        let limit = limits::READERS;
        if self.hub.readers.get() >= limit {
            return Err(LinkError::TooManyReaders { robot: self.hub.claim.robot().into(), topic: P::TOPIC, limit });
        }
        let feeds: Vec<_> =
            self.hub.rings.borrow().iter().map(|ring| Feed { ring: Rc::clone(ring), next: ring.published.get() }).collect();
        let inbox = Rc::new(RefCell::new(feeds));
        let mut inboxes = self.hub.inboxes.borrow_mut();
        inboxes.retain(|inbox| inbox.strong_count() > 0);
        inboxes.push(Rc::downgrade(&inbox));
        self.hub.readers.set(self.hub.readers.get() + 1);
        Ok(Box::new(DirectReader { inbox, seen: self.hub.published.get(), hub: Rc::clone(&self.hub) }))
    }
}

struct DirectWriter<P> {
    ring: Rc<Ring<P>>,
    hub: Rc<Hub<P>>,
}

impl<P: Payload> Writer<P> for DirectWriter<P> {
    fn publish(&mut self, sample: &P) -> Result<usize, LinkError> {
        self.ring.push(*sample);
        self.hub.published.set(self.hub.published.get() + 1);
        Ok(self.hub.readers.get())
    }
}

impl<P> Drop for DirectWriter<P> {
    fn drop(&mut self) {
        self.hub.rings.borrow_mut().retain(|ring| !Rc::ptr_eq(ring, &self.ring));
        self.ring.retired.set(true);
        for inbox in self.hub.inboxes.borrow().iter().filter_map(Weak::upgrade) {
            retire(&mut inbox.borrow_mut(), &self.ring);
        }
    }
}

/// Forgets a ring whose writer is gone, unless samples in it are unread and there is room for another such.
fn retire<P>(feeds: &mut Vec<Feed<P>>, gone: &Rc<Ring<P>>) {
    let unread = |feed: &Feed<P>| feed.next != feed.ring.published.get();
    feeds.retain(|feed| !feed.ring.retired.get() || unread(feed));
    if feeds.iter().filter(|feed| feed.ring.retired.get()).count() > RETIRED_WRITERS {
        feeds.retain(|feed| !Rc::ptr_eq(&feed.ring, gone));
    }
}

struct DirectReader<P> {
    inbox: Rc<Inbox<P>>,
    hub: Rc<Hub<P>>,
    /// How many samples had been published at the last look.
    seen: u64,
}

impl<P: Payload> DirectReader<P> {
    /// Shows all samples that wait, writer by writer. The rings come in the order of their writers, who are numbered as they come.
    fn look(&mut self, mut show: impl FnMut(WriterNumber, &P)) {
        let published = self.hub.published.get();
        if published == self.seen {
            return;
        }
        self.seen = published;
        let mut any_retired = false;
        let mut feeds = self.inbox.borrow_mut();
        for feed in feeds.iter_mut() {
            let end = feed.ring.published.get();
            for number in feed.ring.oldest_since(feed.next)..end {
                show(feed.ring.writer, &feed.ring.slot(number).get());
            }
            feed.next = end;
            any_retired |= feed.ring.retired.get();
        }
        if any_retired {
            feeds.retain(|feed| !(feed.ring.retired.get() && feed.is_empty()));
        }
    }
}

impl<P: Payload> Reader<P> for DirectReader<P> {
    fn fetch(&mut self, into: &mut Vec<Arrival<P>>) {
        self.look(|writer, sample| into.push(Arrival { writer, sample: *sample }));
    }

    fn show(&mut self, show: &mut dyn FnMut(&P)) -> bool {
        self.look(|_, sample| show(sample));
        true
    }
}

impl<P> Drop for DirectReader<P> {
    fn drop(&mut self) {
        self.hub.readers.set(self.hub.readers.get() - 1);
    }
}
