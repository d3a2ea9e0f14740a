//! What holds for the frames that any bytes are: nothing panics, what is found does not depend on how the bytes are split, and
//! it is in the bytes.

use crate::frame::{Received, Receiver};

/// Reads bytes as frames of WIT-Motion.
pub(crate) fn wit(data: &[u8]) {
    let found = [1, 7, 4096].map(|size| {
        let mut receiver = Receiver::default();
        let mut found = Vec::new();
        for piece in data.chunks(size) {
            receiver.receive(piece);
            found.extend(core::iter::from_fn(|| receiver.next()));
        }
        found
    });
    assert!(found.iter().all(|some| *some == found[0]));
    let mut is_first = true;
    for received in &found[0] {
        let Received::Frame(frame) = received else {
            continue;
        };
        let numbers = frame.numbers.map(i16::to_le_bytes).concat();
        let head = [0x55, frame.kind];
        let is_there = |bytes: &[u8]| bytes[..2] == head && bytes[2..] == numbers;
        assert!(data.windows(10).any(is_there));
        assert!(!core::mem::take(&mut is_first) || !frame.follows);
    }
}
