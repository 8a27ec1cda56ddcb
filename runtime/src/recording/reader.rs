//! Opens recordings, whole or cut off.

use std::{
    fmt, fs,
    fs::File,
    io::{self, BufReader, Read, Seek, SeekFrom},
    path::Path,
    sync::{Mutex, PoisonError},
};

use super::{
    LAYOUT, Mission, Source,
    mission::METADATA,
    scan::{ChunkSpan, Contents, ScanError, scan},
};
use crate::{
    time::Time,
    topics::{BaseDecision, ClientId, Payload},
};

/// How a recording ends. All that lies before the place named can be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// It is whole.
    Complete,
    /// It was cut off: the record that begins at this byte is incomplete.
    CutOff {
        /// Bytes from the start of the file.
        at: u64,
    },
    /// It is damaged: nothing from the record that begins at this byte on can be trusted.
    Damaged {
        /// Bytes from the start of the file.
        at: u64,
        /// What is wrong there.
        what: String,
    },
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Complete => write!(f, "complete"),
            Self::CutOff { at } => write!(f, "cut off in the record at byte {at}"),
            Self::Damaged { at, what } => write!(f, "damaged at byte {at}: {what}"),
        }
    }
}

/// A recording cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read the recording `{place}`: {source}")]
    Io {
        /// Which file.
        place: String,
        /// Why.
        source: io::Error,
    },
    /// The file is of another kind.
    #[error("`{place}` is not an MCAP file")]
    NotMcap {
        /// Which file.
        place: String,
    },
    /// The file is an MCAP file of somebody else's.
    #[error("`{place}` is an MCAP file, but not a recording of Orienteer's")]
    Foreign {
        /// Which file.
        place: String,
    },
    /// The file ends before the mission's description.
    #[error("`{place}` holds nothing that can be read: {ending}, before the mission is described")]
    Empty {
        /// Which file.
        place: String,
        /// How it ends.
        ending: Ending,
    },
    /// The mission's description makes no sense.
    #[error("`{place}` has a damaged description of its mission: {what}")]
    Mission {
        /// Which file.
        place: String,
        /// What is wrong.
        what: String,
    },
    /// The recording was laid out by another version.
    #[error("`{place}` has layout {found}, this program reads layout {known}")]
    Layout {
        /// Which file.
        place: String,
        /// The file's.
        found: String,
        /// This program's.
        known: u32,
    },
    /// Another tool has compressed the file.
    #[error("`{place}` is compressed with `{compression}`; unpack it first: mcap compress --compression none")]
    Compressed {
        /// Which file.
        place: String,
        /// How.
        compression: String,
    },
    /// The robot is not in the recording.
    #[error("there is no robot `{robot}` in `{place}`; its robots are: {known}")]
    Robot {
        /// Which file.
        place: String,
        /// The robot asked for.
        robot: String,
        /// All that there are.
        known: String,
    },
    /// The topic holds samples of another layout.
    #[error("`{topic}` in `{place}` holds {found}, this program reads {known}")]
    Payload {
        /// Which file.
        place: String,
        /// Which topic.
        topic: String,
        /// What the file has.
        found: String,
        /// What this program knows.
        known: String,
    },
    /// A message cannot be decoded.
    #[error("a message of `{topic}` at {time} in `{place}` cannot be decoded: {what}")]
    Message {
        /// Which file.
        place: String,
        /// Which topic.
        topic: String,
        /// Its log time.
        time: Time,
        /// Why.
        what: String,
    },
}

/// A recording, open for reading.
#[derive(Debug)]
pub struct Reader {
    pub(super) place: String,
    store: Mutex<Store>,
    pub(super) contents: Contents,
    mission: Mission,
    sources_expected: usize,
}

#[derive(Debug)]
enum Store {
    File(File),
    Memory(Vec<u8>),
}

