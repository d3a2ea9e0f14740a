//! What holds for the measurements that any bytes are: nothing panics, what is found does not depend on how the bytes are
//! split, and turns have their size.

use crate::ld::frame;
use crate::rplidar::message::Receiver;
use crate::rplidar::samples::{Decoder, Format, Found};
use crate::turn::{Point, Turns};

/// Sizes of the pieces that bytes arrive in.
const PIECES: [usize; 3] = [1, 7, 4096];

/// Reads bytes as frames of LDRobot.
pub(crate) fn ld(data: &[u8]) {
    let found = PIECES.map(|size| {
        let mut receiver = frame::Receiver::default();
        let mut found = Vec::new();
        for piece in data.chunks(size) {
            receiver.receive(piece);
            found.extend(core::iter::from_fn(|| receiver.next()));
        }
        found
    });
    assert!(found.iter().all(|some| *some == found[0]));
    let mut turns = Turns::new(450, false);
    for (number, received) in found[0].iter().enumerate() {
        let frame::Received::Frame(frame) = received else {
            continue;
        };
        assert!((0.0..=360.0).contains(&frame.start) && (0.0..=24.0).contains(&frame.span));
        add(&mut turns, 450, frame.start, number);
    }
}

/// Reads bytes as replies of SLAMTEC, and as measurements of each format.
pub(crate) fn rplidar(data: &[u8]) {
    let replies = PIECES.map(|size| {
        let mut receiver = Receiver::default();
        let mut found = Vec::new();
        for piece in data.chunks(size) {
            receiver.receive(piece);
            found.extend(core::iter::from_fn(|| receiver.next()));
        }
        found
    });
    assert!(replies.iter().all(|some| *some == replies[0]));
    for format in [Format::Nodes, Format::Express, Format::Dense] {
        let found = PIECES.map(|size| {
            let mut decoder = Decoder::new(format);
            let mut found = Vec::new();
            for piece in data.chunks(size) {
                decoder.receive(piece);
                found.extend(core::iter::from_fn(|| decoder.next()));
            }
            found
        });
        assert!(found.iter().all(|some| *some == found[0]));
        let mut turns = Turns::new(360, true);
        let (mut used, mut number) = (0, 0);
        for found in &found[0] {
            let Found::Samples(size, samples) = found else {
                continue;
            };
            used += size;
            for sample in samples {
                assert!((0.0..=360.0).contains(&sample.angle) && sample.distance >= 0.0 && sample.lag >= 0.0);
                number += 1;
                add(&mut turns, 360, sample.angle, number);
            }
        }
        assert!(used <= data.len());
    }
}

/// Adds a point, a millisecond after the one before. A turn that it ends has its size and a duration.
fn add(turns: &mut Turns, beams: usize, angle: f64, number: usize) {
    let point = Point {
        angle,
        range: 1.0,
        intensity: 0.0,
        time: number as f64 / 1000.0,
    };
    if let Some(turn) = turns.add(&point) {
        assert_eq!((turn.ranges.len(), turn.intensities.len()), (beams, beams));
        assert!(turn.duration > 0.0, "{}", turn.duration);
    }
}
