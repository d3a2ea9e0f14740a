//! Values that no reader expects. Every bit pattern of a number is valid; lengths and texts are not.

use jde_abi::describe::{Field, FieldKind, Form, Type};

/// Returns what no reader of a value expects: more elements than fit, or a text that is not UTF-8.
pub(crate) fn malformed(value_type: &Type, bytes: &[u8]) -> Option<String> {
    value_type
        .fields
        .iter()
        .find_map(|field| malformed_field(field, bytes))
}

fn malformed_field(field: &Field, bytes: &[u8]) -> Option<String> {
    let length_at = |offset: usize| {
        let bytes = bytes.get(offset..offset + 4)?;
        Some(u32::from_ne_bytes(bytes.try_into().ok()?) as usize)
    };
    let count = match field.form {
        Form::One => 1,
        Form::Array(count) => count,
        Form::Sequence {
            capacity,
            length_offset,
        }
        | Form::Text {
            capacity,
            length_offset,
        } => {
            let count = length_at(length_offset)?;
            if count > capacity {
                return Some(format!(
                    "{count} elements in `{}`, which has room for {capacity}",
                    field.name
                ));
            }
            count
        }
    };
    if let Form::Text { .. } = field.form {
        let text = bytes.get(field.offset..field.offset + count)?;
        return std::str::from_utf8(text)
            .is_err()
            .then(|| format!("a text in `{}` that is not UTF-8", field.name));
    }
    let FieldKind::Struct(inner) = &field.kind else {
        return None;
    };
    (0..count).find_map(|index| malformed(inner, bytes.get(field.offset + index * inner.bytes..)?))
}
