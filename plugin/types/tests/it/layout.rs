//! Descriptions of values, and values with wrong bytes.

use jde_abi::describe::{Field, FieldKind, Form, Scalar};
use jde_types::*;

fn field<'a>(ty: &'a jde_abi::describe::Type, name: &str) -> &'a Field {
    ty.fields.iter().find(|field| field.name == name).expect(name)
}

fn names<T: Value>() -> Vec<String> {
    T::describe().fields.into_iter().map(|field| field.name).collect()
}

#[test]
fn every_standard_type_is_described_completely() {
    // `describe` uses the host's reader, which refuses bytes that belong to no field.
    let types = standard();
    for ty in &types {
        assert!(!ty.doc.is_empty(), "{} has documentation", ty.name);
        for field in &ty.fields {
            let documented = !field.doc.is_empty() || ty.name.ends_with("Quaternion");
            assert!(documented, "{}.{} has documentation", ty.name, field.name);
        }
    }
    let mut hashes: Vec<u64> = types.iter().map(jde_abi::describe::Type::hash).collect();
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), types.len(), "the hashes are unique");
}

#[test]
fn fields_are_those_of_the_ros_interfaces_without_padding() {
    assert_eq!(
        names::<LaserScan>(),
        [
            "header",
            "angle_min",
            "angle_max",
            "angle_increment",
            "time_increment",
            "scan_time",
            "range_min",
            "range_max",
            "ranges",
            "intensities"
        ]
    );
    assert_eq!(
        names::<Range>(),
        [
            "header",
            "radiation_type",
            "field_of_view",
            "min_range",
            "max_range",
            "range",
            "variance"
        ]
    );
    assert_eq!(
        names::<Image>(),
        [
            "header",
            "height",
            "width",
            "encoding",
            "is_bigendian",
            "step",
            "data"
        ]
    );
    assert_eq!(names::<Odometry>(), ["header", "child_frame_id", "pose", "twist"]);
}

#[test]
fn lengths_are_at_the_described_offsets() {
    let scan = LaserScan::describe();
    let ranges = field(&scan, "ranges");
    let Form::Sequence {
        capacity,
        length_offset,
    } = ranges.form
    else {
        panic!("expected a sequence")
    };
    assert_eq!((capacity, length_offset + 8), (1088, ranges.offset));
    assert_eq!(
        (&ranges.kind, &*ranges.unit),
        (&FieldKind::Scalar(Scalar::F32), "m")
    );

    let header = Header::describe();
    let frame = field(&header, "frame_id");
    assert_eq!(
        frame.form,
        Form::Text {
            capacity: 52,
            length_offset: frame.offset - 4
        }
    );
    assert_eq!(field(&Path::describe(), "poses").form.capacity(), 256);
}

#[test]
fn a_type_with_a_single_number_is_a_number() {
    assert_eq!(f64::describe().as_number(), Some(Scalar::F64));
    assert_eq!(Flag::describe().as_number(), Some(Scalar::Bool));
    assert_eq!(Text::<8>::describe().as_number(), None);
    assert_eq!(
        (f64::describe().name, Flag::describe().name),
        ("std_msgs/msg/Float64".into(), "std_msgs/msg/Bool".into())
    );
}

/// A sequence on its own.
#[derive(Clone, Copy, Value)]
#[repr(C)]
struct SequenceOnly {
    /// The sequence.
    items: Seq<f32, 8>,
}

#[test]
fn a_derived_type_is_named_after_its_crate_by_default() {
    assert_eq!(SequenceOnly::describe().name, "jde_types/msg/SequenceOnly");
}

#[test]
fn a_sequence_accepts_what_fits_and_returns_the_rest() {
    let mut seq = Seq::<u32, 4>::from_slice(&[1, 2, 3]).expect("the elements fit");
    assert_eq!(
        seq.extend_from_slice(&[4, 5]),
        Err(TooLong {
            length: 5,
            capacity: 4
        })
    );
    assert_eq!(seq.as_slice(), [1, 2, 3], "all elements are added, or none");
    assert_eq!((seq.push(4), seq.push(5)), (Ok(()), Err(5)));
    assert_eq!(seq.resize(9).len(), 4);
    seq.clear();
    assert!(seq.is_empty());
    assert_eq!(Seq::<u32, 4>::from_iter(0..9).as_slice(), [0, 1, 2, 3]);
}

#[test]
fn a_text_is_cut_between_characters_or_refused() {
    assert_eq!(Text::<4>::truncated("añoñ"), "año");
    assert_eq!(
        Text::<4>::try_from("abcde"),
        Err(TooLong {
            length: 5,
            capacity: 4
        })
    );
    assert_eq!(
        Text::<4>::try_from("abcd").expect("the text fits").to_string(),
        "abcd"
    );
    assert_eq!(Text::<4>::new("ab"), Text::<4>::new("ab"));
}
