//! How encoded messages travel from a robot's track to the recorder: a plain byte buffer, reused for ever.
//!
//! Each entry is its kind, its length as `u32`, and its body. A channel is declared in the stream right before its first
//! message, so that the file's channel numbers follow from the order of the stream alone.

use super::payload::ChannelType;
use crate::time::Time;

const CHANNEL: u8 = 0;
const MESSAGE: u8 = 1;
const HEADER: usize = 5;

/// Messages of one robot, encoded, on their way to the recorder.
#[derive(Debug, Clone, Default)]
pub struct Entries {
    robot: usize,
    /// When the newest of them was made.
    pub(super) time: Time,
    bytes: Vec<u8>,
}

/// One entry.
#[derive(Debug, PartialEq)]
pub(super) enum Entry<'a> {
    /// The robot's next channel. Channels count from 0 in the order of their declarations.
    Channel(ChannelEntry<'a>),
    /// A message on a channel declared before.
    Message(MessageEntry<'a>),
}

/// Declares a channel.
#[derive(Debug, PartialEq)]
pub(super) struct ChannelEntry<'a> {
    pub(super) channel: u16,
    pub(super) topic: &'a str,
    pub(super) message_encoding: &'a str,
    pub(super) schema_name: &'a str,
    pub(super) schema_encoding: &'a str,
    pub(super) schema: &'a [u8],
    /// Versioned name of the payload's type; empty for Foxglove's.
    pub(super) type_name: &'a str,
}

/// A message.
#[derive(Debug, PartialEq)]
pub(super) struct MessageEntry<'a> {
    pub(super) channel: u16,
    pub(super) sequence: u32,
    pub(super) log_time: u64,
    pub(super) data: &'a [u8],
}

impl Entries {
    /// No entries yet of the robot with this number.
    pub(super) fn of(robot: usize) -> Self {
        Self { robot, time: Time::START, bytes: Vec::with_capacity(8 << 10) }
    }

    /// Number of the robot that they are of.
    #[must_use]
    pub fn robot(&self) -> usize {
        self.robot
    }

    /// True if there is nothing to hand over.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Forgets all entries and keeps the memory.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }

    /// Makes it an empty buffer of the robot with this number.
    pub(super) fn reset(&mut self, robot: usize, time: Time) {
        self.robot = robot;
        self.time = time;
        self.bytes.clear();
    }

    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Declares the robot's next channel.
    pub(super) fn declare(&mut self, channel: u16, topic: &str, kind: &ChannelType) {
        let start = self.open(CHANNEL);
        self.bytes.extend_from_slice(&channel.to_le_bytes());
        let texts = [topic, kind.message_encoding, &kind.schema_name, kind.schema_encoding, &kind.type_name];
        for part in texts.iter().map(|text| text.as_bytes()).chain([&kind.schema[..]]) {
            self.bytes.extend_from_slice(&(part.len() as u32).to_le_bytes());
            self.bytes.extend_from_slice(part);
        }
        self.close(start);
    }

    /// Adds a message whose data `encode` appends; nothing is added if that fails.
    pub(super) fn message<E>(
        &mut self,
        channel: u16,
        sequence: u32,
        log_time: u64,
        encode: impl FnOnce(&mut Vec<u8>) -> Result<(), E>,
    ) -> Result<(), E> {
        let start = self.open(MESSAGE);
        self.bytes.extend_from_slice(&channel.to_le_bytes());
        self.bytes.extend_from_slice(&sequence.to_le_bytes());
        self.bytes.extend_from_slice(&log_time.to_le_bytes());
        let result = encode(&mut self.bytes);
        match &result {
            Ok(()) => self.close(start),
            Err(_) => self.bytes.truncate(start),
        }
        result
    }

    fn open(&mut self, kind: u8) -> usize {
        let start = self.bytes.len();
        self.bytes.extend_from_slice(&[kind, 0, 0, 0, 0]);
        start
    }

    fn close(&mut self, start: usize) {
        let length = (self.bytes.len() - start - HEADER) as u32;
        self.bytes[start + 1..start + HEADER].copy_from_slice(&length.to_le_bytes());
    }
}

/// Takes entries off the front of a buffer.
pub(super) struct EntryReader<'a>(pub(super) &'a [u8]);

impl<'a> Iterator for EntryReader<'a> {
    type Item = Entry<'a>;

    fn next(&mut self) -> Option<Entry<'a>> {
        let [kind] = take(&mut self.0)?;
        let mut body = part(&mut self.0)?;
        if kind == CHANNEL {
            let channel = u16::from_le_bytes(take(&mut body)?);
            let mut text = || std::str::from_utf8(part(&mut body)?).ok();
            let (topic, message_encoding, schema_name) = (text()?, text()?, text()?);
            let (schema_encoding, type_name) = (text()?, text()?);
            let schema = part(&mut body)?;
            return Some(Entry::Channel(ChannelEntry {
                channel,
                topic,
                message_encoding,
                schema_name,
                schema_encoding,
                schema,
                type_name,
            }));
        }
        Some(Entry::Message(MessageEntry {
            channel: u16::from_le_bytes(take(&mut body)?),
            sequence: u32::from_le_bytes(take(&mut body)?),
            log_time: u64::from_le_bytes(take(&mut body)?),
            data: body,
        }))
    }
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (head, rest) = bytes.split_first_chunk::<N>()?;
    *bytes = rest;
    Some(*head)
}

fn part<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = u32::from_le_bytes(take(bytes)?) as usize;
    let (head, rest) = bytes.split_at_checked(length)?;
    *bytes = rest;
    Some(head)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn entries_come_out_as_they_went_in_and_failures_leave_no_trace() {
        let channel = ChannelType {
            message_encoding: "ros1",
            schema_name: "orienteer/Truth".into(),
            schema_encoding: "ros1msg",
            schema: b"uint64 stamp\n".to_vec(),
            type_name: "orienteer::Truth.v1".into(),
        };
        let mut entries = Entries::of(3);
        entries.declare(0, "/ann/truth", &channel);
        let mut message = |sequence, time, data: &[u8], result: Result<(), ()>| {
            entries.message(0, sequence, time, |bytes| {
                bytes.extend_from_slice(data);
                result
            })
        };
        message(9, 77, b"abc", Ok(())).unwrap();
        message(10, 78, b"half", Err(())).unwrap_err();
        message(10, 79, b"", Ok(())).unwrap();
        let read: Vec<_> = EntryReader(entries.bytes()).collect();
        assert_eq!(
            read,
            [
                Entry::Channel(ChannelEntry {
                    channel: 0,
                    topic: "/ann/truth",
                    message_encoding: "ros1",
                    schema_name: "orienteer/Truth",
                    schema_encoding: "ros1msg",
                    schema: b"uint64 stamp\n",
                    type_name: "orienteer::Truth.v1",
                }),
                Entry::Message(MessageEntry { channel: 0, sequence: 9, log_time: 77, data: b"abc" }),
                Entry::Message(MessageEntry { channel: 0, sequence: 10, log_time: 79, data: b"" }),
            ]
        );
        for cut in 0..entries.bytes().len() {
            assert!(EntryReader(&entries.bytes()[..cut]).count() < 3);
        }
    }
}
