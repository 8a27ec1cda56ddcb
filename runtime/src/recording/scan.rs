//! Reads an MCAP stream from its beginning as far as it is whole.
//!
//! The summary at the end of a file is not used: a file that is cut off has none, and a whole one is read fast enough.

use std::{
    collections::BTreeMap,
    io::{self, Read},
};

use mcap::{
    MAGIC,
    records::{Record, op},
};

use super::{
    Source,
    reader::Ending,
    record::{CHUNK_HEADER, RECORD_HEADER, next_record, parse, raw_message},
};

/// All that lies outside of messages, and where the messages are.
#[derive(Debug)]
pub(super) struct Contents {
    /// What wrote the file, by its first record.
    pub(super) library: Option<String>,
    /// Name and entries of each metadata record.
    pub(super) metadata: Vec<(String, BTreeMap<String, String>)>,
    pub(super) sources: Vec<Source>,
    pub(super) channels: BTreeMap<u16, Channel>,
    pub(super) chunks: Vec<ChunkSpan>,
    pub(super) ending: Ending,
}

/// A channel of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Channel {
    pub(super) topic: String,
    pub(super) encoding: String,
    /// Versioned name of the payload's type; empty for Foxglove's.
    pub(super) type_name: String,
    pub(super) schema: Vec<u8>,
}

/// Where a whole chunk's records are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ChunkSpan {
    pub(super) offset: u64,
    pub(super) length: usize,
    /// Earliest and latest log time of its messages, ns.
    pub(super) times: (u64, u64),
}

/// Why a stream is not read at all.
#[derive(Debug)]
pub(super) enum ScanError {
    Io(io::Error),
    /// It does not begin like an MCAP file.
    NotMcap,
    /// Its chunks are compressed in this way.
    Compressed(String),
}

impl From<io::Error> for ScanError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Reads a stream of this many bytes.
pub(super) fn scan(stream: &mut dyn Read, length: u64) -> Result<Contents, ScanError> {
    let mut magic = [0; MAGIC.len()];
    let start = (length as usize).min(magic.len());
    stream.read_exact(&mut magic[..start])?;
    if magic[..start] != MAGIC[..start] {
        return Err(ScanError::NotMcap);
    }
    let mut scan = Scan {
        contents: Contents {
            library: None,
            metadata: Vec::new(),
            sources: Vec::new(),
            channels: BTreeMap::new(),
            chunks: Vec::new(),
            ending: Ending::CutOff { at: 0 },
        },
        schemas: BTreeMap::new(),
        data_checksum: crc32fast::Hasher::new(),
        length,
    };
    if start == MAGIC.len() {
        scan.data_checksum.update(MAGIC);
        scan.records(stream)?;
    }
    Ok(scan.contents)
}

struct Scan {
    contents: Contents,
    schemas: BTreeMap<u16, Vec<u8>>,
    data_checksum: crc32fast::Hasher,
    length: u64,
}

/// What a record means for the records after it.
enum Next {
    GoOn,
    /// The data has ended, only the summary follows.
    Summary,
    End(Ending),
}

impl Scan {
    fn records(&mut self, stream: &mut dyn Read) -> Result<(), ScanError> {
        let mut at = MAGIC.len() as u64;
        let mut in_data = true;
        let mut body = Vec::new();
        self.contents.ending = loop {
            let mut header = [0; RECORD_HEADER];
            let left = self.length - at;
            if left < RECORD_HEADER as u64 {
                break Ending::CutOff { at };
            }
            stream.read_exact(&mut header)?;
            let [code, l0, l1, l2, l3, l4, l5, l6, l7] = header;
            let length = u64::from_le_bytes([l0, l1, l2, l3, l4, l5, l6, l7]);
            if length > left - RECORD_HEADER as u64 {
                break Ending::CutOff { at };
            }
            body.resize(length as usize, 0);
            stream.read_exact(&mut body)?;
            let next = if in_data { self.data_record(code, &header, &body, at)? } else { Next::GoOn };
            at += RECORD_HEADER as u64 + length;
            match next {
                Next::End(ending) => break ending,
                Next::Summary => in_data = false,
                Next::GoOn if code == op::FOOTER => break self.tail(stream, at)?,
                Next::GoOn => {}
            }
        };
        Ok(())
    }

