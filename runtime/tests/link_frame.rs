//! Frames: whole ones come back, all others are refused, and none makes the reader ask for much memory.
#![allow(clippy::unwrap_used, missing_docs)]

use allocation_counter::measure;
use orienteer_runtime::link::frame::{FrameError, HEADER, MAX_BODY, Message, VERSION, decode, encode};
use proptest::prelude::*;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Order {
    Stop,
    Start { mission: String, seed: u64, robots: Vec<(String, f64)> },
    Blob(Vec<u8>),
    Numbers(Vec<u64>),
    Words(Vec<String>),
}

impl Message for Order {
    const KIND: u16 = 7;
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Other(u8);

impl Message for Other {
    const KIND: u16 = 8;
}

fn order() -> impl Strategy<Value = Order> {
    prop_oneof![
        Just(Order::Stop),
        (".{0,20}", any::<u64>(), prop::collection::vec((".{0,8}", any::<i32>().prop_map(f64::from)), 0..5))
            .prop_map(|(mission, seed, robots)| Order::Start { mission, seed, robots }),
        prop::collection::vec(any::<u8>(), 0..300).prop_map(Order::Blob),
        prop::collection::vec(any::<u64>(), 0..40).prop_map(Order::Numbers),
        prop::collection::vec(".{0,9}", 0..10).prop_map(Order::Words),
    ]
}

/// A frame around any body at all, with a checksum that is right.
fn forged(body: &[u8], kind: u16) -> Vec<u8> {
    let mut frame = b"ORNT".to_vec();
    frame.extend(VERSION.to_le_bytes());
    frame.extend(kind.to_le_bytes());
    frame.extend(u32::try_from(body.len()).unwrap().to_le_bytes());
    let mut sum = crc32fast::Hasher::new();
    sum.update(&frame);
    sum.update(body);
    frame.extend(sum.finalize().to_le_bytes());
    frame.extend(body);
    frame
}

proptest! {
    #[test]
    fn a_frame_comes_back(order in order()) {
        let frame = encode(&order).unwrap();
        prop_assert_eq!(&frame, &forged(&frame[HEADER..], Order::KIND), "the layout is the documented one");
        prop_assert_eq!(decode::<Order>(&frame).unwrap(), order);
    }

    #[test]
    fn every_truncation_is_refused(order in order()) {
        let frame = encode(&order).unwrap();
        for length in 0..frame.len() {
            prop_assert!(decode::<Order>(&frame[..length]).is_err(), "{} of {}", length, frame.len());
        }
    }

    #[test]
    fn every_extension_is_refused(order in order(), more in prop::collection::vec(any::<u8>(), 1..20)) {
        let mut frame = encode(&order).unwrap();
        frame.extend(more);
        let refused = decode::<Order>(&frame);
        prop_assert!(matches!(refused, Err(FrameError::Length { .. })), "{:?}", refused);
    }

    #[test]
    fn every_flipped_bit_is_refused(order in order()) {
        let mut frame = encode(&order).unwrap();
        for bit in 0..frame.len() * 8 {
            frame[bit / 8] ^= 1 << (bit % 8);
            prop_assert!(decode::<Order>(&frame).is_err(), "bit {}", bit);
            frame[bit / 8] ^= 1 << (bit % 8);
        }
    }

    #[test]
    fn noise_is_refused(noise in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(decode::<Order>(&noise).is_err());
    }

    #[test]
    fn hostile_bodies_ask_for_little(body in hostile_body()) {
        let frame = forged(&body, Order::KIND);
        let mut decoded = Err(FrameError::NotAFrame);
        let asked = measure(|| decoded = decode::<Order>(&frame)).bytes_max;
        prop_assert!(asked <= 2 * MAX_BODY as u64, "{} bytes for {:?}", asked, decoded);
    }
}

/// A variant that holds a sequence, a length of any size in bincode's encoding, and few bytes after it.
fn hostile_body() -> impl Strategy<Value = Vec<u8>> {
    let length = prop_oneof![
        any::<u16>().prop_map(u64::from),
        any::<u32>().prop_map(u64::from),
        any::<u64>(),
        Just(u64::MAX),
        Just(1 << 63),
    ];
    (0u32..6, length, prop::collection::vec(any::<u8>(), 0..40))
        .prop_map(|(variant, length, rest)| [&variant.to_le_bytes()[..], &length.to_le_bytes(), &rest].concat())
}

#[test]
fn what_is_wrong_is_said() {
    let frame = encode(&Order::Stop).unwrap();
    assert_eq!(decode::<Order>(b"short"), Err(FrameError::NotAFrame));
    assert_eq!(decode::<Other>(&frame), Err(FrameError::Kind { found: 7, expected: 8 }));

    let mut newer = frame.clone();
    newer[4..6].copy_from_slice(&(VERSION + 1).to_le_bytes());
    assert_eq!(decode::<Order>(&newer), Err(FrameError::Version { found: VERSION + 1 }));

    let mut endless = frame.clone();
    endless[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(decode::<Order>(&endless), Err(FrameError::Length { said: (1 << 32) - 1 + HEADER as u64, found: frame.len() }));

    let mut damaged = frame.clone();
    damaged[HEADER] ^= 1;
    assert_eq!(decode::<Order>(&damaged), Err(FrameError::Checksum));

    let left_over = forged(&[0; 5], Order::KIND);
    assert!(matches!(decode::<Order>(&left_over), Err(FrameError::Undecodable(_))));
    let no_such_variant = forged(&[9, 0, 0, 0], Order::KIND);
    assert!(matches!(decode::<Order>(&no_such_variant), Err(FrameError::Undecodable(_))));
}

#[test]
fn a_body_has_a_greatest_length() {
    let longest = Order::Blob(vec![7; MAX_BODY - 12]); // Four bytes for the variant, eight for the length.
    let frame = encode(&longest).unwrap();
    assert_eq!(frame.len(), HEADER + MAX_BODY);
    assert_eq!(decode::<Order>(&frame).unwrap(), longest);
    assert!(matches!(encode(&Order::Blob(vec![7; MAX_BODY - 11])), Err(FrameError::Unencodable(_))));
}

#[test]
fn what_can_be_encoded_can_be_decoded_however_long() {
    let small_numbers = Order::Numbers(vec![1; (MAX_BODY - 12) / 8]);
    let empty_words = Order::Words(vec![String::new(); (MAX_BODY - 12) / 8]);
    for order in [small_numbers, empty_words] {
        assert_eq!(decode::<Order>(&encode(&order).unwrap()).unwrap(), order);
    }
}
