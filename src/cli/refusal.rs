//! Why a command could not be carried out, and how a person is told.

use std::io::ErrorKind;

use crate::{
    mission::RunError,
    runtime::{
        config::{Problem, Problems},
        fleet::FleetError,
        host::HostError,
        link::LinkError,
        recording::{ReadError, RecordError},
    },
};

use super::{
    Outcome,
    style::{self, Paint},
};

/// A command could not be carried out.
#[derive(Debug)]
pub struct Refusal {
    outcome: Outcome,
    problems: Problems,
}

impl Refusal {
    /// The command line is wrong.
    pub fn misused(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { outcome: Outcome::Misused, problems: Problem::nowhere(message, hint).into() }
    }

    /// Something failed.
    pub fn failed(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { outcome: Outcome::Failed, problems: Problem::nowhere(message, hint).into() }
    }

    /// Tells a program on standard output or a person as a compiler would, and returns what the command comes to.
    pub fn tell(self, json: bool) -> Outcome {
        let told = json.then(|| style::print_json(&serde_json::json!({ "ok": false, "problems": self.problems })));
        if !matches!(told, Some(Ok(()))) {
            let colour = Paint::stderr().is_coloured();
            let list = self.problems.list();
            let text = if list.iter().any(|problem| problem.location().is_some()) {
                self.problems.render(colour)
            } else {
                list.iter().map(|problem| problem.render(colour)).collect::<Vec<_>>().join("\n\n")
            };
            style::complain_of(&text);
        }
        self.outcome
    }
}

impl From<Problems> for Refusal {
    fn from(problems: Problems) -> Self {
        Self { outcome: Outcome::Misused, problems }
    }
}

impl From<RunError> for Refusal {
    fn from(error: RunError) -> Self {
        let misused = is_misuse(&error);
        let hint = match error {
            RunError::Config(problems) => return problems.into(),
            RunError::Overwrites { .. } => {
                "name another file with `--record` or `[record] file`; recordings end in `.mcap`".to_owned()
            }
            RunError::Link(ref error) | RunError::Fleet(FleetError::Host(HostError::Link(ref error))) => error.hint(),
            RunError::Output(_) => "name another directory with `--out`".to_owned(),
            RunError::Record(RecordError::Create { .. }) => {
                "name another file with `--record`, in a directory that exists, or run with `--no-record`".to_owned()
            }
            RunError::Record(_) => "look at the disk's free space, or run with `--no-record`".to_owned(),
            RunError::Fleet(FleetError::Descriptors(ref error)) => error.hint(),
            RunError::Fleet(_) => "`-vv` shows more of what led to it".to_owned(),
        };
        let text = error.to_string();
        // Some errors bring their hint along.
        let message = text.split("\nhint: ").next().unwrap_or_default();
        if misused { Self::misused(message, hint) } else { Self::failed(message, hint) }
    }
}

/// True if nothing was run because of what somebody has asked for, and not because the machine is short of something.
fn is_misuse(error: &RunError) -> bool {
    let short = |kind| matches!(kind, ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::OutOfMemory);
    match error {
        RunError::Config(_) | RunError::Overwrites { .. } | RunError::Link(LinkError::RunTaken { .. }) => true,
        RunError::Output(error) => !short(error.kind()),
        RunError::Record(RecordError::Create { source, .. }) => !short(source.kind()),
        RunError::Link(_) | RunError::Fleet(_) | RunError::Record(_) => false,
    }
}

impl From<ReadError> for Refusal {
    fn from(error: ReadError) -> Self {
        let message = error.to_string();
        match error {
            ReadError::Io { source, .. } if source.kind() == ErrorKind::NotFound => {
                Self::misused(message, "`orienteer run` writes recordings; unless told otherwise, into `out/`")
            }
            ReadError::Io { source, .. } if source.kind() == ErrorKind::IsADirectory => {
                Self::misused(message, "name a recording in it (`.mcap`)")
            }
            ReadError::Io { .. } => Self::failed(message, "check the file's permissions and the disk"),
            ReadError::NotMcap { .. } | ReadError::Foreign { .. } => {
                Self::misused(message, "name a recording (`.mcap`) that `orienteer run` has written")
            }
            ReadError::Empty { .. } | ReadError::Mission { .. } | ReadError::Message { .. } => {
                Self::failed(message, "the file is damaged; record the mission again")
            }
            ReadError::Layout { .. } | ReadError::Payload { .. } => {
                Self::misused(message, "use the version of orienteer that wrote it, or record the mission again")
            }
            ReadError::Robot { .. } => Self::misused(message, "give one of these with `--robot`"),
            _ => Self::misused(message, "record the mission again"),
        }
    }
}
