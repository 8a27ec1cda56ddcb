//! Frames: how packets are told apart in a stream of bytes, in both directions.
//!
//! ```text
//! FA FB | n | kind, body … | checksum (high, low)        n counts everything behind it
//! ```
//!
//! The checksum adds the payload in pairs of bytes, the first of each pair being the high one, modulo 65536; a last byte without a
//! partner is XORed in.

use crate::wire::Counts;

/// The two bytes that a frame begins with.
pub const HEADER: [u8; 2] = [0xFA, 0xFB];
/// The longest payload, kind included.
pub const MOST: usize = 200;
/// Length of the checksum.
const CHECKSUM: usize = 2;
/// The longest frame.
const LONGEST: usize = HEADER.len() + 1 + MOST + CHECKSUM;

/// What a frame carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    /// What kind of packet it is; the first byte of the payload.
    pub kind: u8,
    /// The rest of the payload.
    pub body: &'a [u8],
}

/// The checksum of a payload.
///
/// ```
/// use orienteer_hardware::wire::arcos::frame::checksum;
/// assert_eq!(checksum(&[0x01]), 0x0001);
/// assert_eq!(checksum(&[0x04, 0x3B, 0x01, 0x00]), 0x053B);
/// ```
#[must_use]
pub fn checksum(payload: &[u8]) -> u16 {
    let pairs = payload.chunks_exact(2);
    let odd = pairs.remainder().first().map_or(0, |byte| u16::from(*byte));
    pairs.fold(0u16, |sum, pair| sum.wrapping_add(u16::from_be_bytes([pair[0], pair[1]]))) ^ odd
}

/// Appends a frame. A body that is too long is cut off; no packet here comes near that.
pub fn emit(kind: u8, body: &[u8], into: &mut Vec<u8>) {
    let body = &body[..body.len().min(MOST - 1)];
    into.extend(HEADER);
    // At most 202.
    #[allow(clippy::cast_possible_truncation)]
    into.push((1 + body.len() + CHECKSUM) as u8);
    let payload = into.len();
    into.push(kind);
    into.extend(body);
    let sum = checksum(&into[payload..]);
    into.extend(sum.to_be_bytes());
}

/// Finds the frames in a stream of bytes that comes in pieces.
///
/// What only looked like the beginning of a frame costs no whole frame behind it: its bytes are gone through again from the
/// second on.
#[derive(Debug, Clone)]
pub struct Framer {
    held: [u8; LONGEST],
    len: usize,
    counts: Counts,
}

impl Default for Framer {
    fn default() -> Self {
        Self { held: [0; LONGEST], len: 0, counts: Counts::default() }
    }
}

/// What the bytes held so far are.
enum Beginning {
    /// Not a frame, from the first byte on.
    Noise,
    /// It begins like a frame, and isn't.
    Broken,
    /// It may become a frame.
    Unfinished,
    /// A frame of this many bytes.
    Whole(usize),
}

impl Framer {
    /// Takes in what has come, and shows each frame that is complete.
    pub fn push(&mut self, bytes: &[u8], mut show: impl FnMut(Frame<'_>)) {
        for byte in bytes {
            self.held[self.len] = *byte;
            self.len += 1;
            // A frame that is complete or broken makes room, so that there is always some for the next byte.
            while self.len > 0 {
                match judge(&self.held[..self.len]) {
                    Beginning::Unfinished => break,
                    Beginning::Noise => self.drop_first(1, true),
                    Beginning::Broken => {
                        self.counts.broken += 1;
                        self.drop_first(1, true);
                    }
                    Beginning::Whole(length) => {
                        self.counts.frames += 1;
                        show(Frame { kind: self.held[3], body: &self.held[4..length - CHECKSUM] });
                        self.drop_first(length, false);
                    }
                }
            }
        }
    }

    /// Forgets a frame that has begun: for when nothing has come for longer than a frame takes.
    pub fn reset(&mut self) {
        self.counts.noise += self.len as u64;
        self.len = 0;
    }

    /// What it has seen since it was made.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    fn drop_first(&mut self, count: usize, is_noise: bool) {
        if is_noise {
            self.counts.noise += count as u64;
        }
        self.held.copy_within(count..self.len, 0);
        self.len -= count;
    }
}

fn judge(held: &[u8]) -> Beginning {
    if !held.iter().zip(HEADER).all(|(found, wanted)| *found == wanted) {
        return Beginning::Noise;
    }
    let Some(length) = held.get(2).map(|n| usize::from(*n)) else { return Beginning::Unfinished };
    if !(1 + CHECKSUM..=MOST + CHECKSUM).contains(&length) {
        return Beginning::Broken;
    }
    let whole = HEADER.len() + 1 + length;
    let Some(rest) = held.get(3..whole) else { return Beginning::Unfinished };
    let (payload, sum) = rest.split_at(length - CHECKSUM);
    if checksum(payload).to_be_bytes() == *sum { Beginning::Whole(whole) } else { Beginning::Broken }
}

