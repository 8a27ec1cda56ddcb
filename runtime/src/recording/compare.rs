//! Where two recordings part.

use std::fmt;

use super::{ReadError, Reader, messages::Cursor, record::RawMessage};
use crate::time::Time;

/// The first message in which two recordings differ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Log time of the message; of the earlier one, if the times differ.
    pub time: Time,
    /// The message's topic in the first recording; `None` if that has ended.
    pub here: Option<String>,
    /// The message's topic in the second recording; `None` if that has ended.
    pub there: Option<String>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.here, &self.there) {
            (Some(here), Some(there)) if here == there => write!(f, "the messages of `{here}` at {} differ", self.time),
            (Some(here), Some(there)) => write!(f, "at {} the one has `{here}`, the other `{there}`", self.time),
            (Some(here), None) => write!(f, "only the first goes on with `{here}` at {}", self.time),
            (None, Some(there)) => write!(f, "only the second goes on with `{there}` at {}", self.time),
            (None, None) => write!(f, "both end at {}", self.time),
        }
    }
}

impl Reader {
    /// The first message in which two recordings differ, by topic, log time or data; `None` if all messages agree. A file that was
    /// cut off differs from its whole where it ends.
    ///
    /// # Errors
    /// [`ReadError::Io`] if one of the files cannot be read any more.
    pub fn first_difference(&self, other: &Reader) -> Result<Option<Difference>, ReadError> {
        let (mut ours, mut theirs) = (Cursor::new(self), Cursor::new(other));
        loop {
            let (here, there) = (ours.advance()?, theirs.advance()?);
            if here.is_none() && there.is_none() {
                return Ok(None);
            }
            let (topic_here, topic_there) = (here.map(|m| self.topic_of(m)), there.map(|m| other.topic_of(m)));
            // Numbers of channels may differ between recordings, their names may not.
            if topic_here != topic_there || here.map(content) != there.map(content) {
                let time = here.into_iter().chain(there).map(|m| m.time).min().unwrap_or_default();
                let (here, there) = (topic_here.map(str::to_owned), topic_there.map(str::to_owned));
                return Ok(Some(Difference { time, here, there }));
            }
        }
    }

    fn topic_of(&self, message: RawMessage<'_>) -> &str {
        self.contents.channels.get(&message.channel).map_or("", |channel| channel.topic.as_str())
    }
}

fn content<'m>(message: RawMessage<'m>) -> (Time, &'m [u8]) {
    (message.time, message.data)
}
