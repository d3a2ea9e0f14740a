//! Which parts of a value are searched for NaNs and infinities.

use jde_abi::describe::{FieldKind, Form, Scalar, Type};
use jde_abi::finite::Finite;
use jde_board::value::{Value, encode};

use crate::common::{field, float64, nested, scalar_field, sequence, structure, twist, vector};

fn check(value_type: &Type, change: impl FnOnce(&mut Vec<u8>)) -> Option<String> {
    let mut bytes = vec![0; value_type.bytes];
    change(&mut bytes);
    Finite::new(value_type).first_not_finite(&bytes)
}

fn put(bytes: &mut [u8], offset: usize, value: &[u8]) {
    bytes[offset..offset + value.len()].copy_from_slice(value);
}

#[test]
fn the_first_float_that_is_not_finite_is_named_by_its_path() {
    let bad = |offset, value: f64| check(&twist(), |bytes| put(bytes, offset, &value.to_ne_bytes()));
    assert_eq!(check(&twist(), |_| ()), None);
    assert_eq!(bad(0, f64::NAN).as_deref(), Some("linear.x"));
    assert_eq!(bad(32, f64::INFINITY).as_deref(), Some("angular.y"));
    assert_eq!(bad(40, f64::NEG_INFINITY).as_deref(), Some("angular.z"));
    assert_eq!(bad(40, f64::MAX), None);
    assert_eq!(
        bad(40, f64::MIN_POSITIVE / 2.0),
        None,
        "a subnormal number is finite"
    );
    assert_eq!(
        check(&float64(), |bytes| bytes.fill(0xff)).as_deref(),
        Some("data")
    );
}

#[test]
fn integers_with_the_bits_of_a_nan_are_accepted() {
    let counts = structure(
        "test/Counts",
        vec![scalar_field("a", Scalar::U64), scalar_field("b", Scalar::I64)],
    );
    assert_eq!(check(&counts, |bytes| bytes.fill(0xff)), None);
}

#[test]
fn only_the_present_elements_of_a_sequence_are_checked() {
    let scan = structure(
        "test/Scan",
        vec![sequence("ranges", FieldKind::Scalar(Scalar::F32), 4)],
    );
    let offset = scan.fields[0].offset;
    let check_length = |length: u32| {
        check(&scan, |bytes| {
            put(bytes, 0, &length.to_ne_bytes());
            put(bytes, offset + 2 * 4, &f32::NAN.to_ne_bytes());
        })
    };
    assert_eq!(check_length(0), None);
    assert_eq!(check_length(2), None);
    assert_eq!(check_length(3).as_deref(), Some("ranges[2]"));
    assert_eq!(
        check_length(u32::MAX).as_deref(),
        Some("ranges[2]"),
        "a false length is limited to the capacity"
    );
}

#[test]
fn structures_in_arrays_and_sequences_are_searched() {
    let pose = structure(
        "test/Pose",
        vec![nested("position", &vector()), scalar_field("t", Scalar::F64)],
    );
    let path = structure(
        "test/Path",
        vec![
            field("fixed", FieldKind::Struct(pose.clone()), Form::Array(2)),
            sequence("poses", FieldKind::Struct(pose.clone()), 3),
        ],
    );
    let poses = path.fields[1].offset;
    let bad = |offset| {
        check(&path, |bytes| {
            put(bytes, 2 * pose.bytes, &3u32.to_ne_bytes());
            put(bytes, offset, &f64::NAN.to_ne_bytes());
        })
    };
    assert_eq!(bad(pose.bytes + 8).as_deref(), Some("fixed[1].position.y"));
    assert_eq!(bad(poses + 2 * pose.bytes + 24).as_deref(), Some("poses[2].t"));
}

#[test]
fn values_written_by_encode_are_checked_alike() {
    let mut bytes = vec![0; 48];
    let value = Value::Map(vec![(
        "linear".to_owned(),
        Value::List(vec![0.0.into(), f64::NAN.into(), 0.0.into()]),
    )]);
    encode(&twist(), &value, &mut bytes).unwrap();
    assert_eq!(
        Finite::new(&twist()).first_not_finite(&bytes).as_deref(),
        Some("linear.y")
    );
}
