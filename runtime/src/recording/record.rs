//! Single records of an MCAP stream.
//!
//! The format's parser is lenient: it passes over bytes that follow what a record must hold. A damaged length could so
//! swallow the records after it. Here a record must be exactly as long as its content.

use mcap::records::{Record, op};

use crate::time::Time;

/// Opcode and length before each record.
pub(super) const RECORD_HEADER: usize = 1 + 8;
/// What a chunk record holds before its data, if it is not compressed.
pub(super) const CHUNK_HEADER: u64 = 8 + 8 + 8 + 4 + 4 + 8;
/// Channel, sequence number, log time and publish time before a message's data.
const MESSAGE_HEADER: usize = 2 + 4 + 8 + 8;

/// A message, not yet decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RawMessage<'c> {
    pub(super) channel: u16,
    pub(super) time: Time,
    pub(super) data: &'c [u8],
}

/// Takes a record, its opcode and body, off the front of a chunk's bytes.
pub(super) fn next_record<'b>(bytes: &mut &'b [u8]) -> Option<(u8, &'b [u8])> {
    let ([code, length @ ..], rest) = bytes.split_first_chunk::<RECORD_HEADER>()?;
    let (body, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    *bytes = rest;
    Some((*code, body))
}

/// The message that a record is, if it is one.
pub(super) fn raw_message(code: u8, body: &[u8]) -> Option<RawMessage<'_>> {
    let (header, data) = body.split_first_chunk::<MESSAGE_HEADER>().filter(|_| code == op::MESSAGE)?;
    let [c0, c1, _, _, _, _, t0, t1, t2, t3, t4, t5, t6, t7, ..] = *header;
    let time = Time::from_nanos(u64::from_le_bytes([t0, t1, t2, t3, t4, t5, t6, t7]));
    Some(RawMessage { channel: u16::from_le_bytes([c0, c1]), time, data })
}

/// Parses any record but the footer. The error says what is wrong with it.
pub(super) fn parse(code: u8, body: &[u8]) -> Result<Record<'_>, String> {
    if expected_length(code, body) != Some(body.len() as u64) {
        return Err("a record is not as long as its content".to_owned());
    }
    mcap::parse_record(code, body).map_err(|error| error.to_string())
}

/// How long the body of such a record must be by the lengths that it names; `None` if it is too short to name them.
fn expected_length(code: u8, body: &[u8]) -> Option<u64> {
    let short = |at: u64| Some(u64::from(u32::from_le_bytes(*body.get(usize::try_from(at).ok()?..)?.first_chunk()?)));
    let long = |at: u64| Some(u64::from_le_bytes(*body.get(usize::try_from(at).ok()?..)?.first_chunk()?));
    // The end of a text, list or map that begins with its length at `at`.
    let past = |at: u64| short(at)?.checked_add(at + 4);
    match code {
        op::HEADER | op::METADATA => past(past(0)?),
        op::SCHEMA => past(past(past(2)?)?),
        op::CHANNEL => past(past(past(4)?)?),
        op::CHUNK => {
            let size = past(CHUNK_HEADER - 4 - 8)?;
            long(size)?.checked_add(size + 8)
        }
        op::MESSAGE_INDEX => past(2),
        op::ATTACHMENT => {
            let size = past(past(8 + 8)?)?;
            long(size)?.checked_add(size + 8 + 4)
        }
        _ => Some(body.len() as u64),
    }
}
