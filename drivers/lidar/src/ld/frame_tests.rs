//! Frames: what is read of the manual's example, and of noise. They are apart from `frame`, which tests of other crates
//! include with the emulator.

use proptest::prelude::*;

use super::frame::*;

/// The example of the manual.
const EXAMPLE: [u8; SIZE] = [
    0x54, 0x2c, 0x68, 0x08, 0xab, 0x7e, 0xe0, 0x00, 0xe4, 0xdc, 0x00, 0xe2, 0xd9, 0x00, 0xe5, 0xd5, 0x00,
    0xe3, 0xd3, 0x00, 0xe4, 0xd0, 0x00, 0xe9, 0xcd, 0x00, 0xe4, 0xca, 0x00, 0xe2, 0xc7, 0x00, 0xe9, 0xc5,
    0x00, 0xe5, 0xc2, 0x00, 0xe5, 0xc0, 0x00, 0xe5, 0xbe, 0x82, 0x3a, 0x1a, 0x50,
];

fn receive_all(pieces: &[&[u8]]) -> Vec<Received> {
    let mut receiver = Receiver::default();
    let mut all = Vec::new();
    for piece in pieces {
        receiver.receive(piece);
        all.extend(core::iter::from_fn(|| receiver.next()));
    }
    all
}

fn frames(bytes: &[u8]) -> usize {
    let all = receive_all(&[bytes]);
    let is_frame = |received: &&Received| matches!(received, Received::Frame(_));
    all.iter().filter(is_frame).count()
}

#[test]
fn the_example_of_the_manual_is_read() {
    let [Received::Frame(frame)] = receive_all(&[&EXAMPLE])[..] else {
        panic!("a frame is expected")
    };
    assert_eq!((frame.speed, frame.start, frame.stamp), (2152, 324.27, 6714));
    assert!((frame.span - 10.43).abs() < 1e-9);
    assert_eq!((frame.points[0], frame.points[11]), ((224, 228), (192, 229)));
}

#[test]
fn a_false_head_hides_no_frame_after_it() {
    for false_head in [&[0x54][..], &[0x54, 0x2c], &[0x54, 0x54, 0x2c, 1, 2]] {
        assert_eq!(frames(&[false_head, &EXAMPLE, &EXAMPLE].concat()), 2);
    }
}

#[test]
fn every_wrong_byte_is_noticed() {
    for index in 0..SIZE {
        for change in 1..=u8::MAX {
            let mut wrong = EXAMPLE;
            wrong[index] ^= change;
            assert_eq!(frames(&wrong), 0, "byte {index} changed by {change}");
        }
    }
}

#[test]
fn impossible_numbers_are_rejected_despite_their_checksum() {
    for (at, number) in [(4, 36_001_u16), (42, 36_001), (44, 30_001), (42, 32_427 + 2401)] {
        let mut wrong = EXAMPLE;
        wrong[at..at + 2].copy_from_slice(&number.to_le_bytes());
        wrong[SIZE - 1] = checksum(&wrong[..SIZE - 1]);
        assert_eq!(frames(&wrong), 0, "{number} at {at}");
    }
}

proptest! {
    #[test]
    fn frames_are_found_after_any_split(cut in 0..SIZE * 2, noise in prop::collection::vec(any::<u8>(), 0..60)) {
        let bytes = [&EXAMPLE[..], &noise, &EXAMPLE].concat();
        let (head, tail) = bytes.split_at(cut.min(bytes.len()));
        prop_assert_eq!(receive_all(&[head, tail]), receive_all(&[&bytes]));
    }
}
