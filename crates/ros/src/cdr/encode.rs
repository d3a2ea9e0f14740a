//! Encodes the bytes of a value as a message. It never fails: a length above the capacity counts as the
//! capacity, and every byte of a text that is not UTF-8 becomes `?`.

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

use super::Writer;

/// Replaces the contents of `message` by the message of a value. A reused vector is not reallocated once it
/// is large enough.
///
/// # Panics
/// If there are fewer bytes than the type has.
pub fn encode(value_type: &Type, value: &[u8], message: &mut Vec<u8>) {
    assert!(
        value.len() >= value_type.bytes,
        "a `{}` has {} bytes, not {}",
        value_type.name,
        value_type.bytes,
        value.len()
    );
    structure(value_type, value, &mut Writer::new(message));
}

fn structure(value_type: &Type, value: &[u8], writer: &mut Writer<'_>) {
    if value_type.fields.is_empty() {
        // In ROS 2, a structure without members has one member, a zero byte.
        writer.bytes(&[0]);
    }
    for field in &value_type.fields {
        one_field(field, value, writer);
    }
}

fn one_field(field: &Field, value: &[u8], writer: &mut Writer<'_>) {
    let count = field.length(value);
    match field.form {
        Form::One | Form::Array(_) => {}
        Form::Sequence { .. } => writer.length(count),
        Form::Text { .. } => return writer.text(&value[field.offset..][..count]),
    }
    let bytes = field.kind.bytes();
    let elements = &value[field.offset..][..count * bytes];
    match &field.kind {
        FieldKind::Scalar(scalar) => scalars(*scalar, elements, writer),
        FieldKind::Struct(inner) => elements
            .chunks_exact(bytes)
            .for_each(|element| structure(inner, element, writer)),
    }
}

fn scalars(scalar: Scalar, elements: &[u8], writer: &mut Writer<'_>) {
    if elements.is_empty() {
        // An empty sequence has no alignment gap after its length.
        return;
    }
    writer.align(scalar.bytes());
    if scalar == Scalar::Bool {
        elements
            .iter()
            .for_each(|byte| writer.bytes(&[u8::from(*byte != 0)]));
    } else if cfg!(target_endian = "little") {
        writer.bytes(elements);
    } else {
        let reversed = |byte: &u8| writer.bytes(&[*byte]);
        let elements = elements.chunks_exact(scalar.bytes());
        elements
            .flat_map(|element| element.iter().rev())
            .for_each(reversed);
    }
}
