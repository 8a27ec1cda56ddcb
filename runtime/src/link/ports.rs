//! What every back end offers: topics, writers and readers behind one type.

use std::fmt;

use super::LinkError;
use crate::topics::Payload;

/// A writer's place in a reader's order: the run's owner counts its writers of a topic from 0, attached processes start from
/// greater numbers of their own.
pub(super) type WriterNumber = u64;

/// A sample with the number of its writer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival<P> {
    pub(super) writer: WriterNumber,
    pub(super) sample: P,
}

/// One topic of one robot on some back end.
pub(super) trait Topic<P: Payload> {
    fn writer(&self, number: WriterNumber) -> Result<Box<dyn Writer<P>>, LinkError>;
    fn reader(&self) -> Result<Box<dyn Reader<P>>, LinkError>;
}

/// The back end of a [`Publisher`].
pub(super) trait Writer<P: Payload> {
    fn publish(&mut self, sample: &P) -> Result<usize, LinkError>;
}

/// The back end of a [`Subscriber`].
pub(super) trait Reader<P: Payload> {
    /// Appends all samples that wait, each writer's in the order of publication; writers may come in any order.
    fn fetch(&mut self, into: &mut Vec<Arrival<P>>);

    /// Shows all samples that wait, in their final order and where they lie, and forgets them. False, with nothing done, if the
    /// back end can only fetch. `show` must not touch the link.
    fn show(&mut self, _show: &mut dyn FnMut(&P)) -> bool {
        false
    }
}

/// The writing end of a topic. Made by [`RobotBus::publisher`](super::RobotBus::publisher).
pub struct Publisher<P: Payload> {
    writer: Box<dyn Writer<P>>,
}

impl<P: Payload> Publisher<P> {
    pub(super) fn new(writer: Box<dyn Writer<P>>) -> Self {
        Self { writer }
    }

    /// Gives the sample to every reader there is and returns how many these are. Never waits: a reader whose queue is full
    /// loses its oldest sample.
    ///
    /// # Errors
    /// [`LinkError::Transport`] if another process has damaged the shared memory; the other back ends never fail.
    pub fn publish(&mut self, sample: P) -> Result<usize, LinkError> {
        self.writer.publish(&sample)
    }
}

impl<P: Payload> fmt::Debug for Publisher<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Publisher({})", P::TOPIC)
    }
}

/// The reading end of a topic. Made by [`RobotBus::subscriber`](super::RobotBus::subscriber).
///
/// Samples are fetched from the link whenever nothing that was fetched before is left, all that wait at once.
pub struct Subscriber<P: Payload> {
    reader: Box<dyn Reader<P>>,
    fetched: Vec<Arrival<P>>,
    /// How many of `fetched` have been given out.
    given: usize,
}

impl<P: Payload> Subscriber<P> {
    pub(super) fn new(reader: Box<dyn Reader<P>>) -> Self {
        Self { reader, fetched: Vec::new(), given: 0 }
    }

    /// Shows every waiting sample to `f`, as [`Subscriber::drain`] does, but on the way that copies least. For those who are
    /// known not to publish or make ports from within `f`.
    pub(crate) fn collect(&mut self, mut f: impl FnMut(&P)) {
        let all_given = self.given == self.fetched.len();
        if !(all_given && self.reader.show(&mut f)) {
            self.drain(f);
        }
    }

    /// Shows every waiting sample to `f`, in the order that the [module](super) lays down, and returns how many these were.
    /// What is published from within `f` waits for the next call.
    pub fn drain(&mut self, mut f: impl FnMut(&P)) -> usize {
        self.fetch();
        while let Some(arrival) = self.fetched.get(self.given) {
            self.given += 1; // Before the call: if it panics, this sample has been seen.
            f(&arrival.sample);
        }
        self.given
    }

    /// The next waiting sample. Samples that wait behind it have left the link's queue: they stay with this subscriber until
    /// asked for, and no newer sample takes their place.
    pub fn take(&mut self) -> Option<P> {
        if self.given == self.fetched.len() {
            self.fetch();
        }
        let arrival = self.fetched.get(self.given)?;
        self.given += 1;
        Some(arrival.sample)
    }

    /// Keeps what has not been given out and puts what waits behind it.
    fn fetch(&mut self) {
        self.fetched.drain(..self.given);
        self.given = 0;
        let kept = self.fetched.len();
        self.reader.fetch(&mut self.fetched);
        in_order_of_writers(&mut self.fetched[kept..]);
    }
}

impl<P: Payload> fmt::Debug for Subscriber<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Subscriber({})", P::TOPIC)
    }
}

/// Sorts by writer and keeps each writer's order. Insertion: arrivals come sorted or nearly so, a stable sort of the standard
/// library allocates, and an unstable one would mix each writer's samples.
fn in_order_of_writers<P: Copy>(arrivals: &mut [Arrival<P>]) {
    for sorted in 1..arrivals.len() {
        let mut at = sorted;
        while at > 0 && arrivals[at - 1].writer > arrivals[at].writer {
            arrivals.swap(at - 1, at);
            at -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn sorting_is_by_writer_and_stable(writers in prop::collection::vec(0u64..5, 0..60)) {
            let mut arrivals: Vec<_> =
                writers.iter().enumerate().map(|(sample, &writer)| Arrival { writer, sample }).collect();
            let mut expected = arrivals.clone();
            expected.sort_by_key(|arrival| arrival.writer);
            in_order_of_writers(&mut arrivals);
            let key = |list: &[Arrival<usize>]| list.iter().map(|a| (a.writer, a.sample)).collect::<Vec<_>>();
            prop_assert_eq!(key(&arrivals), key(&expected));
        }
    }
}
