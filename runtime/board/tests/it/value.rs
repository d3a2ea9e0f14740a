//! Values without their Rust types: decoding inverts encoding, and errors name the path of the part that does
//! not fit.

use std::sync::Arc;

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};
use jde_board::value::{Value, decode, encode, get_path};
use proptest::prelude::*;

use crate::common::{field, float64, nested, scalar_field, sequence, structure, text, twist, vector};

/// A type with every kind and form of field.
fn robot() -> Arc<Type> {
    let pose = structure(
        "test/Pose2D",
        ["x", "y", "theta"]
            .map(|name| scalar_field(name, Scalar::F64))
            .into(),
    );
    structure(
        "test/Robot",
        vec![
            nested("pose", &pose),
            sequence("path", FieldKind::Struct(pose), 4),
            scalar_field("id", Scalar::U32),
            scalar_field("small", Scalar::I16),
            scalar_field("level", Scalar::U8),
            scalar_field("on", Scalar::Bool),
            field("matrix", FieldKind::Scalar(Scalar::F32), Form::Array(3)),
            text("name", 16),
            scalar_field("far", Scalar::I64),
        ],
    )
}

fn map<const N: usize>(fields: [(&str, Value); N]) -> Value {
    Value::Map(
        fields
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
    )
}

fn list<const N: usize>(numbers: [f64; N]) -> Value {
    Value::List(numbers.map(Value::Float).into())
}

fn encoded(value_type: &Type, value: &Value) -> Vec<u8> {
    let mut bytes = vec![0; value_type.bytes];
    encode(value_type, value, &mut bytes).unwrap_or_else(|error| panic!("{value}: {error}"));
    bytes
}

/// Returns the message for a value that does not fit. The bytes must be unchanged.
fn error_of(value_type: &Type, value: &Value) -> String {
    let mut bytes = vec![0x5a; value_type.bytes];
    let error = encode(value_type, value, &mut bytes).unwrap_err();
    assert!(
        bytes.iter().all(|byte| *byte == 0x5a),
        "a refused value changes nothing"
    );
    error.to_string()
}

fn round_trip_text(value_type: &Type, value: &Value) -> String {
    decode(value_type, &encoded(value_type, value)).to_string()
}

