//! Encodes the bytes of a value as a message. It never fails: a length above the capacity counts as the
//! capacity, and every byte of a text that is not UTF-8 becomes `?`.

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

use super::ENCAPSULATION;

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
    message.clear();
    message.extend_from_slice(&ENCAPSULATION);
    structure(value_type, value, message);
}

fn structure(value_type: &Type, value: &[u8], message: &mut Vec<u8>) {
    if value_type.fields.is_empty() {
        // In ROS 2, a structure without members has one member, a zero byte.
        message.push(0);
    }
    for field in &value_type.fields {
        one_field(field, value, message);
    }
}

fn one_field(field: &Field, value: &[u8], message: &mut Vec<u8>) {
    let count = field.length(value);
    match field.form {
        Form::One | Form::Array(_) => {}
        Form::Sequence { .. } => length(count, message),
        Form::Text { .. } => {
            length(count + 1, message);
            text(&value[field.offset..][..count], message);
            message.push(0);
            return;
        }
    }
    let bytes = field.kind.bytes();
    let elements = &value[field.offset..][..count * bytes];
    match &field.kind {
        FieldKind::Scalar(scalar) => scalars(*scalar, elements, message),
        FieldKind::Struct(inner) => elements
            .chunks_exact(bytes)
            .for_each(|element| structure(inner, element, message)),
    }
}

fn scalars(scalar: Scalar, elements: &[u8], message: &mut Vec<u8>) {
    if elements.is_empty() {
        // An empty sequence has no alignment gap after its length.
        return;
    }
    align(scalar.bytes(), message);
    if scalar == Scalar::Bool {
        message.extend(elements.iter().map(|byte| u8::from(*byte != 0)));
    } else if cfg!(target_endian = "little") {
        message.extend_from_slice(elements);
    } else {
        let reversed = |element: &[u8]| message.extend(element.iter().rev());
        elements.chunks_exact(scalar.bytes()).for_each(reversed);
    }
}

/// Writes a text with its number of bytes unchanged: no replacement is longer than the original.
fn text(bytes: &[u8], message: &mut Vec<u8>) {
    for chunk in bytes.utf8_chunks() {
        message.extend_from_slice(chunk.valid().as_bytes());
        message.extend(chunk.invalid().iter().map(|_| b'?'));
    }
}

/// Writes the number of elements that follow, or of the bytes of a text.
pub(crate) fn length(length: usize, message: &mut Vec<u8>) {
    align(4, message);
    // A capacity is a `u32` in the descriptions.
    message.extend_from_slice(&(length as u32).to_le_bytes());
}

/// Writes zeros up to the next multiple of this number.
pub(crate) fn align(alignment: usize, message: &mut Vec<u8>) {
    let body = message.len() - ENCAPSULATION.len();
    message.resize(ENCAPSULATION.len() + body.next_multiple_of(alignment), 0);
}