impl Reader {
    /// Opens a file. Reads it through once and keeps only where things are.
    ///
    /// # Errors
    /// Everything in [`ReadError`] up to [`ReadError::Compressed`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self, ReadError> {
        let place = path.as_ref().display().to_string();
        let opened = || -> io::Result<_> {
            // Opening a directory succeeds, reading it does not.
            let length = fs::metadata(&path)?.len();
            Ok((File::open(&path)?, length))
        };
        match opened() {
            Ok((mut file, length)) => {
                let scanned = scan(&mut BufReader::with_capacity(256 << 10, &mut file), length);
                Self::new(place, Store::File(file), scanned)
            }
            Err(source) => Err(ReadError::Io { place, source }),
        }
    }

    /// Opens a recording that is in memory.
    ///
    /// # Errors
    /// Everything in [`ReadError`] from [`ReadError::NotMcap`] up to [`ReadError::Compressed`].
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, ReadError> {
        let scanned = scan(&mut bytes.as_slice(), bytes.len() as u64);
        Self::new("in memory".to_owned(), Store::Memory(bytes), scanned)
    }

    fn new(place: String, store: Store, scanned: Result<Contents, ScanError>) -> Result<Self, ReadError> {
        let contents = match scanned {
            Ok(contents) => contents,
            Err(ScanError::Io(source)) => return Err(ReadError::Io { place, source }),
            Err(ScanError::NotMcap) => return Err(ReadError::NotMcap { place }),
            Err(ScanError::Compressed(compression)) => return Err(ReadError::Compressed { place, compression }),
        };
        let Some((_, entries)) = contents.metadata.iter().find(|(name, _)| name == METADATA) else {
            // Whoever wrote it names itself first; a file cut off even before that may be anyone's.
            let ours = contents.library.as_deref().is_none_or(|library| library == METADATA);
            return Err(match contents.ending {
                ending if ours && ending != Ending::Complete => ReadError::Empty { place, ending },
                _ => ReadError::Foreign { place },
            });
        };
        match entries.get("layout").map(String::as_str) {
            Some(found) if found == LAYOUT.to_string() => {}
            Some(found) => return Err(ReadError::Layout { place, found: found.to_owned(), known: LAYOUT }),
            None => return Err(ReadError::Foreign { place }),
        }
        match Mission::from_metadata(entries) {
            Ok((mission, sources_expected)) => {
                let mission = Mission { sources: contents.sources.clone(), ..mission };
                Ok(Self { place, store: Mutex::new(store), contents, mission, sources_expected })
            }
            Err(what) => Err(ReadError::Mission { place, what }),
        }
    }

    /// What the recording is of: seed, times, robots, sources of the configuration.
    #[must_use]
    pub fn mission(&self) -> &Mission {
        &self.mission
    }

    /// The configuration's source files, the mission file first, if the recording has all of them; one that was cut off
    /// near its beginning has not.
    #[must_use]
    pub fn sources(&self) -> Option<&[Source]> {
        (self.mission.sources.len() == self.sources_expected).then_some(&self.mission.sources)
    }

    /// How the recording ends.
    #[must_use]
    pub fn ending(&self) -> &Ending {
        &self.contents.ending
    }

    /// Log time of the last message that can be read; the start if there is none.
    #[must_use]
    pub fn end_time(&self) -> Time {
        Time::from_nanos(self.contents.chunks.iter().map(|chunk| chunk.times.1).max().unwrap_or(0))
    }

    /// All topics that have messages, in alphabetical order.
    pub fn topics(&self) -> impl Iterator<Item = &str> {
        let mut topics: Vec<_> = self.contents.channels.values().map(|channel| channel.topic.as_str()).collect();
        topics.sort_unstable();
        topics.dedup();
        topics.into_iter()
    }

    /// The name of a robot's node: what a [`ClientId`] in a decision or notice stands for.
    #[must_use]
    pub fn client_name(&self, robot: &str, client: ClientId) -> Option<&str> {
        let info = self.mission.robots.iter().find(|info| info.name == robot)?;
        info.clients.get(usize::from(client.known()?.0)).map(String::as_str)
    }

    /// The arbitration's decision that was in force at `time`, and when it was recorded.
    ///
    /// # Errors
    /// As for [`Reader::messages`].
    pub fn decision_at(&self, robot: &str, time: Time) -> Result<Option<(Time, BaseDecision)>, ReadError> {
        self.latest::<BaseDecision>(robot, time)
    }

    /// The newest sample of a robot's topic that is no later than `time`, and its log time; `None` if there is none.
    ///
    /// # Errors
    /// As for [`Reader::messages`].
    pub fn latest<P: Payload>(&self, robot: &str, time: Time) -> Result<Option<(Time, P)>, ReadError> {
        // Log times never decrease, so the sample is in the last chunk that has any message early enough, or before.
        for chunk in (0..self.contents.chunks.len()).rev().filter(|i| self.contents.chunks[*i].times.0 <= time.as_nanos()) {
            if let Some(found) = self.messages::<P>(robot)?.only(chunk, time).last().transpose()? {
                return Ok(Some(found));
            }
        }
        self.known_robot(robot)?;
        Ok(None)
    }

    /// Fails unless the recording has this robot.
    pub(super) fn known_robot(&self, robot: &str) -> Result<(), ReadError> {
        let prefix = format!("/{robot}/");
        let known = |info: &super::RobotInfo| info.name == robot;
        if self.mission.robots.iter().any(known) || self.topics().any(|topic| topic.starts_with(&prefix)) {
            return Ok(());
        }
        let names: Vec<_> = self.mission.robots.iter().map(|info| info.name.as_str()).collect();
        Err(ReadError::Robot { place: self.place.clone(), robot: robot.to_owned(), known: names.join(", ") })
    }

    /// Reads the records of a chunk.
    pub(super) fn load(&self, span: ChunkSpan, records: &mut Vec<u8>) -> Result<(), ReadError> {
        records.clear();
        records.resize(span.length, 0);
        let read = match &mut *self.store.lock().unwrap_or_else(PoisonError::into_inner) {
            Store::File(file) => file.seek(SeekFrom::Start(span.offset)).and_then(|_| file.read_exact(records)),
            Store::Memory(bytes) => bytes
                .get(span.offset as usize..)
                .and_then(|rest| rest.get(..span.length))
                .map(|chunk| records.copy_from_slice(chunk))
                .ok_or_else(|| io::ErrorKind::UnexpectedEof.into()),
        };
        read.map_err(|source| ReadError::Io { place: self.place.clone(), source })
    }
}