#[test]
fn a_plain_number_is_accepted_for_a_type_of_one_field() {
    assert_eq!(encoded(&float64(), &Value::Float(1.5)), 1.5f64.to_ne_bytes());
    assert_eq!(encoded(&float64(), &Value::Int(-2)), (-2f64).to_ne_bytes());
    assert_eq!(
        round_trip_text(&float64(), &map([("data", 0.25.into())])),
        "{data: 0.25}"
    );
    let path = structure("std_msgs/msg/String", vec![text("data", 8)]);
    assert_eq!(round_trip_text(&path, &"a.toml".into()), r#"{data: "a.toml"}"#);
}

#[test]
fn missing_fields_keep_their_values() {
    let mut bytes = encoded(
        &twist(),
        &map([
            ("linear", list([1.0, 2.0, 3.0])),
            ("angular", list([4.0, 5.0, 6.0])),
        ]),
    );
    encode(&twist(), &map([("linear", map([("y", 9.0.into())]))]), &mut bytes).unwrap();
    assert_eq!(
        decode(&twist(), &bytes).to_string(),
        "{linear: {x: 1, y: 9, z: 3}, angular: {x: 4, y: 5, z: 6}}"
    );
}

#[test]
fn a_list_of_lists_fills_a_sequence_of_structures_of_numbers() {
    let robot = robot();
    let mut bytes = encoded(
        &robot,
        &map([(
            "path",
            Value::List(vec![list([1.0, 2.0, 3.0]), list([4.0, 5.0, 6.0])]),
        )]),
    );
    assert_eq!(get_path(&robot, &bytes, "path[1].y").unwrap(), Value::Float(5.0));
    // The sequence shrinks by one. The second element is cleared, and does not reappear when the sequence
    // grows again.
    let pose = |x: f64| map([("x", x.into())]);
    encode(&robot, &map([("path", Value::List(vec![pose(7.0)]))]), &mut bytes).unwrap();
    assert_eq!(
        get_path(&robot, &bytes, "path").unwrap().to_string(),
        "[{x: 7, y: 2, theta: 3}]"
    );
    encode(
        &robot,
        &map([("path", Value::List(vec![pose(8.0), pose(9.0)]))]),
        &mut bytes,
    )
    .unwrap();
    assert_eq!(
        get_path(&robot, &bytes, "path").unwrap().to_string(),
        "[{x: 8, y: 2, theta: 3}, {x: 9, y: 0, theta: 0}]"
    );
}

#[test]
fn a_shorter_text_clears_the_longer_one() {
    let robot = robot();
    let mut bytes = encoded(&robot, &map([("name", "long name".into())]));
    encode(&robot, &map([("name", "ñ".into())]), &mut bytes).unwrap();
    assert_eq!(bytes, encoded(&robot, &map([("name", "ñ".into())])));
}

#[test]
fn an_error_names_the_path_of_the_part_that_does_not_fit() {
    let robot = robot();
    let check = |value: Value, expected: &str| assert_eq!(error_of(&robot, &value), expected);
    check(
        map([("nam", "x".into())]),
        "the value has no field `nam`; did you mean `name`?",
    );
    check(
        map([("pose", map([("yaw", 1.0.into())]))]),
        "`pose` has no field `yaw`; it has x, y, theta",
    );
    check(
        map([("level", Value::Int(300))]),
        "`level` is a uint8 and cannot hold 300; give 0 to 255",
    );
    check(
        map([("level", Value::Int(-1))]),
        "`level` is a uint8 and cannot hold -1; give 0 to 255",
    );
    check(
        map([("far", Value::UInt(u64::MAX))]),
        "`far` is a int64 and cannot hold 18446744073709551615; give -9223372036854775808 to 9223372036854775807",
    );
    check(
        map([("level", 1.5.into())]),
        "`level` must be a whole number, not 1.5",
    );
    check(map([("on", Value::Int(1))]), "`on` must be true or false, not 1");
    check(
        map([("name", "a very, very long name".into())]),
        "`name` has room for 16 bytes of text, and 22 were given",
    );
    check(
        map([("matrix", list([1.0, 2.0]))]),
        "`matrix` needs exactly 3 values, and 2 were given",
    );
    check(
        map([("matrix", Value::List(vec![0.0.into(), "x".into(), 0.0.into()]))]),
        "`matrix[1]` must be a number, not the text `x`",
    );
    check(
        map([("matrix", list([0.0, 1e300, 0.0]))]).clone(),
        &format!(
            "`matrix[1]` is a float32 and cannot hold {}; give {} to {}",
            1e300,
            f32::MIN,
            f32::MAX
        ),
    );
    check(
        map([("path", Value::List(vec![list([0.0; 3]); 5]))]),
        "`path` has room for 4 elements, and 5 were given",
    );
    check(
        map([("path", Value::List(vec![list([0.0; 3]), list([0.0, 1.0])]))]),
        "`path[1]` needs exactly 3 values, and 2 were given",
    );
    check(
        map([("path", Value::List(vec![map([("x", "far".into())])]))]),
        "`path[0].x` must be a number, not the text `far`",
    );
    check(
        map([("pose", 1.0.into())]),
        "`pose` must be named fields or a list of 3: x, y, theta, not 1",
    );
    check(
        map([("id", Value::Int(7)), ("level", Value::Int(256))]),
        "`level` is a uint8 and cannot hold 256; give 0 to 255",
    );
    assert_eq!(
        encode(&float64(), &1.0.into(), &mut [0; 4])
            .unwrap_err()
            .to_string(),
        "a `std_msgs/msg/Float64` has 8 bytes, not 4"
    );
}

#[test]
fn numbers_that_are_not_finite_are_written_unchanged() {
    let robot = robot();
    let bytes = encoded(&robot, &map([("matrix", list([f64::NAN, f64::INFINITY, 0.5]))]));
    assert_eq!(
        get_path(&robot, &bytes, "matrix").unwrap().to_string(),
        "[NaN, inf, 0.5]"
    );
}

#[test]
fn a_part_is_selected_by_its_path() {
    let robot = robot();
    let bytes = encoded(
        &robot,
        &map([
            ("pose", list([1.0, 2.0, 3.0])),
            ("path", Value::List(vec![list([4.0, 5.0, 6.0])])),
            ("name", "pioneer".into()),
        ]),
    );
    let part = |path: &str| {
        get_path(&robot, &bytes, path)
            .map(|value| value.to_string())
            .map_err(|e| e.to_string())
    };
    let found = |path: &str, expected: &str| assert_eq!(part(path).as_deref(), Ok(expected), "{path}");
    let missing = |path: &str, expected: &str| assert_eq!(part(path), Err(expected.to_owned()), "{path}");
    found("pose.y", "2");
    found("pose", "{x: 1, y: 2, theta: 3}");
    found("path[0].theta", "6");
    found("path[0]", "{x: 4, y: 5, theta: 6}");
    found("matrix[2]", "0");
    found("name", r#""pioneer""#);
    assert_eq!(get_path(&robot, &bytes, "").unwrap(), decode(&robot, &bytes));
    missing("pse", "the value has no field `pse`; did you mean `pose`?");
    missing("pose.z", "`pose` has no field `z`; it has x, y, theta");
    missing(
        "path[0].thetas",
        "`path[0]` has no field `thetas`; did you mean `theta`?",
    );
    missing(
        "path[1]",
        "`path` has 1 elements, counted from 0; there is no [1]",
    );
    missing(
        "path.x",
        "path `path.x`: `path` is a list; add an index, as in `path[0]`",
    );
    missing("id.x", "path `id.x`: `id` has no fields");
    missing("id[0]", "path `id[0]`: only lists have elements");
    missing("name[0]", "path `name[0]`: only lists have elements");
    missing(
        "path[x]",
        "path `path[x]`: `path[x]` does not have the form `path[3]`",
    );
    missing("pose.", "`pose` has no field ``; it has x, y, theta");
    missing("[0]", "path `[0]`: an index follows a field, as in `path[0]`");
    missing("pose.[0]", "`pose` has no field ``; it has x, y, theta");
}

#[test]
fn a_false_length_is_limited_to_the_capacity() {
    let name = structure("std_msgs/msg/String", vec![text("data", 4)]);
    let mut bytes = encoded(&name, &"abcd".into());
    bytes[..4].copy_from_slice(&u32::MAX.to_ne_bytes());
    assert_eq!(decode(&name, &bytes).to_string(), r#"{data: "abcd"}"#);
    bytes[4..].copy_from_slice(&[0xff; 4]);
    assert!(
        decode(&name, &bytes).to_string().contains('\u{fffd}'),
        "invalid characters are replaced"
    );
}

#[test]
fn a_vector_accepts_a_list_of_its_numbers_in_order() {
    assert_eq!(
        round_trip_text(&vector(), &list([1.0, -2.5, 1e-3])),
        "{x: 1, y: -2.5, z: 0.001}"
    );
}

/// Generates a scalar field's type and a value of it.
fn scalar() -> impl Strategy<Value = (Scalar, Value)> {
    let float = prop_oneof![
        any::<f64>().prop_filter("a NaN does not equal itself", |x| !x.is_nan()),
        Just(f64::INFINITY)
    ];
    prop_oneof![
        any::<bool>().prop_map(|x| (Scalar::Bool, Value::Bool(x))),
        any::<u8>().prop_map(|x| (Scalar::U8, Value::UInt(x.into()))),
        any::<u16>().prop_map(|x| (Scalar::U16, Value::UInt(x.into()))),
        any::<u32>().prop_map(|x| (Scalar::U32, Value::UInt(x.into()))),
        any::<u64>().prop_map(|x| (Scalar::U64, Value::UInt(x))),
        any::<i8>().prop_map(|x| (Scalar::I8, Value::Int(x.into()))),
        any::<i16>().prop_map(|x| (Scalar::I16, Value::Int(x.into()))),
        any::<i32>().prop_map(|x| (Scalar::I32, Value::Int(x.into()))),
        any::<i64>().prop_map(|x| (Scalar::I64, Value::Int(x))),
        any::<f32>()
            .prop_filter("as above", |x| !x.is_nan())
            .prop_map(|x| (Scalar::F32, Value::Float(x.into()))),
        float.prop_map(|x| (Scalar::F64, Value::Float(x))),
    ]
}

/// Generates a field without its offset, and a value of it. Structures nest `depth` deep.
fn any_field(depth: u32) -> BoxedStrategy<(Field, Value)> {
    let single = scalar().prop_map(|(scalar, value)| (scalar_field("", scalar), value));
    let text_field = ("[a-zñ€]{0,6}", 18usize..24)
        .prop_map(|(content, capacity)| (text("", capacity), Value::Text(content)));
    let single = prop_oneof![3 => single, 1 => text_field].boxed();
    if depth == 0 {
        return single;
    }
    let structure_field = any_type(depth - 1).prop_map(|(inner, value)| (nested("", &inner), value));
    // Several elements of a type are copies of one value. Other tests vary the contents.
    let list_field = (any_type(depth - 1), 1usize..4, 0usize..4, any::<bool>()).prop_map(
        |((inner, value), capacity, length, fixed)| {
            let kind = FieldKind::Struct(inner);
            if fixed {
                (
                    field("", kind, Form::Array(capacity)),
                    Value::List(vec![value; capacity]),
                )
            } else {
                (
                    sequence("", kind, capacity),
                    Value::List(vec![value; length.min(capacity)]),
                )
            }
        },
    );
    prop_oneof![2 => single, 1 => structure_field, 1 => list_field].boxed()
}

/// Generates a type and a value of it.
fn any_type(depth: u32) -> BoxedStrategy<(Arc<Type>, Value)> {
    prop::collection::vec(any_field(depth), 1..5)
        .prop_map(|parts| {
            let mut fields = Vec::new();
            let mut values = Vec::new();
            for (number, (mut field, value)) in parts.into_iter().enumerate() {
                field.name = format!("f{number}");
                values.push((field.name.clone(), value));
                fields.push(field);
            }
            (packed("test/Any", fields), Value::Map(values))
        })
        .boxed()
}

/// Returns a type with consecutive fields, aligned or not: decoding and encoding must not depend on
/// alignment.
fn packed(name: &str, mut fields: Vec<Field>) -> Arc<Type> {
    let mut bytes = 0;
    for field in &mut fields {
        if let Form::Sequence { length_offset, .. } | Form::Text { length_offset, .. } = &mut field.form {
            *length_offset = bytes;
            bytes += 4;
        }
        field.offset = bytes;
        bytes += field.kind.bytes() * field.form.capacity();
    }
    Arc::new(Type {
        name: name.to_owned(),
        doc: String::new(),
        bytes,
        align: 1,
        fields,
    })
}

proptest! {
    #[test]
    fn an_encoded_value_is_decoded_unchanged((value_type, value) in any_type(2), old in any::<u8>()) {
        let mut bytes = vec![old; value_type.bytes];
        encode(&value_type, &value, &mut bytes).unwrap();
        prop_assert_eq!(decode(&value_type, &bytes), value.clone());
        // The old bytes under a new value have no effect.
        let Value::Map(fields) = &value else { unreachable!() };
        for (name, part) in fields {
            prop_assert_eq!(&get_path(&value_type, &bytes, name).unwrap(), part);
        }
    }

    #[test]
    fn any_bytes_can_be_decoded_and_encoded_again((value_type, _) in any_type(2), seed in any::<[u8; 32]>()) {
        let bytes: Vec<u8> = seed.into_iter().cycle().take(value_type.bytes).collect();
        let value = decode(&value_type, &bytes);
        let mut reencoded = bytes.clone();
        match encode(&value_type, &value, &mut reencoded) {
            // Compared as texts, because a NaN does not equal itself.
            Ok(()) => prop_assert_eq!(decode(&value_type, &reencoded).to_string(), value.to_string()),
            // Replacement characters may need more bytes than the invalid ones.
            Err(error) => prop_assert!(error.to_string().contains("bytes of text"), "{error}"),
        }
    }

    #[test]
    fn no_path_panics((value_type, value) in any_type(1), path in "[f0-3.\\[\\]x]{0,12}") {
        let mut bytes = vec![0; value_type.bytes];
        encode(&value_type, &value, &mut bytes).unwrap();
        let _ = get_path(&value_type, &bytes, &path);
    }
}

#[test]
fn a_part_of_a_structure_keeps_the_name_of_its_field() {
    let part = map([("id", 7_i64.into())]);
    assert_eq!(part.clone().into_only_field_of(&robot()), part);
    let number = map([("data", 7.0.into())]);
    assert_eq!(number.into_only_field_of(&float64()), 7.0.into());
}
