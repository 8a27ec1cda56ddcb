//! Frames: what the base sends each 15 ms, once it was asked to with Stream.
//!
//! ```text
//! 19 | n | packet, its data, packet, its data … | checksum        n counts what is between it and the checksum
//! ```
//!
//! The checksum makes the sum of all bytes a multiple of 256. The specification of Create 1 leaves the 19 out of that sum, in words and
//! in its example, that of Create 2 does not, and libcreate checks both as Create 2 has it. So a frame of Create 1 is taken either way.

use std::time::Duration;

use smallvec::SmallVec;

use super::{packet::Id, sensors::Sensors};
use crate::wire::Counts;

/// The byte that a frame begins with.
pub const HEADER: u8 = 19;
/// The time from one frame to the next.
pub const PERIOD: Duration = Duration::from_millis(15);
/// No more bytes than this fit between two frames at 115200 baud.
pub const LONGEST: usize = 172;
/// Header, length and checksum.
const AROUND: usize = 3;

/// Appends a frame. Packets for which there is no room are left out.
pub fn emit(packets: &[Id], sensors: &Sensors, into: &mut Vec<u8>) {
    let start = into.len();
    into.extend([HEADER, 0]);
    for id in packets {
        if into.len() - start + 1 + id.size() + 1 > LONGEST {
            break;
        }
        into.push(*id as u8);
        sensors.emit(*id, into);
    }
    // At most 169.
    into[start + 1] = (into.len() - start - 2).to_le_bytes()[0];
    into.push(sum(&into[start..]).wrapping_neg());
}

fn sum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte))
}

/// Finds the frames with certain packets in a stream of bytes that comes in pieces.
///
/// Since it is known which packets were asked for, it is known of nearly every byte what it must be. What only looked like the
/// beginning of a frame is found out at its second byte or soon after, and costs no whole frame behind it.
#[derive(Debug, Clone)]
pub struct Framer {
    packets: SmallVec<[Id; 16]>,
    /// What a frame is made of; `None` where its data are.
    shape: SmallVec<[Option<u8>; 64]>,
    headless_sum: bool,
    held: SmallVec<[u8; 64]>,
    counts: Counts,
}

/// What the bytes held so far are.
enum Beginning {
    /// Not a frame, from the first byte on.
    Noise,
    /// It begins like a frame, and isn't.
    Broken,
    /// It may become a frame.
    Unfinished,
    Whole,
}

impl Framer {
    /// Of frames with these packets in this order; of those that are too many, the first.
    #[must_use]
    pub fn new(packets: &[Id]) -> Self {
        let mut fits = SmallVec::<[Id; 16]>::new();
        let mut shape = SmallVec::from_slice(&[Some(HEADER), Some(0)]);
        for id in packets {
            if shape.len() + 1 + id.size() + 1 > LONGEST {
                break;
            }
            shape.push(Some(*id as u8));
            shape.extend(std::iter::repeat_n(None, id.size()));
            fits.push(*id);
        }
        shape[1] = Some((shape.len() - 2).to_le_bytes()[0]);
        shape.push(None);
        Self { packets: fits, shape, headless_sum: false, held: SmallVec::new(), counts: Counts::default() }
    }

    /// Takes frames as well of which the sum leaves the header out.
    #[must_use]
    pub fn or_with_headless_sum(mut self) -> Self {
        self.headless_sum = true;
        self
    }

    /// The packets in its frames.
    #[must_use]
    pub fn packets(&self) -> &[Id] {
        &self.packets
    }

    /// Takes in what has come, and shows what the packets of each frame that is complete say, by what was known before. A frame that
    /// says what can't be counts as broken.
    pub fn push(&mut self, bytes: &[u8], sensors: &mut Sensors, mut show: impl FnMut(&Sensors)) {
        for byte in bytes {
            self.held.push(*byte);
            while !self.held.is_empty() {
                match self.judge() {
                    Beginning::Unfinished => break,
                    Beginning::Noise => self.drop_first(),
                    Beginning::Broken => {
                        self.counts.broken += 1;
                        self.drop_first();
                    }
                    Beginning::Whole if self.read(sensors) => {
                        self.counts.frames += 1;
                        self.held.clear();
                        show(sensors);
                    }
                    Beginning::Whole => {
                        self.counts.broken += 1;
                        self.drop_first();
                    }
                }
            }
        }
    }

    /// Forgets a frame that has begun: for when the line is a new one.
    pub fn reset(&mut self) {
        self.counts.noise += self.held.len() as u64;
        self.held.clear();
    }

    /// What it has seen since it was made.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    fn judge(&self) -> Beginning {
        let fits = |(found, wanted): (&u8, &Option<u8>)| wanted.is_none_or(|wanted| wanted == *found);
        match self.held.iter().zip(&self.shape).position(|pair| !fits(pair)) {
            Some(0) => return Beginning::Noise,
            Some(_) => return Beginning::Broken,
            None if self.held.len() < self.shape.len() => return Beginning::Unfinished,
            None => {}
        }
        match sum(&self.held) {
            0 => Beginning::Whole,
            HEADER if self.headless_sum => Beginning::Whole,
            _ => Beginning::Broken,
        }
    }

    /// Reads the packets of a whole frame; `false` if they can't be.
    fn read(&self, sensors: &mut Sensors) -> bool {
        let data: SmallVec<[u8; 64]> =
            self.held.iter().zip(&self.shape).filter(|(_, wanted)| wanted.is_none()).map(|(byte, _)| *byte).collect();
        // The last of them is the checksum.
        data.split_last().is_some_and(|(_, data)| sensors.read(&self.packets, data).is_ok())
    }

    fn drop_first(&mut self) {
        self.counts.noise += 1;
        self.held.remove(0);
    }
}

/// How long the frames with these packets are, bytes.
#[must_use]
pub fn length(packets: &[Id]) -> usize {
    AROUND + packets.iter().map(|id| 1 + id.size()).sum::<usize>()
}

#[cfg(test)]
mod tests;
