//! Encodes a [`Value`] as bytes. All or nothing: if a part does not fit, nothing is written.

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};
use jde_nearest::nearest;

use super::{Value, ValueError};

/// Writes a value over the one in `output`.
///
/// Fields that a map does not name keep their values. New elements of sequences start at zero. A type with a
/// single field also accepts the value of that field, and a structure of numbers also accepts a list in the
/// order of its fields.
///
/// # Errors
/// The part that does not fit, with its path. `output` is then unchanged.
pub fn encode(value_type: &Type, value: &Value, output: &mut [u8]) -> Result<(), ValueError> {
    if output.len() != value_type.bytes {
        return Err(ValueError::Size {
            value_type: value_type.name.clone(),
            expected: value_type.bytes,
            got: output.len(),
        });
    }
    let mut scratch = output.to_vec();
    encode_struct(value_type, value, &mut scratch, "")?;
    output.copy_from_slice(&scratch);
    Ok(())
}

fn encode_struct(value_type: &Type, value: &Value, output: &mut [u8], path: &str) -> Result<(), ValueError> {
    match value {
        Value::Map(entries) => {
            for (name, value) in entries {
                let Some(field) = value_type.fields.iter().find(|field| field.name == *name) else {
                    return Err(unknown_field(value_type, path, name));
                };
                encode_field(field, value, output, &join(path, name))?;
            }
            Ok(())
        }
        Value::List(values) if is_numbers(value_type) => {
            exactly(value_type.fields.len(), values.len(), path)?;
            for (field, value) in value_type.fields.iter().zip(values) {
                encode_field(field, value, output, &join(path, &field.name))?;
            }
            Ok(())
        }
        Value::Bool(_)
        | Value::Int(_)
        | Value::UInt(_)
        | Value::Float(_)
        | Value::Text(_)
        | Value::List(_) => {
            match value_type.fields.as_slice() {
                // The path does not grow: a caller that gives a bare value does not name the field.
                [only] => encode_field(only, value, output, path),
                _ => Err(ValueError::Kind {
                    path: path.to_owned(),
                    expected: expected_struct(value_type),
                    got: value.named(),
                }),
            }
        }
    }
}

fn encode_field(field: &Field, value: &Value, output: &mut [u8], path: &str) -> Result<(), ValueError> {
    match (field.form, value) {
        (Form::One, _) => encode_element(field, value, output, 0, path),
        (Form::Array(count), Value::List(values)) => {
            exactly(count, values.len(), path)?;
            encode_elements(field, values, output, path)
        }
        (
            Form::Sequence {
                capacity,
                length_offset,
            },
            Value::List(values),
        ) => {
            at_most(capacity, values.len(), "elements", path)?;
            let (old, new) = (field.length(output), values.len());
            // Bytes past the old end or past the new end belong to no element.
            let bytes = field.kind.bytes();
            output[field.offset..][old.min(new) * bytes..capacity * bytes].fill(0);
            set_length(output, length_offset, new);
            encode_elements(field, values, output, path)
        }
        (
            Form::Text {
                capacity,
                length_offset,
            },
            Value::Text(text),
        ) => {
            at_most(capacity, text.len(), "bytes of text", path)?;
            let buffer = &mut output[field.offset..][..capacity];
            buffer[..text.len()].copy_from_slice(text.as_bytes());
            buffer[text.len()..].fill(0);
            set_length(output, length_offset, text.len());
            Ok(())
        }
        (Form::Array(_) | Form::Sequence { .. }, _) => Err(kind(path, "a list", value)),
        (Form::Text { .. }, _) => Err(kind(path, "a text", value)),
    }
}

fn encode_elements(field: &Field, values: &[Value], output: &mut [u8], path: &str) -> Result<(), ValueError> {
    for (index, value) in values.iter().enumerate() {
        encode_element(field, value, output, index, &format!("{path}[{index}]"))?;
    }
    Ok(())
}

fn encode_element(
    field: &Field,
    value: &Value,
    output: &mut [u8],
    index: usize,
    path: &str,
) -> Result<(), ValueError> {
    let bytes = field.kind.bytes();
    let output = &mut output[field.offset + index * bytes..][..bytes];
    match &field.kind {
        FieldKind::Struct(inner) => encode_struct(inner, value, output, path),
        FieldKind::Scalar(scalar) => encode_scalar(*scalar, value, output, path),
    }
}

