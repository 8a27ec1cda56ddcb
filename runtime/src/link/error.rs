//! Why a link could not be made or used, with a hint for each reason.

use std::{fmt, path::PathBuf};

use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};
use thiserror::Error;

use crate::topics::{Payload, limits};

/// What tells one payload type from another: its versioned name and its layout.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PayloadLayout {
    /// The type's name with its version, as in `orienteer::SonarScan.v1`.
    pub name: String,
    /// Bytes.
    pub size: usize,
    /// Bytes.
    pub alignment: usize,
}

impl PayloadLayout {
    /// The layout of `P`.
    #[must_use]
    pub fn of<P: Payload>() -> Self {
        Self::from(&TypeDetail::new::<P>(TypeVariant::FixedSize))
    }
}

impl From<&TypeDetail> for PayloadLayout {
    fn from(detail: &TypeDetail) -> Self {
        Self { name: detail.type_name().to_string(), size: detail.size(), alignment: detail.alignment() }
    }
}

impl fmt::Display for PayloadLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` ({} bytes, aligned to {})", self.name, self.size, self.alignment)
    }
}

/// Why a link could not be made or used. [`LinkError::hint`] says what to do about it.
#[derive(Debug, Error)]
pub enum LinkError {
    /// A name holds something that cannot be in it.
    #[error("`{name}` cannot name a {kind}: {reason}")]
    BadName {
        /// What was to be named.
        kind: &'static str,
        /// The name.
        name: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The robot's bus has been taken already.
    #[error("robot `{robot}` is on this bus already")]
    RobotTaken {
        /// The robot.
        robot: String,
    },
    /// The topic exists with another payload.
    #[error("topic `{topic}` of robot `{robot}` carries {found}, but {wanted} was asked for")]
    IncompatiblePayload {
        /// The robot.
        robot: String,
        /// The topic.
        topic: &'static str,
        /// What the topic carries.
        found: PayloadLayout,
        /// What this process wants of it.
        wanted: PayloadLayout,
    },
    /// The topic has all the writers that it may have.
    #[error("topic `{topic}` of robot `{robot}` has {limit} writer(s) already, which is all it may have")]
    TooManyWriters {
        /// The robot.
        robot: String,
        /// The topic.
        topic: &'static str,
        /// How many it may have.
        limit: usize,
    },
    /// The topic has all the readers that it may have.
    #[error("topic `{topic}` of robot `{robot}` has {limit} readers already, which is all it may have")]
    TooManyReaders {
        /// The robot.
        robot: String,
        /// The topic.
        topic: &'static str,
        /// How many it may have.
        limit: usize,
    },
    /// More processes use a topic than it was made for.
    #[error("{limit} processes use {what} already, which is all that may")]
    TooManyProcesses {
        /// What they use.
        what: String,
        /// How many may.
        limit: usize,
    },
    /// The process may not open any more files.
    #[error("out of file descriptors while making {what}: this process may have {limit}")]
    OutOfDescriptors {
        /// What was being made.
        what: String,
        /// The limit in force.
        limit: u64,
    },
    /// There is too little room on the tmpfs.
    #[error("not enough shared memory for {what}: {place} has {free} bytes left, and {needed} may be needed", place = .place.display())]
    OutOfSharedMemory {
        /// What was being made.
        what: String,
        /// Where there is too little room.
        place: PathBuf,
        /// Bytes left.
        free: u64,
        /// Bytes that this process's links may come to use in addition to what they use now.
        needed: u64,
    },
    /// Another process runs under that name.
    #[error("the run `{run}` is taken: {}", .pid.map_or_else(|| "another process has it".to_owned(), |pid| format!("process {pid} has it")))]
    RunTaken {
        /// The run's public name.
        run: String,
        /// The process that has it.
        pid: Option<u32>,
    },
    /// There is nothing to attach to.
    #[error("no run `{run}` is going on")]
    NoSuchRun {
        /// The run's public name.
        run: String,
    },
    /// The run's directory has too long a name for the sockets in it.
    #[error("the directory {path} has {length} bytes in its name, and {limit} are the most", path = .path.display())]
    PathTooLong {
        /// The directory.
        path: PathBuf,
        /// Bytes in its name.
        length: usize,
        /// The most that leave room for the names of sockets.
        limit: usize,
    },
    /// The directory of this user's runs cannot be trusted or used.
    #[error("{path} cannot be used for runs: {reason}", path = .path.display())]
    NoPermission {
        /// The directory.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Another process has held the directory of runs for too long.
    #[error("another process holds {path} and does not let go", path = .path.display())]
    Stuck {
        /// The directory.
        path: PathBuf,
    },
    /// The file system refused something.
    #[error("cannot {what} {path}: {source}", path = .path.display())]
    Io {
        /// What was tried.
        what: &'static str,
        /// On which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Only the `shared` back end can do this.
    #[error("{what} needs shared links")]
    NeedsShared {
        /// What was asked for.
        what: &'static str,
    },
    /// A doorbell was asked for outside a tokio runtime.
    #[error("a doorbell can only be made inside a tokio runtime (an actix arbiter has one)")]
    NoRuntime,
    /// iceoryx2 failed for another reason.
    #[error("cannot make {what}: {cause}")]
    Transport {
        /// What was being made or done.
        what: String,
        /// What iceoryx2 said.
        cause: String,
    },
}

impl LinkError {
    /// What a person can do about it, a sentence or two.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::BadName { .. } => "use letters, digits, `-`, `_` and `.`; a topic's levels are joined by `/`".into(),
            Self::RobotTaken { .. } => "give every robot of a mission a name of its own".into(),
            Self::IncompatiblePayload { found, wanted, .. } if found.name == wanted.name => {
                "two different types bear one name: change the version in `#[type_name(..)]` with the layout, and rebuild both programs".into()
            }
            Self::IncompatiblePayload { .. } => {
                "run programs of one version on both ends, or give your own payload a topic of its own".into()
            }
            Self::TooManyWriters { limit: 1, .. } => {
                "exactly one node may write this topic: remove one of the two, or stop the driver in the other process".into()
            }
            Self::TooManyWriters { .. } => format!("a robot may have {} nodes that claim", limits::NODES),
            Self::TooManyReaders { .. } => "detach some monitors or recorders".into(),
            Self::TooManyProcesses { .. } => "detach some monitors, recorders or drivers".into(),
            Self::OutOfDescriptors { .. } => {
                "set `mission.links` to `links = \"local\"` or `\"direct\"`, which need no descriptors, or raise the limit (`ulimit -n`)".into()
            }
            Self::OutOfSharedMemory { .. } => {
                "enlarge the tmpfs, end other runs, or set `mission.links` to `\"local\"` or `\"direct\"`, which need no shared memory".into()
            }
            Self::RunTaken { .. } => "stop that run, or give this one another name (`mission.run`)".into(),
            Self::NoSuchRun { .. } => {
                "start it first, as the same user, with `links = \"shared\"` and that name in `mission.run`".into()
            }
            Self::PathTooLong { .. } => "choose a shorter directory for runs, such as one right under /dev/shm".into(),
            Self::NoPermission { .. } => {
                "run every process of a robot as one user; remove the directory if it should not be there".into()
            }
            Self::Stuck { .. } => "see whether a process of this program is stopped, and continue or end it".into(),
            Self::Io { .. } => "see that the directory exists, is on a tmpfs and belongs to this user".into(),
            Self::NeedsShared { .. } => "set `mission.links` to `links = \"shared\"`".into(),
            Self::NoRuntime => "make the doorbell inside the actor that waits for it".into(),
            Self::Transport { .. } => {
                "run programs of one version on both ends; if nobody else is attached, this is a fault in the program".into()
            }
        }
    }
}
