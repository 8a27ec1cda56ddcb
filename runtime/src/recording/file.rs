//! Writes the entries of all robots into one MCAP stream.

use std::{
    collections::BTreeMap,
    fs::{File, TryLockError},
    io::{self, BufWriter, Read, Write},
    path::{Path, PathBuf},
};

use mcap::{McapError, records::MessageHeader, write::NoSeek};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::{
    Mission,
    entries::{ChannelEntry, Entry, EntryReader, MessageEntry},
    hex,
    mission::METADATA,
};

/// Where a recording goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Sink {
    /// To a file, which is created or replaced.
    File(PathBuf),
    /// To memory; the summary holds the bytes.
    Memory,
    /// Nowhere: only the summary, with its hash, remains.
    Hash,
}

/// When a chunk of a recording ends. A killed process loses what its last, open chunk held. The limits shape the file's bytes, so
/// recordings are equal only under equal limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ChunkLimits {
    /// A chunk ends when it holds this much, KiB. The format's own default is 1 MiB.
    #[schemars(range(min = 1, max = 65_536))]
    pub chunk_kib: u32,
    /// A chunk ends when it covers this much time, s.
    #[schemars(range(min = 0.01, max = 86_400.0))]
    pub chunk_seconds: f64,
}

impl Default for ChunkLimits {
    fn default() -> Self {
        Self { chunk_kib: 1024, chunk_seconds: 10.0 }
    }
}

/// What became of a recording.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecordingSummary {
    /// The file, if it was one.
    pub path: Option<PathBuf>,
    /// Its size.
    pub bytes: u64,
    /// SHA-256 sum of all its bytes, in hex digits.
    pub sha256: String,
    /// Number of messages in it.
    pub messages: u64,
    /// Its bytes, if it went to memory.
    pub memory: Option<Vec<u8>>,
}