fn encode_scalar(scalar: Scalar, value: &Value, output: &mut [u8], path: &str) -> Result<(), ValueError> {
    macro_rules! whole {
        ($number:ty) => {{
            let number = match value {
                Value::Int(number) => i128::from(*number),
                Value::UInt(number) => i128::from(*number),
                Value::Bool(_) | Value::Float(_) | Value::Text(_) | Value::List(_) | Value::Map(_) => {
                    return Err(kind(path, "a whole number", value));
                }
            };
            let number = <$number>::try_from(number)
                .map_err(|_| range(scalar, value, <$number>::MIN, <$number>::MAX, path))?;
            output.copy_from_slice(&number.to_ne_bytes());
        }};
    }
    let float = || value.as_number().ok_or_else(|| kind(path, "a number", value));
    match scalar {
        Scalar::Bool => match value {
            Value::Bool(flag) => output[0] = u8::from(*flag),
            Value::Int(_)
            | Value::UInt(_)
            | Value::Float(_)
            | Value::Text(_)
            | Value::List(_)
            | Value::Map(_) => {
                return Err(kind(path, "true or false", value));
            }
        },
        Scalar::U8 => whole!(u8),
        Scalar::U16 => whole!(u16),
        Scalar::U32 => whole!(u32),
        Scalar::U64 => whole!(u64),
        Scalar::I8 => whole!(i8),
        Scalar::I16 => whole!(i16),
        Scalar::I32 => whole!(i32),
        Scalar::I64 => whole!(i64),
        Scalar::F32 => {
            let number = float()?;
            let narrow = number as f32;
            if number.is_finite() && !narrow.is_finite() {
                return Err(range(scalar, value, f32::MIN, f32::MAX, path));
            }
            output.copy_from_slice(&narrow.to_ne_bytes());
        }
        Scalar::F64 => output.copy_from_slice(&float()?.to_ne_bytes()),
    }
    Ok(())
}

pub(super) fn unknown_field(value_type: &Type, path: &str, field: &str) -> ValueError {
    let known: Vec<String> = value_type.fields.iter().map(|field| field.name.clone()).collect();
    ValueError::UnknownField {
        path: path.to_owned(),
        field: field.to_owned(),
        nearest: nearest(field, known.iter().map(String::as_str)).map(str::to_owned),
        known,
    }
}

/// Returns whether every field is one number, so a list in their order is complete.
fn is_numbers(value_type: &Type) -> bool {
    let number = |field: &Field| field.form == Form::One && matches!(field.kind, FieldKind::Scalar(_));
    !value_type.fields.is_empty() && value_type.fields.iter().all(number)
}

fn expected_struct(value_type: &Type) -> String {
    let names: Vec<&str> = value_type
        .fields
        .iter()
        .map(|field| field.name.as_str())
        .collect();
    if is_numbers(value_type) {
        format!("named fields or a list of {}: {}", names.len(), names.join(", "))
    } else {
        format!("named fields: {}", names.join(", "))
    }
}

fn set_length(output: &mut [u8], offset: usize, length: usize) {
    // A capacity is a `u32` in the descriptions.
    output[offset..][..4].copy_from_slice(&(length as u32).to_ne_bytes());
}

fn exactly(expected: usize, got: usize, path: &str) -> Result<(), ValueError> {
    if expected == got {
        return Ok(());
    }
    Err(ValueError::Count {
        path: path.to_owned(),
        expected,
        got,
    })
}

fn at_most(capacity: usize, got: usize, what: &'static str, path: &str) -> Result<(), ValueError> {
    if got <= capacity {
        return Ok(());
    }
    Err(ValueError::TooLong {
        path: path.to_owned(),
        what,
        capacity,
        got,
    })
}

fn kind(path: &str, expected: &str, value: &Value) -> ValueError {
    ValueError::Kind {
        path: path.to_owned(),
        expected: expected.to_owned(),
        got: value.named(),
    }
}

fn range<T: ToString>(scalar: Scalar, value: &Value, least: T, greatest: T, path: &str) -> ValueError {
    ValueError::Range {
        path: path.to_owned(),
        scalar: scalar.ros_name(),
        got: value.named(),
        least: least.to_string(),
        greatest: greatest.to_string(),
    }
}

pub(super) fn join(path: &str, name: &str) -> String {
    if path.is_empty() {
        name.to_owned()
    } else {
        format!("{path}.{name}")
    }
}
