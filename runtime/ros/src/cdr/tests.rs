//! Messages are compared with bytes computed by hand. Values of every standard type and of random types are
//! encoded and decoded.

use std::fmt::Debug;

use jde_abi::describe::{FieldKind, Form, Scalar, Type};
use jde_types::{Frame, Header, LaserScan, Seq, Text, Time, Twist, Value, Vector3};
use proptest::prelude::*;

use super::*;
use crate::random::{Multiplicity, of_fields, types};

/// Checks both directions: encoding gives the message, and decoding gives the value.
fn assert_message<T: Value + PartialEq + Debug>(value: &T, expected: &[u8]) {
    let value_type = T::describe();
    let bytes = decode(&value_type, expected).unwrap();
    assert_eq!(T::from_bytes(&bytes).as_ref(), Some(value));
    let mut message = vec![0xff; 3];
    encode(&value_type, &bytes, &mut message);
    assert_eq!(message, expected);
}

fn bytes(parts: &[&[u8]]) -> Vec<u8> {
    parts.concat()
}

#[test]
fn a_header_is_its_time_and_a_text_with_a_nul() {
    let header = Header {
        stamp: Time {
            sec: 1,
            nanosec: 0x0203,
        },
        frame_id: Frame::truncated("base"),
    };
    let expected = bytes(&[
        &[0, 1, 0, 0],
        &[1, 0, 0, 0],
        &[3, 2, 0, 0],
        &[5, 0, 0, 0],
        b"base\0",
    ]);
    assert_message(&header, &expected);
}

#[test]
fn a_twist_is_six_numbers() {
    let twist = Twist {
        linear: Vector3 {
            x: 0.5,
            ..Vector3::default()
        },
        angular: Vector3 {
            z: -2.0,
            ..Vector3::default()
        },
    };
    let mut expected = vec![0, 1, 0, 0];
    // IEEE 754: 0.5 is 3fe0..., -2.0 is c000...
    expected.extend([0, 0, 0, 0, 0, 0, 0xe0, 0x3f]);
    expected.extend([0; 4 * 8]);
    expected.extend([0, 0, 0, 0, 0, 0, 0x00, 0xc0]);
    assert_message(&twist, &expected);
}

#[test]
fn a_laser_scan_is_aligned_from_the_end_of_the_header() {
    let scan = LaserScan {
        header: Header {
            stamp: Time { sec: 2, nanosec: 0 },
            frame_id: Frame::truncated("laser"),
        },
        angle_min: 1.0,
        range_max: 2.0,
        ranges: Seq::from_slice(&[f32::INFINITY, 0.5]).unwrap(),
        ..LaserScan::default()
    };
    let expected = bytes(&[
        &[0, 1, 0, 0],
        &[2, 0, 0, 0],
        &[0; 4],
        &[6, 0, 0, 0],
        b"laser\0",
        // 18 bytes of the body so far: two to the next multiple of four.
        &[0; 2],
        &[0, 0, 0x80, 0x3f],
        &[0; 5 * 4],
        &[0, 0, 0, 0x40],
        &[2, 0, 0, 0],
        &[0, 0, 0x80, 0x7f],
        &[0, 0, 0, 0x3f],
        &[0, 0, 0, 0],
    ]);
    assert_message(&scan, &expected);
}

#[test]
fn decoding_in_place_replaces_the_whole_value() {
    let mut scan = LaserScan {
        ranges: Seq::from_slice(&[1.0; 9]).unwrap(),
        ..LaserScan::default()
    };
    let other = LaserScan {
        header: Header::new(Time { sec: 3, nanosec: 4 }, "laser"),
        ranges: Seq::from_slice(&[2.0, 3.0]).unwrap(),
        ..LaserScan::default()
    };
    let mut message = Vec::new();
    encode(&LaserScan::describe(), other.as_bytes(), &mut message);
    decode_into(&LaserScan::describe(), &message, scan.as_bytes_mut()).unwrap();
    assert_eq!(scan, other);
}

