//! How many files this process may have open at a time: `ulimit -n`.

use std::{fs::File, io};

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use thiserror::Error;

/// For the actor system on its first thread, a recording, and whatever is open for a moment only.
const OF_THE_FIRST: u64 = 8;
/// For each further thread, also the one that listens for signals.
const OF_A_THREAD: u64 = 6;

/// The system's words for it are of no use: more files have to be open at a time than this process may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("this process may have {limit} files open at a time, and needs at least {needed}")]
pub struct TooFewDescriptors {
    /// The limit in force.
    pub limit: u64,
    /// What the limit has to be at least.
    pub needed: u64,
}

impl TooFewDescriptors {
    /// What a person can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        "raise the limit: `ulimit -n 1024`, in the same shell, before the program is started".into()
    }
}

/// Sees to it that a fleet can be run on so many threads; links in shared memory need more files. The limit is raised as far as this user may.
///
/// # Errors
/// If too few files can be opened. The actor system would panic.
pub fn check_room_for(threads: usize) -> Result<(), TooFewDescriptors> {
    raise_limit();
    let wanted = OF_THE_FIRST + OF_A_THREAD * threads.saturating_sub(1) as u64;
    compare(wanted, free(wanted), limit())
}

/// So many files are to be opened, and so many can be beside those that are open.
fn compare(wanted: u64, free: u64, limit: u64) -> Result<(), TooFewDescriptors> {
    if free >= wanted {
        return Ok(());
    }
    Err(TooFewDescriptors { limit, needed: limit.saturating_sub(free).saturating_add(wanted) })
}

/// How many files a process may have open at a time, after its limit was raised as far as this user may.
#[must_use]
pub fn most() -> u64 {
    raise_limit();
    limit()
}

/// Lifts the limit as far as this user may.
pub(crate) fn raise_limit() {
    let limit = getrlimit(Resource::Nofile);
    if limit.current < limit.maximum || limit.maximum.is_none() {
        // If it fails, the limit stays, and running into it is reported as such.
        let _ = setrlimit(Resource::Nofile, Rlimit { current: limit.maximum, ..limit });
    }
}

/// The limit in force.
pub(crate) fn limit() -> u64 {
    getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX)
}

/// How many files the process can open beside those that are open, up to `most`. The machine has a limit, too.
pub(crate) fn free(most: u64) -> u64 {
    let open = (0..most).map_while(|_| match File::open("/dev/null") {
        Err(error) if is_shortage(&error) => None,
        opened => Some(opened),
    });
    open.collect::<Vec<_>>().len() as u64
}

/// True if this is what the system says when too many files are open.
pub(crate) fn is_shortage(error: &io::Error) -> bool {
    use rustix::io::Errno;
    [Errno::MFILE, Errno::NFILE].iter().any(|errno| error.raw_os_error() == Some(errno.raw_os_error()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shortage_says_what_the_limit_has_to_be() {
        assert_eq!(compare(8, 8, 20), Ok(()));
        // Thirteen are open, and eight more are to be.
        assert_eq!(compare(8, 7, 20), Err(TooFewDescriptors { limit: 20, needed: 21 }));
        // The machine's own limit may be the one in the way.
        assert_eq!(compare(8, 7, u64::MAX).map_err(|error| error.needed), Err(u64::MAX));
    }

    #[test]
    fn a_shortage_is_told_from_other_errors() {
        assert_eq!(free(3), 3);
        let of = |errno: i32| is_shortage(&io::Error::from_raw_os_error(errno));
        assert!(of(23) && of(24) && !of(2));
    }
}