/// A recording cannot be written (any further). What was written before stays readable.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be created.
    #[error("cannot create the recording `{}`: {source}", path.display())]
    Create {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write the recording `{place}`: {source}; {messages} messages were written before")]
    Write {
        /// Which file.
        place: String,
        /// Why.
        source: io::Error,
        /// How many messages had been accepted. Those of the last chunk may be missing.
        messages: u64,
    },
    /// The recording has outgrown the format.
    #[error("the recording `{place}` cannot go on: {source}")]
    Format {
        /// Which file.
        place: String,
        /// What is too large or too many.
        source: McapError,
    },
    /// The mission cannot be described in the file.
    #[error("cannot describe the mission in the recording: {0}")]
    Mission(#[from] serde_json::Error),
    /// The entries of robot {robot} are incomplete: some were lost, or two tracks bear its number.
    #[error("the recording cannot go on: entries of robot {robot} were lost, or two tracks bear its number")]
    Entries {
        /// The robot's number.
        robot: usize,
    },
    /// No thread for writing can be started.
    #[error("cannot start a thread for the recording: {0}")]
    Thread(io::Error),
    /// The writing thread has panicked.
    #[error("the recording `{place}` cannot go on: its thread has panicked")]
    Panicked {
        /// Which file.
        place: String,
    },
}

/// The file's end of a recording.
pub(super) struct RecordingFile {
    mcap: mcap::Writer<NoSeek<Tee>>,
    path: Option<PathBuf>,
    place: String,
    /// Of each robot, the file's numbers of its channels.
    channels: BTreeMap<usize, Vec<u16>>,
    limits: Limits,
    chunk: Chunk,
    messages: u64,
}

struct Limits {
    bytes: u64,
    nanos: u64,
}

/// The open chunk.
#[derive(Default)]
struct Chunk {
    bytes: u64,
    /// Time of its first message.
    begin: Option<u64>,
}

/// Bytes of a message record apart from its data: opcode, length, channel, sequence, two times.
const MESSAGE_OVERHEAD: u64 = 1 + 8 + 2 + 4 + 8 + 8;

impl RecordingFile {
    /// Creates the file and writes what stands before all messages: the mission and its sources.
    pub(super) fn create(sink: Sink, mission: &Mission, limits: &ChunkLimits) -> Result<Self, RecordError> {
        let metadata = mission.to_metadata()?;
        let path = if let Sink::File(path) = &sink { Some(path.clone()) } else { None };
        let place = path.as_ref().map_or_else(|| "in memory".to_owned(), |path| path.display().to_string());
        let fail = |error| failure(&place, 0, error);
        let output = Output::open(sink)?;
        // Seeking would write chunks before their length is known, and the running hash could not follow. Chunks are ended by
        // this module, not by their size alone.
        let options =
            mcap::WriteOptions::new().library(METADATA).profile("").compression(None).chunk_size(None).disable_seeking(true);
        let tee = NoSeek::new(Tee { output, hash: Sha256::new(), bytes: 0 });
        let mut mcap = options.create(tee).map_err(fail)?;
        mcap.write_metadata(&mcap::records::Metadata { name: METADATA.to_owned(), metadata }).map_err(fail)?;
        for source in &mission.sources {
            let media_type = if source.name.ends_with(".toml") { "application/toml" } else { "application/octet-stream" };
            mcap.attach(&mcap::Attachment {
                log_time: 0,
                create_time: 0,
                name: source.name.clone(),
                media_type: media_type.to_owned(),
                data: source.bytes.as_slice().into(),
            })
            .map_err(fail)?;
        }
        mcap.flush().map_err(fail)?;
        let limits = Limits { bytes: u64::from(limits.chunk_kib) << 10, nanos: (limits.chunk_seconds * 1e9).max(1.0) as u64 };
        Ok(Self { mcap, path, place, channels: BTreeMap::new(), limits, chunk: Chunk::default(), messages: 0 })
    }

    /// Writes the entries of one robot.
    pub(super) fn append(&mut self, robot: usize, entries: &[u8]) -> Result<(), RecordError> {
        for entry in EntryReader(entries) {
            match entry {
                Entry::Channel(channel) => self.add_channel(robot, &channel)?,
                Entry::Message(message) => self.add_message(robot, &message)?,
            }
        }
        Ok(())
    }

    fn add_channel(&mut self, robot: usize, entry: &ChannelEntry<'_>) -> Result<(), RecordError> {
        let known = self.channels.entry(robot).or_default();
        if known.len() != usize::from(entry.channel) {
            return Err(RecordError::Entries { robot });
        }
        let mut metadata = BTreeMap::new();
        if !entry.type_name.is_empty() {
            metadata.insert("type".to_owned(), entry.type_name.to_owned());
        }
        let schema = self.mcap.add_schema(entry.schema_name, entry.schema_encoding, entry.schema);
        let channel = schema.and_then(|schema| self.mcap.add_channel(schema, entry.topic, entry.message_encoding, &metadata));
        known.push(channel.map_err(|error| failure(&self.place, self.messages, error))?);
        Ok(())
    }

    fn add_message(&mut self, robot: usize, entry: &MessageEntry<'_>) -> Result<(), RecordError> {
        let channel = self.channels.get(&robot).and_then(|channels| channels.get(usize::from(entry.channel)));
        let Some(channel) = channel.copied() else { return Err(RecordError::Entries { robot }) };
        if self.chunk.begin.is_some_and(|begin| entry.log_time.saturating_sub(begin) >= self.limits.nanos) {
            self.end_chunk()?;
        }
        let header = MessageHeader {
            channel_id: channel,
            sequence: entry.sequence,
            log_time: entry.log_time,
            publish_time: entry.log_time,
        };
        let written = self.mcap.write_to_known_channel(&header, entry.data);
        written.map_err(|error| failure(&self.place, self.messages, error))?;
        self.messages += 1;
        self.chunk.begin.get_or_insert(entry.log_time);
        self.chunk.bytes += MESSAGE_OVERHEAD + entry.data.len() as u64;
        if self.chunk.bytes >= self.limits.bytes { self.end_chunk() } else { Ok(()) }
    }

    fn end_chunk(&mut self) -> Result<(), RecordError> {
        self.chunk = Chunk::default();
        self.mcap.flush().map_err(|error| failure(&self.place, self.messages, error))
    }

    /// Writes the summary and says what came out.
    pub(super) fn finish(mut self) -> Result<RecordingSummary, RecordError> {
        let fail = |error| failure(&self.place, self.messages, error);
        self.mcap.finish().map_err(fail)?;
        let mut tee = self.mcap.into_inner().into_inner();
        tee.flush().map_err(|error| failure(&self.place, self.messages, error.into()))?;
        Ok(RecordingSummary {
            path: self.path,
            bytes: tee.bytes,
            sha256: hex(&tee.hash.finalize()),
            messages: self.messages,
            memory: if let Output::Memory(bytes) = tee.output { Some(bytes) } else { None },
        })
    }

    /// How messages for people name the recording.
    pub(super) fn place(&self) -> &str {
        &self.place
    }
}

fn failure(place: &str, messages: u64, error: McapError) -> RecordError {
    let place = place.to_owned();
    match error {
        McapError::Io(source) => RecordError::Write { place, source, messages },
        source => RecordError::Format { place, source },
    }
}

/// Hashes and counts what passes through.
struct Tee {
    output: Output,
    hash: Sha256,
    bytes: u64,
}

enum Output {
    File(BufWriter<File>),
    Memory(Vec<u8>),
    Nowhere,
}

impl Output {
    fn open(sink: Sink) -> Result<Self, RecordError> {
        Ok(match sink {
            Sink::File(path) => {
                let file = create(&path).map_err(|source| RecordError::Create { path, source })?;
                Self::File(BufWriter::with_capacity(64 << 10, file))
            }
            Sink::Memory => Self::Memory(Vec::new()),
            Sink::Hash => Self::Nowhere,
        })
    }
}

/// Opens a file for one recording alone. Two runs into the same file would leave what nobody can read.
fn create(path: &Path) -> io::Result<File> {
    // Not cut off before it is ours.
    let file = File::options().write(true).create(true).truncate(false).open(path)?;
    if let Err(TryLockError::WouldBlock) = file.try_lock() {
        return Err(io::Error::new(io::ErrorKind::ResourceBusy, "another run records into it"));
    }
    // Devices and pipes have no length.
    if file.metadata()?.is_file() {
        file.set_len(0)?;
    }
    Ok(file)
}

impl Write for Tee {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match &mut self.output {
            Output::File(file) => file.write(bytes)?,
            Output::Memory(memory) => memory.write(bytes)?,
            Output::Nowhere => bytes.len(),
        };
        self.hash.update(&bytes[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.output {
            Output::File(file) => file.flush(),
            Output::Memory(_) | Output::Nowhere => Ok(()),
        }
    }
}

/// True if a recording written to this path costs nobody anything but an older recording: nothing is there, or nothing in it, or
/// it is no ordinary file.
#[must_use]
pub fn may_be_replaced(path: &Path) -> bool {
    // A pipe would keep whoever opens it waiting.
    if !path.metadata().is_ok_and(|data| data.is_file()) {
        return true;
    }
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(mcap::MAGIC.len() as u64).read_to_end(&mut start));
    // What can't be read will hardly be written either, and that is told then.
    read.is_err() || start.is_empty() || start == mcap::MAGIC
}
