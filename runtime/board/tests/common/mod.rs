//! Types and variables that the tests share.
#![allow(
    dead_code,
    unreachable_pub,
    reason = "each test file uses only some of the helpers"
)]

use std::sync::Arc;

use jde_abi::describe::{Field, FieldKind, Form, RosNotation, Scalar, Type};
use jde_board::{Access, Board, Declaration, LASTING, Variable};

/// Returns a type with the layout of C, without padding: the callers order fields so that none is needed.
pub fn structure(name: &str, fields: Vec<Field>) -> Arc<Type> {
    let mut bytes = 0;
    let mut align = 1;
    let fields: Vec<Field> = fields
        .into_iter()
        .map(|mut field| {
            if let Form::Sequence { length_offset, .. } | Form::Text { length_offset, .. } = &mut field.form {
                *length_offset = bytes;
                // The length, with padding before elements of eight bytes.
                bytes += field.kind.align().max(4);
                align = align.max(4);
            }
            assert_eq!(
                bytes % field.kind.align(),
                0,
                "field {} is not aligned",
                field.name
            );
            field.offset = bytes;
            bytes += field.kind.bytes() * field.form.capacity();
            align = align.max(field.kind.align());
            field
        })
        .collect();
    assert_eq!(bytes % align, 0, "type {name} needs padding");
    Arc::new(Type {
        name: name.to_owned(),
        doc: String::new(),
        bytes,
        align,
        fields,
    })
}

pub fn field(name: &str, kind: FieldKind, form: Form) -> Field {
    Field {
        name: name.to_owned(),
        doc: String::new(),
        unit: String::new(),
        kind,
        form,
        offset: 0,
        notation: RosNotation::default(),
    }
}

pub fn scalar_field(name: &str, scalar: Scalar) -> Field {
    field(name, FieldKind::Scalar(scalar), Form::One)
}

pub fn nested(name: &str, inner: &Arc<Type>) -> Field {
    field(name, FieldKind::Struct(inner.clone()), Form::One)
}

pub fn sequence(name: &str, kind: FieldKind, capacity: usize) -> Field {
    let length_offset = 0;
    field(
        name,
        kind,
        Form::Sequence {
            capacity,
            length_offset,
        },
    )
}

pub fn text(name: &str, capacity: usize) -> Field {
    let length_offset = 0;
    field(
        name,
        FieldKind::Scalar(Scalar::U8),
        Form::Text {
            capacity,
            length_offset,
        },
    )
}

pub fn float64() -> Arc<Type> {
    structure("std_msgs/msg/Float64", vec![scalar_field("data", Scalar::F64)])
}

pub fn word_array(count: usize) -> Arc<Type> {
    structure(
        "test/Words",
        vec![field("words", FieldKind::Scalar(Scalar::U64), Form::Array(count))],
    )
}

pub fn vector() -> Arc<Type> {
    structure(
        "geometry_msgs/msg/Vector3",
        ["x", "y", "z"].map(|name| scalar_field(name, Scalar::F64)).into(),
    )
}

pub fn twist() -> Arc<Type> {
    structure(
        "geometry_msgs/msg/Twist",
        vec![nested("linear", &vector()), nested("angular", &vector())],
    )
}

pub fn declaration(name: &str, value_type: &Arc<Type>, access: Access) -> Declaration {
    Declaration {
        owner: "pioneer".to_owned(),
        name: name.to_owned(),
        doc: String::new(),
        unit: String::new(),
        value_type: value_type.clone(),
        access,
        limits: jde_abi::describe::Limits::default(),
        initial: None,
        writers: 2,
        readers: 2,
    }
}

pub fn variable(value_type: &Arc<Type>, access: Access) -> Arc<Variable> {
    Board::new()
        .declare(declaration("laser", value_type, access))
        .unwrap()
}

pub const COMMAND: Access = Access::Command { validity: 500 };
pub const EXPORT: Access = Access::Export { validity: LASTING };
