//! What shared links use up: descriptors and room on the tmpfs.

use std::path::Path;

use super::LinkError;
use crate::descriptors;

/// Where POSIX shared memory lies on Linux.
pub(super) const SHARED_MEMORY: &str = "/dev/shm";

/// Kept free beyond what is reserved: queues and services take some that nobody counts.
const MARGIN: u64 = 1 << 20;

/// Making a topic's service and a pair of ports takes a dozen descriptors at most.
const DESCRIPTORS_OF_A_TOPIC: u64 = 16;

/// Finds out why making `what` failed, because iceoryx2 does not say: its `cause` stands if no resource is short.
pub(super) fn diagnose(what: String, cause: String, place: &Path) -> LinkError {
    if descriptors::free(DESCRIPTORS_OF_A_TOPIC) < DESCRIPTORS_OF_A_TOPIC {
        return LinkError::OutOfDescriptors { what, limit: descriptors::limit() };
    }
    match free_bytes(place) {
        Some(free) if free < MARGIN => LinkError::OutOfSharedMemory { what, place: place.into(), free, needed: MARGIN },
        _ => LinkError::Transport { what, cause },
    }
}

/// Refuses to make `what` if the tmpfs could fill up: a write to a full one kills the process (SIGBUS), it is no error.
///
/// `reserved` is what this process's links may grow to, `what` included. Pages that are in use already count twice, which
/// errs on the safe side.
pub(super) fn check_room(what: &str, reserved: u64, place: &Path) -> Result<(), LinkError> {
    let needed = reserved.saturating_add(MARGIN);
    match free_bytes(place) {
        Some(free) if free < needed => {
            Err(LinkError::OutOfSharedMemory { what: what.to_owned(), place: place.into(), free, needed })
        }
        _ => Ok(()), // If the system does not tell, try.
    }
}

fn free_bytes(place: &Path) -> Option<u64> {
    let status = rustix::fs::statvfs(place).ok()?;
    Some(status.f_bavail.saturating_mul(status.f_frsize))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn room_is_refused_before_it_runs_out() {
        let place = Path::new("/");
        let free = free_bytes(place).unwrap();
        assert!(check_room("a topic", 0, place).is_ok() || free < MARGIN);
        let refused = check_room("a topic", u64::MAX - 1, place).unwrap_err();
        assert!(matches!(refused, LinkError::OutOfSharedMemory { .. }));
        assert!(refused.hint().contains("mission.links"));
    }

    #[test]
    fn without_a_shortage_the_cause_stands() {
        let error = diagnose("a topic".into(), "InternalFailure".into(), Path::new("/"));
        assert!(matches!(error, LinkError::Transport { cause, .. } if cause == "InternalFailure"));
    }
}