#[test]
fn an_empty_sequence_has_no_alignment_gap() {
    let value_type = of_fields(vec![(FieldKind::Scalar(Scalar::F64), Multiplicity::Sequence(2))]);
    let mut message = Vec::new();
    encode(&value_type, &vec![0; value_type.bytes], &mut message);
    assert_eq!(message, [0, 1, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn a_structure_without_fields_is_one_byte() {
    let value_type = of_fields(Vec::new());
    let mut message = Vec::new();
    encode(&value_type, &[7; 8], &mut message);
    assert_eq!(message, [0, 1, 0, 0, 0]);
    assert!(decode(&value_type, &message).is_ok());
    assert!(decode(&value_type, &message[..4]).is_err());
}

#[test]
fn invalid_lengths_and_letters_are_replaced() {
    let value_type = of_fields(vec![(FieldKind::Scalar(Scalar::U8), Multiplicity::Text(4))]);
    let mut invalid = vec![0xff; value_type.bytes];
    invalid[value_type.fields[0].offset..][..4].copy_from_slice(b"a\xffcd");
    let mut message = Vec::new();
    encode(&value_type, &invalid, &mut message);
    assert_eq!(message, b"\0\x01\0\0\x05\0\0\0a?cd\0");
}

#[test]
fn an_invalid_message_is_refused_with_its_field() {
    let text = Text::<4>::describe();
    assert_eq!(
        decode(&text, &[0, 0, 0, 0]),
        Err(Error::Encapsulation(vec![0, 0, 0, 0]))
    );
    assert!(matches!(decode(&text, &[0]), Err(Error::Encapsulation(_))));
    let short = Err(Error::Truncated("data".to_owned()));
    assert_eq!(decode(&text, b"\0\x01\0\0\x09\0\0\0a?cd\0"), short);
    assert_eq!(decode(&text, b"\0\x01\0\0\xff\xff\xff\xff"), short);
    let no_text = Err(Error::Text("data".to_owned()));
    assert_eq!(decode(&text, b"\0\x01\0\0\x02\0\0\0ab"), no_text);
    assert_eq!(decode(&text, b"\0\x01\0\0\x00\0\0\0"), no_text);
    assert_eq!(decode(&text, b"\0\x01\0\0\x02\0\0\0\xff\0"), no_text);
    assert_eq!(
        decode(&text, b"\0\x01\0\0\x06\0\0\0abcde\0"),
        Err(Error::Capacity {
            field: "data".to_owned(),
            capacity: 4,
            got: 5
        })
    );
    assert_eq!(decode(&text, b"\0\x01\0\0\x01\0\0\0\0....."), Err(Error::Long(5)));
}

#[test]
fn a_text_of_a_list_that_does_not_fit_is_refused_as_part_of_the_list() {
    let names = crate::definition::read("a/msg/A", "string<=2[<=3] names").unwrap();
    let message = b"\0\x01\0\0\x01\0\0\0\x04\0\0\0abc\0";
    let error = Error::Capacity {
        field: "names".to_owned(),
        capacity: 2,
        got: 3,
    };
    assert_eq!(decode(&names, message), Err(error));
    assert_eq!(
        decode(&names, &message[..14]),
        Err(Error::Truncated("names".to_owned()))
    );
}

/// Pseudo-random numbers (SplitMix64; Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Fills a value. Bytes outside of its fields stay zero.
    fn fill(&mut self, value_type: &Type, value: &mut [u8]) {
        for field in &value_type.fields {
            let capacity = field.form.capacity();
            let count = match field.form.length_offset() {
                None => capacity,
                Some(offset) => {
                    let count = (self.next() % (capacity as u64 + 1)) as usize;
                    value[offset..][..4].copy_from_slice(&(count as u32).to_ne_bytes());
                    count
                }
            };
            let size = field.kind.bytes();
            let elements = &mut value[field.offset..][..count * size];
            match (&field.kind, field.form) {
                (_, Form::Text { .. }) => {
                    elements.fill_with(|| (self.next() % 127) as u8);
                    // A letter of two bytes, if the capacity allows.
                    if let Some(letter) = elements.first_chunk_mut() {
                        *letter = [0xc3, 0xa9];
                    }
                }
                (FieldKind::Scalar(Scalar::Bool), _) => elements.fill_with(|| (self.next() & 1) as u8),
                (FieldKind::Scalar(_), _) => elements.fill_with(|| self.next() as u8),
                (FieldKind::Struct(inner), _) => elements
                    .chunks_exact_mut(size)
                    .for_each(|element| self.fill(inner, element)),
            }
        }
    }
}

fn assert_round_trip(value_type: &Type, seed: u64) -> Result<(), TestCaseError> {
    let mut value = vec![0; value_type.bytes];
    Random(seed).fill(value_type, &mut value);
    let mut message = Vec::new();
    encode(value_type, &value, &mut message);
    let decoded = decode(value_type, &message);
    prop_assert!(
        decoded.as_ref() == Ok(&value),
        "{} came back as {decoded:?}",
        value_type.name
    );
    Ok(())
}

proptest! {
    #[test]
    fn random_values_of_random_types_survive(value_type in types(), seed: u64) {
        assert_round_trip(&value_type, seed)?;
    }

    #[test]
    fn a_copy_is_the_same_value_whatever_was_there_before(value_type in types(), seed: u64) {
        let mut value = vec![0; value_type.bytes];
        Random(seed).fill(&value_type, &mut value);
        prop_assert_eq!(&value_type.copy(&value), &value);
        let mut copy = vec![0xff; value_type.bytes];
        value_type.copy_into(&value, &mut copy);
        let [mut expected, mut message] = [Vec::new(), Vec::new()];
        encode(&value_type, &value, &mut expected);
        encode(&value_type, &copy, &mut message);
        prop_assert_eq!(message, expected);
    }

    #[test]
    fn a_value_fits_into_the_extent_of_its_message(value_type in types(), seed: u64) {
        let mut value = vec![0; value_type.bytes];
        Random(seed).fill(&value_type, &mut value);
        let [mut message, mut again] = [Vec::new(), Vec::new()];
        encode(&value_type, &value, &mut message);
        let mut extent = Extent::new(&value_type);
        prop_assert_eq!(extent.include(&message), Ok(()));
        let fitted = extent.into_type();
        let value = decode(&fitted, &message).expect("a message that was included");
        encode(&fitted, &value, &mut again);
        prop_assert_eq!(again, message);
    }

    #[test]
    fn a_message_of_what_is_copied_and_what_is_not_is_the_same(
        value_type in types(), seed: u64, least in 1..40_usize,
    ) {
        let mut value = vec![0; value_type.bytes];
        Random(seed).fill(&value_type, &mut value);
        let [mut expected, mut copied, mut message] = [Vec::new(), Vec::new(), Vec::new()];
        encode(&value_type, &value, &mut expected);
        let mut from = 0;
        for uncopied in encode::encode_from(least, &value_type, &value, &mut copied) {
            prop_assert!(uncopied.numbers.len() >= least);
            message.extend_from_slice(&copied[from..uncopied.after]);
            message.extend_from_slice(uncopied.numbers);
            from = uncopied.after;
        }
        message.extend_from_slice(&copied[from..]);
        prop_assert_eq!(message, expected);
    }

    #[test]
    fn a_message_in_pieces_is_the_same_value(value_type in types(), seed: u64, cuts: Vec<prop::sample::Index>) {
        let mut value = vec![0; value_type.bytes];
        Random(seed).fill(&value_type, &mut value);
        let mut message = Vec::new();
        encode(&value_type, &value, &mut message);
        let mut pieces = Vec::new();
        let mut start = 0;
        let places = cuts.iter().map(|cut| cut.index(message.len()));
        for end in places.collect::<std::collections::BTreeSet<_>>().into_iter().chain([message.len()]) {
            pieces.push(&message[start..end]);
            start = end;
        }
        let mut decoded = vec![0; value_type.bytes];
        decode_pieces(&value_type, &pieces, &mut decoded).unwrap();
        prop_assert_eq!(decoded, value);
        pieces.pop();
        prop_assert_eq!(
            decode_pieces(&value_type, &pieces, &mut vec![0; value_type.bytes]),
            decode(&value_type, &pieces.concat()).map(drop)
        );
    }

    #[test]
    fn a_message_cut_short_is_refused(value_type in types(), seed: u64, cut: prop::sample::Index) {
        let mut value = vec![0; value_type.bytes];
        Random(seed).fill(&value_type, &mut value);
        let mut message = Vec::new();
        encode(&value_type, &value, &mut message);
        prop_assert!(decode(&value_type, &message[..cut.index(message.len())]).is_err());
    }

    #[test]
    fn random_bytes_do_not_panic(value_type in types(), mut message: Vec<u8>) {
        message.splice(..0, CDR_LITTLE_ENDIAN);
        // Any result is allowed; only a panic would fail the test.
        let _ = decode(&value_type, &message);
    }
}

proptest! {
    // Each case covers all types, images included.
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn random_values_of_every_standard_type_survive(seed: u64) {
        for value_type in jde_types::standard() {
            assert_round_trip(&value_type, seed)?;
        }
    }
}

#[test]
fn a_text_that_is_too_long_is_cut_between_characters_on_request() {
    let frame = format!("{}äb", "a".repeat(51));
    let mut message = vec![0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0];
    message.extend(u32::try_from(frame.len() + 1).unwrap().to_le_bytes());
    message.extend(frame.as_bytes());
    message.push(0);
    let header = Header::describe();
    let mut value = vec![0; header.bytes];
    assert!(matches!(
        decode_into(&header, &message, &mut value),
        Err(Error::Capacity { .. })
    ));
    let mut cuts = Vec::new();
    let mut on_cut = |field: &str, capacity: usize| cuts.push((field.to_owned(), capacity));
    decode_cutting(&header, &message, &mut value, &mut on_cut).unwrap();
    assert_eq!(cuts, [("frame_id".to_owned(), 52)]);
    let header = Header::from_bytes(&value).unwrap();
    assert_eq!(header.frame_id.as_str(), "a".repeat(51));
    assert_eq!(header.stamp.nanosec, 2);
    for cut in 12..message.len() {
        let mut value = vec![0; value.len()];
        let short = decode_cutting(&Header::describe(), &message[..cut], &mut value, &mut |_, _| ());
        assert!(short.is_err(), "{cut}");
    }
}

#[test]
fn a_type_with_the_extent_of_messages_has_room_for_them_and_no_more() {
    let whole = LaserScan::describe();
    let mut extent = Extent::new(&whole);
    for ranges in [&[1.0, 2.0, 3.0][..], &[], &[4.0]] {
        let scan = LaserScan {
            ranges: Seq::from_slice(ranges).unwrap(),
            ..LaserScan::default()
        };
        let mut message = Vec::new();
        encode(&whole, scan.as_bytes(), &mut message);
        extent.include(&message).unwrap();
    }
    let fitted = extent.into_type();
    let of = |name: &str| fitted.fields.iter().find(|field| field.name == name).unwrap();
    assert_eq!(of("ranges").form.capacity(), 3);
    assert!(fitted.bytes < 100, "{}", fitted.bytes);
}
