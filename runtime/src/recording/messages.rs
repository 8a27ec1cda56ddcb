//! Messages of a recording, decoded one by one.

use std::ops::Range;

use foxglove::{
    Decode,
    messages::{Grid, Log, log::Level},
};

use super::{
    GridImage, ReadError, Reader,
    definition::essence,
    payload::{JSON, PACKED, definition, type_name},
    record::{RawMessage, next_record, raw_message},
    unpacked::unpack,
};
use crate::{time::Time, topics::Payload};

/// Decodes a message's data; the error says what is wrong with it.
type DecodeFn<T> = fn(&[u8]) -> Result<T, String>;

/// The messages of one topic, with their log times, in the order of recording. Ends after the first error.
#[derive(Debug)]
pub struct Messages<'r, T> {
    cursor: Cursor<'r>,
    topic: String,
    channels: Vec<u16>,
    decode: DecodeFn<T>,
    until: Time,
}

/// Moves through all messages of a recording.
#[derive(Debug)]
pub(super) struct Cursor<'r> {
    reader: &'r Reader,
    /// The next chunk to load, and the one before which to end.
    chunks: Range<usize>,
    records: Vec<u8>,
    /// How much of `records` has been read.
    position: usize,
}

/// A line of a node's log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogLine {
    /// How grave it is. What was recorded as a trace comes back as a debug line.
    pub level: tracing::Level,
    /// The node that wrote it.
    pub node: String,
    /// What it wrote.
    pub text: String,
}

impl Reader {
    /// All samples of a robot's topic.
    ///
    /// # Errors
    /// [`ReadError::Robot`] for an unknown robot, [`ReadError::Payload`] if the recorded samples have another layout than
    /// `P`; from the iterator [`ReadError::Io`] and [`ReadError::Message`].
    pub fn messages<P: Payload>(&self, robot: &str) -> Result<Messages<'_, P>, ReadError> {
        let topic = format!("/{robot}/{}", P::TOPIC);
        let mut messages = self.topic(robot, topic, |bytes| unpack(bytes).map_err(|error| error.0))?;
        for channel in &messages.channels {
            match self.decoder::<P>(*channel) {
                Ok(decode) => messages.decode = decode,
                Err((found, known)) => {
                    let (place, topic) = (self.place.clone(), messages.topic);
                    return Err(ReadError::Payload { place, topic, found, known });
                }
            }
        }
        Ok(messages)
    }

    /// All grids that a robot has recorded under a name.
    ///
    /// # Errors
    /// [`ReadError::Robot`] for an unknown robot; from the iterator [`ReadError::Io`] and [`ReadError::Message`].
    pub fn grids(&self, robot: &str, name: &str) -> Result<Messages<'_, GridImage>, ReadError> {
        self.topic(robot, format!("/{robot}/{name}"), |bytes| {
            Grid::decode(bytes).map_err(|error| error.to_string()).and_then(|message| GridImage::from_message(&message))
        })
    }

    /// The log of a robot's nodes.
    ///
    /// # Errors
    /// [`ReadError::Robot`] for an unknown robot; from the iterator [`ReadError::Io`] and [`ReadError::Message`].
    pub fn log_lines(&self, robot: &str) -> Result<Messages<'_, LogLine>, ReadError> {
        self.topic(robot, format!("/{robot}/log"), |bytes| {
            let message = Log::decode(bytes).map_err(|error| error.to_string())?;
            let level = match message.level() {
                Level::Error | Level::Fatal => tracing::Level::ERROR,
                Level::Warning => tracing::Level::WARN,
                Level::Info => tracing::Level::INFO,
                Level::Debug | Level::Unknown => tracing::Level::DEBUG,
            };
            Ok(LogLine { level, node: message.name, text: message.message })
        })
    }

    fn topic<T>(&self, robot: &str, topic: String, decode: fn(&[u8]) -> Result<T, String>) -> Result<Messages<'_, T>, ReadError> {
        let channels: Vec<_> =
            self.contents.channels.iter().filter(|(_, channel)| channel.topic == topic).map(|(id, _)| *id).collect();
        if channels.is_empty() {
            self.known_robot(robot)?;
        }
        Ok(Messages { cursor: Cursor::new(self), topic, channels, decode, until: Time::FAR })
    }

    /// How to decode a channel's samples as `P`; if they are something else, what they are and what they should be.
    fn decoder<P: Payload>(&self, channel: u16) -> Result<DecodeFn<P>, (String, String)> {
        let Some(channel) = self.contents.channels.get(&channel) else { return Err((String::new(), type_name::<P>())) };
        let known = type_name::<P>();
        if channel.type_name != known {
            let found =
                if channel.type_name.is_empty() { "samples of no named type".to_owned() } else { channel.type_name.clone() };
            return Err((found, known));
        }
        match channel.encoding.as_str() {
            PACKED => {
                let recorded = String::from_utf8_lossy(&channel.schema);
                if definition::<P>().is_none_or(|definition| !essence(&recorded).eq(essence(&definition.text))) {
                    return Err((format!("{known} with other fields"), format!("{known} with its own")));
                }
                Ok(|bytes| unpack(bytes).map_err(|error| error.0))
            }
            JSON => Ok(|bytes| serde_json::from_slice(bytes).map_err(|error| error.to_string())),
            other => Err((format!("{known} encoded as `{other}`"), format!("`{PACKED}` and `{JSON}`"))),
        }
    }
}

impl<T> Messages<'_, T> {
    /// Only the messages of one chunk that are no later than `until`.
    pub(super) fn only(mut self, chunk: usize, until: Time) -> Self {
        self.cursor.chunks = chunk..chunk + 1;
        self.until = until;
        self
    }

    fn decoded(&mut self) -> Result<Option<(Time, T)>, ReadError> {
        let place = &self.cursor.reader.place;
        while !self.channels.is_empty() {
            let Some(RawMessage { channel, time, data }) = self.cursor.advance()? else { break };
            if self.channels.contains(&channel) && time <= self.until {
                let message = |what| ReadError::Message { place: place.clone(), topic: self.topic.clone(), time, what };
                return (self.decode)(data).map(|value| Some((time, value))).map_err(message);
            }
        }
        Ok(None)
    }
}

impl<'r> Cursor<'r> {
    /// Before the first message.
    pub(super) fn new(reader: &'r Reader) -> Self {
        Self { reader, chunks: 0..reader.contents.chunks.len(), records: Vec::new(), position: 0 }
    }

    /// Moves to the next message.
    pub(super) fn advance(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        loop {
            let mut rest = &self.records[self.position..];
            if let Some((code, body)) = next_record(&mut rest) {
                let end = self.records.len() - rest.len();
                self.position = end;
                // Made again to return it: the borrow checker does not let a conditional return end a loan.
                if raw_message(code, body).is_some() {
                    return Ok(raw_message(code, &self.records[end - body.len()..end]));
                }
            } else {
                let Some(chunk) = self.chunks.next() else { return Ok(None) };
                self.reader.load(self.reader.contents.chunks[chunk], &mut self.records)?;
                self.position = 0;
            }
        }
    }
}

impl<T> Iterator for Messages<'_, T> {
    type Item = Result<(Time, T), ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let item = self.decoded().transpose();
        if let Some(Err(_)) = item {
            self.channels.clear();
        }
        item
    }
}