/// What is made of each frame in some bytes, for the tests of what frames carry.
#[cfg(test)]
pub(super) fn each<T>(bytes: &[u8], mut make: impl FnMut(Frame<'_>) -> T) -> Vec<T> {
    let mut made = Vec::new();
    Framer::default().push(bytes, |frame| made.push(make(frame)));
    made
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    type Packet = (u8, Vec<u8>);

    fn found(framer: &mut Framer, bytes: &[u8]) -> Vec<Packet> {
        let mut packets = Vec::new();
        framer.push(bytes, |frame| packets.push((frame.kind, frame.body.to_vec())));
        packets
    }

    fn framed(packet: &Packet) -> Vec<u8> {
        let mut bytes = Vec::new();
        emit(packet.0, &packet.1, &mut bytes);
        bytes
    }

    /// From the manual's list of commands.
    #[test]
    fn frames_are_those_of_the_manual() {
        assert_eq!(framed(&(0, vec![])), [0xFA, 0xFB, 3, 0, 0, 0]);
        assert_eq!(framed(&(2, vec![])), [0xFA, 0xFB, 3, 2, 0, 2]);
        assert_eq!(framed(&(4, vec![0x3B, 1, 0])), [0xFA, 0xFB, 6, 4, 0x3B, 1, 0, 5, 0x3B]);
    }

    #[test]
    fn lengths_that_cannot_be_are_no_frames() {
        for length in [0, 1, 2, 203, 255] {
            let mut bytes = vec![0xFA, 0xFB, length];
            bytes.extend(framed(&(7, vec![1, 2])));
            let mut framer = Framer::default();
            assert_eq!(found(&mut framer, &bytes), [(7, vec![1, 2])]);
            assert_eq!(framer.counts(), Counts { frames: 1, broken: 1, noise: 3, unknown: 0 });
        }
    }

    fn packet() -> impl Strategy<Value = Packet> {
        // Headers within bodies are the interesting case.
        let byte = prop_oneof![4 => any::<u8>(), 1 => Just(0xFA), 1 => Just(0xFB)];
        (any::<u8>(), proptest::collection::vec(byte, 0..MOST - 1))
    }

    proptest! {
        #[test]
        fn frames_come_back_in_whatever_pieces(packets in proptest::collection::vec(packet(), 0..6), piece in 1usize..300) {
            let stream: Vec<u8> = packets.iter().flat_map(framed).collect();
            let mut framer = Framer::default();
            let back: Vec<Packet> = stream.chunks(piece).flat_map(|bytes| found(&mut framer, bytes)).collect();
            prop_assert_eq!(back, packets);
            prop_assert_eq!((framer.counts().noise, framer.counts().broken), (0, 0));
        }

        /// All packets behind garbage are found, and all bytes are accounted for.
        #[test]
        fn garbage_costs_no_packet(
            garbage in proptest::collection::vec(prop_oneof![3 => any::<u8>(), 2 => Just(0xFA), 2 => Just(0xFB)], 0..400),
            packets in proptest::collection::vec(packet(), 1..5),
        ) {
            let stream: Vec<u8> = garbage.iter().copied().chain(packets.iter().flat_map(framed)).collect();
            // One in 65536 false beginnings has the right checksum by chance, and nobody could tell.
            prop_assume!(!(0..garbage.len()).any(|start| is_frame(&stream[start..])));
            let mut framer = Framer::default();
            let mut back = found(&mut framer, &stream);
            // What still waits behind a false beginning comes out once that is known to be none.
            back.extend(found(&mut framer, &[0; LONGEST]));
            prop_assert_eq!(&back, &packets);
            let carried: u64 = back.iter().map(|(_, body)| body.len() as u64 + 6).sum();
            prop_assert_eq!(carried + framer.counts().noise + framer.len as u64, (stream.len() + LONGEST) as u64);
        }
    }

    /// Written down from the manual once more, byte by byte.
    fn is_frame(bytes: &[u8]) -> bool {
        let [0xFA, 0xFB, length @ 3..=202, rest @ ..] = bytes else { return false };
        let Some((payload, [high, low])) = rest.get(..usize::from(*length)).and_then(|rest| rest.split_last_chunk::<2>()) else {
            return false;
        };
        let mut sum = 0u32;
        let mut i = 0;
        while i + 1 < payload.len() {
            sum = (sum + u32::from(payload[i]) * 256 + u32::from(payload[i + 1])) % 65536;
            i += 2;
        }
        if i < payload.len() {
            sum ^= u32::from(payload[i]);
        }
        sum == u32::from(*high) * 256 + u32::from(*low)
    }
}
