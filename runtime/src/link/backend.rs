//! What carries samples, and how a run is found by others.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What carries the samples of a run. In a mission file: `links = "shared"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Backend {
    /// Shared memory: a monitor, a recorder or a driver in another process of the same user can attach to the running robot if the run has a
    /// name.
    #[default]
    Shared,
    /// iceoryx2 inside the process: no files and no descriptors, nobody outside can attach.
    Local,
    /// Rings on the heap of the robot's own thread: the cheapest, for swarms; nobody outside can attach.
    Direct,
}

/// Where a run lives.
#[derive(Debug, Clone, Default)]
pub struct BusOptions {
    /// The name under which other processes find the run; `None` for a run that nobody else is to find. At most 64 letters,
    /// digits, `-`, `_` and `.`.
    pub run: Option<String>,
    /// The directory that holds the runs of this user, at most 41 bytes long. `None` for `/dev/shm/orienteer-<uid>`, or the
    /// same in the temporary directory where there is no `/dev/shm`. Only `shared` uses it.
    pub root: Option<PathBuf>,
}
