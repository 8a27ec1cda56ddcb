//! Stopping, pausing and single-stepping a fleet from outside.

use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicU64, Ordering},
};

/// A remote control for a running fleet; works from any thread.
#[derive(Debug, Clone, Default)]
pub struct FleetControl {
    state: Arc<State>,
}

#[derive(Debug, Default)]
struct State {
    stop: AtomicBool,
    paused: AtomicBool,
    steps: AtomicU64,
}

impl FleetControl {
    /// Ends the mission after the current step: all bases stop, the recording is closed.
    pub fn stop(&self) {
        self.state.stop.store(true, Ordering::Relaxed);
    }

    /// Halts the steps before the next one. In lockstep time halts with them; at wall time it goes on, and the bases, which hear
    /// nothing new, stop by themselves.
    pub fn pause(&self) {
        self.state.paused.store(true, Ordering::Relaxed);
    }

    /// Lets time go on.
    pub fn resume(&self) {
        self.state.paused.store(false, Ordering::Relaxed);
    }

    /// Allows this many steps while paused.
    pub fn step(&self, steps: u64) {
        self.state.steps.fetch_add(steps, Ordering::Relaxed);
    }

    /// True once [`FleetControl::stop`] was called.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.state.stop.load(Ordering::Relaxed)
    }

    /// True if both control the same fleet.
    pub(super) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.state, &other.state)
    }

    /// True if the next step has to wait. Uses up one allowed step otherwise.
    pub(super) fn holds(&self) -> bool {
        let take = |steps: u64| steps.checked_sub(1);
        self.state.paused.load(Ordering::Relaxed)
            && !self.is_stopped()
            && self.state.steps.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take).is_err()
    }
}