    /// A record before the end of the data.
    fn data_record(&mut self, code: u8, header: &[u8], body: &[u8], at: u64) -> Result<Next, ScanError> {
        if code == op::DATA_END {
            return Ok(self.data_end(body, at));
        }
        self.data_checksum.update(header);
        self.data_checksum.update(body);
        Ok(match self.keep(code, body, at)? {
            Ok(()) => Next::GoOn,
            Err(what) => Next::End(Ending::Damaged { at, what }),
        })
    }

    /// Keeps what a record says; the inner error tells what is wrong with it.
    fn keep(&mut self, code: u8, body: &[u8], at: u64) -> Result<Result<(), String>, ScanError> {
        let record = match parse(code, body) {
            Ok(record) => record,
            Err(what) => return Ok(Err(what)),
        };
        match record {
            Record::Chunk { header, data } => {
                match header.compression.as_str() {
                    "" => {}
                    "lz4" | "zstd" => return Err(ScanError::Compressed(header.compression)),
                    _ => return Ok(Err("the chunk's header is damaged".to_owned())),
                }
                let offset = at + RECORD_HEADER as u64 + CHUNK_HEADER;
                return Ok(self.chunk(offset, &data, header.uncompressed_size, header.uncompressed_crc));
            }
            Record::Header(header) => self.contents.library = Some(header.library),
            Record::Metadata(metadata) => self.contents.metadata.push((metadata.name, metadata.metadata)),
            Record::Attachment { header, data, .. } => {
                self.contents.sources.push(Source { name: header.name, bytes: data.into_owned() });
            }
            Record::MessageIndex(_) => {}
            // A chunk whose kind has been damaged must not be passed over in silence.
            other => return Ok(Err(format!("a record of kind {} does not belong here", other.opcode()))),
        }
        Ok(Ok(()))
    }

    /// The header's times are not under the checksum, so they are taken from the messages.
    fn chunk(&mut self, offset: u64, data: &[u8], size: u64, checksum: u32) -> Result<(), String> {
        if size != data.len() as u64 {
            return Err("the chunk's two sizes differ".to_owned());
        }
        if checksum != crc32fast::hash(data) {
            return Err("the chunk's checksum is wrong".to_owned());
        }
        let (mut rest, mut times) = (data, (u64::MAX, 0));
        while let Some((code, body)) = next_record(&mut rest) {
            if matches!(code, op::SCHEMA | op::CHANNEL) {
                self.define(parse(code, body)?);
            } else if let Some(message) = raw_message(code, body) {
                let time = message.time.as_nanos();
                times = (times.0.min(time), times.1.max(time));
            }
        }
        if !rest.is_empty() {
            return Err("the chunk ends within a record".to_owned());
        }
        self.contents.chunks.push(ChunkSpan { offset, length: data.len(), times });
        Ok(())
    }

    fn define(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                self.schemas.insert(header.id, data.into_owned());
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let mut metadata = channel.metadata;
                let type_name = metadata.remove("type").unwrap_or_default();
                let (topic, encoding) = (channel.topic, channel.message_encoding);
                self.contents.channels.insert(channel.id, Channel { topic, encoding, type_name, schema });
            }
            _ => {}
        }
    }

    /// Checks the data as a whole. Chunks bear checksums of their own; this one finds damage between them.
    fn data_end(&self, body: &[u8], at: u64) -> Next {
        let saved = body.first_chunk::<4>().map_or(0, |bytes| u32::from_le_bytes(*bytes));
        if saved != 0 && saved != self.data_checksum.clone().finalize() {
            let what = "the checksum over all data is wrong, though every chunk's is right".to_owned();
            return Next::End(Ending::Damaged { at, what });
        }
        Next::Summary
    }

    fn tail(&self, stream: &mut dyn Read, at: u64) -> io::Result<Ending> {
        let mut tail = Vec::new();
        stream.take(self.length - at).read_to_end(&mut tail)?;
        Ok(if tail == MAGIC {
            Ending::Complete
        } else if MAGIC.starts_with(&tail) {
            Ending::CutOff { at }
        } else {
            Ending::Damaged { at, what: "something else follows the end of the recording".to_owned() }
        })
    }
}
