use proptest::{collection::vec, prelude::*};

use super::*;
use crate::wire::oi::sensors::Mode;

const USUAL: [Id; 4] = [Id::BumpsAndDrops, Id::Mode, Id::LeftEncoder, Id::RightEncoder];

fn found(framer: &mut Framer, bytes: &[u8]) -> Vec<Sensors> {
    let (mut sensors, mut found) = (Sensors::default(), Vec::new());
    framer.push(bytes, &mut sensors, |sensors| found.push(*sensors));
    found
}

fn framed(packets: &[Id], sensors: &Sensors) -> Vec<u8> {
    let mut bytes = Vec::new();
    emit(packets, sensors, &mut bytes);
    bytes
}

/// The example of both specifications: 549 where they add decimal 25, which is 537.
fn example() -> Sensors {
    Sensors { cliff_signals: [0, 537, 0, 0], ..Sensors::default() }
}

#[test]
fn frames_are_those_of_the_specifications() {
    let ids = [Id::CliffFrontLeftSignal, Id::VirtualWall];
    let frame = framed(&ids, &example());
    assert_eq!(frame, [19, 5, 29, 2, 25, 13, 0, 163]);
    let of_create_1 = [19, 5, 29, 2, 25, 13, 0, 182];
    assert_eq!(found(&mut Framer::new(&ids), &frame), [example()]);
    assert_eq!(found(&mut Framer::new(&ids), &of_create_1), []);
    let mut either = Framer::new(&ids).or_with_headless_sum();
    assert_eq!(found(&mut either, &[frame, of_create_1.to_vec()].concat()), [example(); 2]);
    assert_eq!(either.counts(), Counts { frames: 2, broken: 0, noise: 0, unknown: 0 });
}

#[test]
fn damaged_frames_and_those_of_another_stream_are_broken() {
    let good = framed(&USUAL, &Sensors { mode: Mode::Safe, left_encoder: 70, ..Sensors::default() });
    for place in 1..good.len() {
        let mut bad = good.clone();
        bad[place] ^= 4;
        bad.extend(&good);
        let mut framer = Framer::new(&USUAL);
        assert_eq!(found(&mut framer, &bad).len(), 1, "{place}");
        let Counts { frames, broken, noise, .. } = framer.counts();
        assert_eq!((frames, broken, noise), (1, 1, good.len() as u64), "{place}");
    }
    let mut framer = Framer::new(&USUAL);
    assert_eq!(found(&mut framer, &framed(&USUAL[1..], &Sensors::default())), []);
    assert_eq!(framer.counts().broken, 1);
}

#[test]
fn a_mode_that_cannot_be_is_no_frame() {
    let mut bad = framed(&[Id::Mode], &Sensors::default());
    let last = bad.len() - 1;
    (bad[last - 1], bad[last]) = (9, bad[last].wrapping_sub(9));
    let mut framer = Framer::new(&[Id::Mode]);
    assert_eq!(found(&mut framer, &bad), []);
    assert_eq!(framer.counts(), Counts { frames: 0, broken: 1, noise: bad.len() as u64, unknown: 0 });
}

#[test]
fn what_does_not_fit_into_15_ms_is_left_out() {
    let every: Vec<Id> = Id::ALL.iter().chain(&Id::ALL).copied().collect();
    let frame = framed(&every, &Sensors::default());
    assert!((LONGEST - 2..=LONGEST).contains(&frame.len()), "{}", frame.len());
    let mut framer = Framer::new(&every);
    assert_eq!((found(&mut framer, &frame).len(), length(framer.packets())), (1, frame.len()));
}

prop_compose! {
    fn sensors()(bumps_and_drops in 0u8..32, left_encoder: u16, right_encoder: u16) -> Sensors {
        Sensors { bumps_and_drops, mode: Mode::Full, left_encoder, right_encoder, ..Sensors::default() }
    }
}

proptest! {
    #[test]
    fn frames_come_back_in_whatever_pieces(sent in vec(sensors(), 0..6), piece in 1usize..60) {
        let stream: Vec<u8> = sent.iter().flat_map(|sensors| framed(&USUAL, sensors)).collect();
        let mut framer = Framer::new(&USUAL);
        let back: Vec<Sensors> = stream.chunks(piece).flat_map(|bytes| found(&mut framer, bytes)).collect();
        prop_assert_eq!(framer.counts(), Counts { frames: sent.len() as u64, broken: 0, noise: 0, unknown: 0 });
        prop_assert_eq!(back, sent);
    }

    /// All frames behind garbage are found, the first of them with its own last byte or at most one frame later, and all bytes are
    /// accounted for.
    #[test]
    fn garbage_costs_no_frame(
        garbage in vec(prop_oneof![2 => any::<u8>(), 2 => Just(HEADER), 1 => Just(11), 1 => Just(7)], 0..200),
        sent in vec(sensors(), 2..5),
    ) {
        let frame = length(&USUAL);
        let stream: Vec<u8> = garbage.iter().copied().chain(sent.iter().flat_map(|sensors| framed(&USUAL, sensors))).collect();
        // One in 256 false beginnings with the right packets has the right checksum by chance, and nobody could tell.
        prop_assume!(!(0..garbage.len()).any(|start| is_frame(&stream[start..])));
        let mut framer = Framer::new(&USUAL);
        let mut back = found(&mut framer, &stream[..garbage.len() + 2 * frame]);
        prop_assert!(!back.is_empty(), "nothing within a frame");
        back.extend(found(&mut framer, &stream[garbage.len() + 2 * frame..]));
        back.extend(found(&mut framer, &vec![0; frame]));
        prop_assert_eq!(&back, &sent);
        let carried = (back.len() * frame) as u64;
        prop_assert_eq!(carried + framer.counts().noise + framer.held.len() as u64, (stream.len() + frame) as u64);
    }

    #[test]
    fn noise_is_survived(noise in vec(any::<u8>(), 0..500)) {
        let mut framer = Framer::new(&USUAL);
        let frames = found(&mut framer, &noise).len() as u64;
        prop_assert_eq!(framer.counts().frames, frames);
    }
}

/// Written down from the specification once more, byte by byte.
fn is_frame(bytes: &[u8]) -> bool {
    let [19, 10, 7, _, 35, 0..=3, 43, _, _, 44, _, _, _, ..] = bytes else { return false };
    bytes[..13].iter().map(|byte| u32::from(*byte)).sum::<u32>() % 256 == 0
}
