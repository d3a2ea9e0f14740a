//! Decodes bytes as a [`Value`]. It never fails: a length above the capacity counts as the capacity, and
//! invalid UTF-8 in a text is replaced.

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

use super::Value;

/// Returns the fields of a value by name.
///
/// # Panics
/// If there are fewer bytes than the type has.
#[must_use]
pub fn decode(value_type: &Type, bytes: &[u8]) -> Value {
    let fields = value_type.fields.iter();
    Value::Map(
        fields
            .map(|field| (field.name.clone(), decode_field(field, bytes)))
            .collect(),
    )
}

/// Returns one field of the structure at the start of `bytes`.
pub(super) fn decode_field(field: &Field, bytes: &[u8]) -> Value {
    match field.form {
        Form::One => decode_element(field, bytes, 0),
        Form::Array(_) | Form::Sequence { .. } => {
            let count = field.length(bytes);
            Value::List(
                (0..count)
                    .map(|index| decode_element(field, bytes, index))
                    .collect(),
            )
        }
        Form::Text { .. } => {
            let text = &bytes[field.offset..][..field.length(bytes)];
            Value::Text(String::from_utf8_lossy(text).into_owned())
        }
    }
}

/// Returns one element of a field of the structure at the start of `bytes`.
pub(super) fn decode_element(field: &Field, bytes: &[u8], index: usize) -> Value {
    let bytes = &bytes[field.offset + index * field.kind.bytes()..];
    match &field.kind {
        FieldKind::Struct(inner) => decode(inner, bytes),
        FieldKind::Scalar(scalar) => decode_scalar(*scalar, bytes),
    }
}

/// Returns the number or bool at the start of `bytes`.
///
/// # Panics
/// If there are fewer bytes than the scalar has.
#[must_use]
pub fn decode_scalar(scalar: Scalar, bytes: &[u8]) -> Value {
    match scalar {
        Scalar::Bool => Value::Bool(bytes[0] != 0),
        Scalar::U8 => Value::UInt(bytes[0].into()),
        Scalar::U16 => Value::UInt(u16::from_ne_bytes(chunk(bytes)).into()),
        Scalar::U32 => Value::UInt(u32::from_ne_bytes(chunk(bytes)).into()),
        Scalar::U64 => Value::UInt(u64::from_ne_bytes(chunk(bytes))),
        Scalar::I8 => Value::Int(i8::from_ne_bytes(chunk(bytes)).into()),
        Scalar::I16 => Value::Int(i16::from_ne_bytes(chunk(bytes)).into()),
        Scalar::I32 => Value::Int(i32::from_ne_bytes(chunk(bytes)).into()),
        Scalar::I64 => Value::Int(i64::from_ne_bytes(chunk(bytes))),
        Scalar::F32 => Value::Float(f32::from_ne_bytes(chunk(bytes)).into()),
        Scalar::F64 => Value::Float(f64::from_ne_bytes(chunk(bytes))),
    }
}

fn chunk<const N: usize>(bytes: &[u8]) -> [u8; N] {
    *bytes.first_chunk().expect("a value has all bytes of its type")
}
