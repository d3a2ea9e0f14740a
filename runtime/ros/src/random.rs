//! Random types for tests, with the memory layout of C and of schemas' sequences and texts. It makes no
//! values.

use std::sync::Arc;

use jde_abi::describe::{Field, FieldKind, Form, RosNotation, Scalar, Type};
use proptest::prelude::*;

/// The number of elements of a field.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Multiplicity {
    One,
    Array(usize),
    Sequence(usize),
    Text(usize),
}

/// Returns a type with these fields. Different types have different names.
pub(crate) fn of_fields(fields: Vec<(FieldKind, Multiplicity)>) -> Type {
    let (mut at, mut alignment) = (0_usize, 1);
    let fields = fields.into_iter().enumerate().map(|(number, (kind, shape))| {
        let kind = match shape {
            Multiplicity::Text(_) => FieldKind::Scalar(Scalar::U8),
            Multiplicity::One | Multiplicity::Array(_) | Multiplicity::Sequence(_) => kind,
        };
        let align = match shape {
            Multiplicity::One | Multiplicity::Array(_) => kind.align(),
            Multiplicity::Sequence(_) | Multiplicity::Text(_) => kind.align().max(4),
        };
        let start = at.next_multiple_of(align);
        let (form, head) = match shape {
            Multiplicity::One => (Form::One, 0),
            Multiplicity::Array(count) => (Form::Array(count), 0),
            Multiplicity::Sequence(capacity) => (
                Form::Sequence {
                    capacity,
                    length_offset: start,
                },
                8,
            ),
            Multiplicity::Text(capacity) => (
                Form::Text {
                    capacity,
                    length_offset: start,
                },
                4,
            ),
        };
        at = (start + head + kind.bytes() * form.capacity()).next_multiple_of(align);
        alignment = alignment.max(align);
        Field {
            name: format!("f{number}"),
            doc: String::new(),
            unit: String::new(),
            offset: start + head,
            kind,
            form,
            notation: RosNotation::default(),
        }
    });
    let fields: Vec<Field> = fields.collect();
    let mut value_type = Type {
        name: String::new(),
        doc: String::new(),
        bytes: at.next_multiple_of(alignment).max(1),
        align: alignment,
        fields,
    };
    value_type.name = format!("random_msgs/msg/T{:016x}", value_type.hash());
    value_type
}

/// Generates types of up to four fields, three levels deep.
pub(crate) fn types() -> impl Strategy<Value = Type> {
    let scalar = prop::sample::select(vec![
        Scalar::Bool,
        Scalar::U8,
        Scalar::U16,
        Scalar::U32,
        Scalar::U64,
        Scalar::I8,
        Scalar::I16,
        Scalar::I32,
        Scalar::I64,
        Scalar::F32,
        Scalar::F64,
    ])
    .prop_map(FieldKind::Scalar);
    let shape = || {
        prop_oneof![
            Just(Multiplicity::One),
            (1..5usize).prop_map(Multiplicity::Array),
            (1..5usize).prop_map(Multiplicity::Sequence),
            (1..9usize).prop_map(Multiplicity::Text)
        ]
    };
    let flat = prop::collection::vec((scalar.clone(), shape()), 0..5).prop_map(of_fields);
    flat.prop_recursive(3, 24, 4, move |inner| {
        let inner = inner.prop_map(|inner| FieldKind::Struct(Arc::new(inner)));
        let kind = prop_oneof![scalar.clone(), inner];
        prop::collection::vec((kind, shape()), 0..5).prop_map(of_fields)
    })
}
