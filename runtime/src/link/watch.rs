//! A listener that a task can wait for.
//!
//! The only module of this crate with unsafe code: tokio watches a descriptor that iceoryx2 owns, and cannot check for itself
//! that it stays open for as long.

use std::os::fd::{AsRawFd, RawFd};

use iceoryx2::{
    port::{event_id::EventId, listener::Listener},
    prelude::{FileDescriptorBased, ipc},
};
use tokio::io::{Interest, unix::AsyncFd};

/// A listener's descriptor, by number.
struct Descriptor(RawFd);

impl AsRawFd for Descriptor {
    fn as_raw_fd(&self) -> RawFd {
        self.0
    }
}

/// A listener together with tokio's watch on its descriptor.
pub(super) struct WatchedListener {
    /// Declared before the listener, so dropped before it.
    watch: AsyncFd<Descriptor>,
    listener: Listener<ipc::Service>,
}

impl WatchedListener {
    /// Must be called inside a tokio runtime with I/O.
    pub(super) fn new(listener: Listener<ipc::Service>) -> std::io::Result<Self> {
        // SAFETY: the number is only used to watch the descriptor, never to close it or to change its owner.
        let descriptor = Descriptor(unsafe { listener.file_descriptor().native_handle() });
        // SAFETY: the listener owns the descriptor, keeps the same one for its whole life, and lives as long as the watch:
        // both are fields of one struct that nothing moves out of, and the watch is dropped first. `Descriptor` returns the
        // same number at each call.
        let watch = unsafe { AsyncFd::register_with_interest(descriptor, Interest::READABLE) }?;
        Ok(Self { watch, listener })
    }

    /// Waits until there is something to hear, then empties the listener as [`WatchedListener::empty`] does.
    pub(super) async fn ready(&self, heard: impl FnMut(EventId)) -> Result<(), String> {
        let mut guard = self.watch.readable().await.map_err(|error| error.to_string())?;
        let emptied = self.empty(heard);
        guard.clear_ready(); // Edge-triggered: only once it is empty.
        emptied
    }

    /// Shows all that was heard to `heard`. Goes on until nothing is left: a notification that arrives between iceoryx2's two
    /// steps of resetting itself would otherwise leave a listener that nothing wakes any more (0.10.0).
    pub(super) fn empty(&self, mut heard: impl FnMut(EventId)) -> Result<(), String> {
        while self.listener.try_wait(|event| heard(event.id)).map_err(|error| error.to_string())? > 0 {}
        Ok(())
    }
}
