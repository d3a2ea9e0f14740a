//! Streams of the emulator, and streams with errors.

use proptest::prelude::*;

use super::*;
use crate::rplidar::emulator::EmulatedRplidar;

const FORMATS: [Format; 3] = [Format::Nodes, Format::Express, Format::Dense];

/// The distance is 1000 mm and ten for each degree.
fn slope(angle: f64) -> u16 {
    1000 + (angle * 10.0) as u16
}

/// Two turns of measurements.
fn stream(format: Format) -> Vec<u8> {
    let mut lidar = EmulatedRplidar {
        scanning: Some(format),
        ..EmulatedRplidar::a1(slope)
    };
    lidar.advance(0.2)
}

fn decode(format: Format, pieces: &[&[u8]]) -> Vec<Found> {
    let mut decoder = Decoder::new(format);
    let mut all = Vec::new();
    for piece in pieces {
        decoder.receive(piece);
        all.extend(core::iter::from_fn(|| decoder.next()));
    }
    all
}

fn samples(found: &[Found]) -> Vec<Sample> {
    let samples = found.iter().flat_map(|found| match found {
        Found::Samples(_, samples) => samples.as_slice(),
        Found::Corrupt => &[],
    });
    samples.copied().collect()
}

/// Whether a sample is where the emulator measured it; a step lies between 359 and 0 degrees.
fn is_true(sample: &Sample) -> bool {
    let error = f64::from(sample.distance) - (1000.0 + sample.angle * 10.0);
    (0.0..360.0).contains(&sample.angle) && (error.abs() < 3.0 || error.abs() > 3590.0)
}

#[test]
fn the_example_of_a_node_is_read() {
    // Quality 47, 90 degrees, 1000.25 mm.
    let node = [47 << 2 | 2, 0x01, 0x2d, 0xa1, 0x0f];
    let found = decode(Format::Nodes, &[&node.repeat(BELIEVED)]);
    let expected = Sample {
        angle: 90.0,
        distance: 1000.25,
        quality: 47,
        lag: 0.0,
    };
    assert_eq!(found, [Found::Samples(5, vec![expected])]);
}

#[test]
fn every_measurement_is_where_it_was_made() {
    for (format, count) in FORMATS.into_iter().zip([800 - 3, 800 - 32, 800 - 40]) {
        let all = samples(&decode(format, &[&stream(format)]));
        assert_eq!(all.len(), count, "{format:?}");
        for sample in &all {
            assert!(is_true(sample), "{format:?}: {sample:?}");
        }
    }
}

#[test]
fn a_sample_lags_as_far_as_the_head_has_turned() {
    let all = samples(&decode(Format::Dense, &[&stream(Format::Dense)]));
    // 40 samples of 0.9 degrees, complete after the next 40.
    assert!((all[0].lag - 72.0).abs() < 0.1 && (all[39].lag - 36.9).abs() < 0.1);
}

#[test]
fn a_capsule_that_begins_a_scan_or_is_far_away_completes_none() {
    for change in [
        |capsule: &mut [u8]| capsule[3] ^= 0x80,
        |capsule: &mut [u8]| capsule[3] ^= 0x20,
    ] {
        let mut bytes = stream(Format::Express)[..3 * CAPSULE].to_vec();
        let capsule = &mut bytes[CAPSULE..2 * CAPSULE];
        change(capsule);
        let sum = capsule[2..].iter().fold(0, |sum, byte| sum ^ byte);
        (capsule[0], capsule[1]) = (0xa0 | sum & 0xf, 0x50 | sum >> 4);
        let first = &decode(Format::Express, &[&bytes])[1];
        assert_eq!(first, &Found::Samples(CAPSULE, Vec::new()));
    }
}

#[test]
fn no_sample_takes_the_place_of_those_of_a_missing_capsule() {
    for format in [Format::Express, Format::Dense] {
        let whole = stream(format);
        let count = samples(&decode(format, &[&whole])).len();
        for missing in 2..whole.len() / CAPSULE - 1 {
            let (before, rest) = whole.split_at(missing * CAPSULE);
            let all = samples(&decode(format, &[before, &rest[CAPSULE..]]));
            assert!(all.iter().all(is_true), "{format:?}: capsule {missing}");
            assert!(all.len() + 81 > count, "two of the capsules are lost");
        }
    }
}

#[test]
fn the_greatest_number_is_no_distance() {
    let node = |distance: u16| {
        let [low, high] = distance.to_le_bytes();
        let node = [47 << 2 | 2, 0x01, 0x2d, low, high];
        samples(&decode(Format::Nodes, &[&node.repeat(BELIEVED)]))[0].distance
    };
    assert_eq!((node(u16::MAX), node(u16::MAX - 1)), (0.0, 16_383.5));
    let capsule = |format, distance| {
        let mut lidar = EmulatedRplidar {
            scanning: Some(format),
            ..EmulatedRplidar::a1(distance)
        };
        samples(&decode(format, &[&lidar.advance(0.1)]))[0].distance
    };
    assert_eq!(capsule(Format::Express, |_| 16_383), 0.0);
    assert_eq!(capsule(Format::Express, |_| 16_382), 16_382.0);
    assert_eq!(capsule(Format::Dense, |_| 65_535), 0.0);
    assert_eq!(capsule(Format::Dense, |_| 65_534), 65_534.0);
}

#[test]
fn a_wrong_byte_of_a_capsule_is_noticed() {
    for format in [Format::Express, Format::Dense] {
        let good = &stream(format)[..2 * CAPSULE];
        for index in 0..2 * CAPSULE {
            for bit in 0..8 {
                let mut wrong = good.to_vec();
                wrong[index] ^= 1 << bit;
                assert_eq!(samples(&decode(format, &[&wrong])), [], "byte {index}, bit {bit}");
            }
        }
    }
}

proptest! {
    #[test]
    fn the_same_is_found_after_any_split(index in 0..3_usize, cut in 0..800_usize) {
        let format = FORMATS[index];
        let bytes = &stream(format)[..800];
        let (head, tail) = bytes.split_at(cut);
        prop_assert_eq!(decode(format, &[head, tail]), decode(format, &[bytes]));
    }

    #[test]
    fn after_missing_and_foreign_bytes_only_true_samples_are_found(
        index in 0..3_usize,
        at in 0..500_usize,
        missing in 0..100_usize,
        noise in prop::collection::vec(any::<u8>(), 0..100),
    ) {
        let format = FORMATS[index];
        let bytes = stream(format);
        let found = decode(format, &[&bytes[..at], &noise, &bytes[at + missing..]]);
        let all = samples(&found);
        // Nodes are checked by two bits each: at most one of them may be believed in vain.
        let allowed = usize::from(format == Format::Nodes);
        prop_assert!(all.iter().filter(|sample| !is_true(sample)).count() <= allowed);
        let whole = samples(&decode(format, &[&bytes])).len();
        prop_assert!(all.len() + 250 >= whole, "{} of {}", all.len(), whole);
    }
}
