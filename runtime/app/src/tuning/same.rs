//! Which values of modulations are the same, although one was rounded or is stated in another form.

use jde_board::value::Value;

/// The greatest difference between equal floats, as a share of them: a modulation may have 32 bits. Conversions of units and
/// JSON cause less.
const ROUNDING: f64 = f32::EPSILON as f64;

/// Whether two values are the same but for the rounding of floats. A structure with one field is that field; fields that
/// only one of the two has do not count.
#[must_use]
pub fn is_same(one: &Value, other: &Value) -> bool {
    match (only(one), only(other)) {
        (Value::Map(one), Value::Map(other)) => one.iter().all(|(name, value)| {
            let other = other.iter().find(|(known, _)| known == name);
            other.is_none_or(|(_, other)| is_same(value, other))
        }),
        (Value::List(one), Value::List(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| is_same(one, other))
        }
        (one, other) => match (whole(one).zip(whole(other)), one.as_number(), other.as_number()) {
            (Some((one, other)), _, _) => one == other,
            (None, Some(one), Some(other)) => (one - other).abs() <= ROUNDING * one.abs().max(other.abs()),
            (None, Some(_), None) | (None, None, Some(_)) => false,
            (None, None, None) => one == other,
        },
    }
}

/// A whole number of any type.
fn whole(value: &Value) -> Option<i128> {
    match value {
        Value::Int(number) => Some(i128::from(*number)),
        Value::UInt(number) => Some(i128::from(*number)),
        Value::Bool(_) | Value::Float(_) | Value::Text(_) | Value::List(_) | Value::Map(_) => None,
    }
}

/// The field of a structure with one field.
pub(super) fn only(mut value: &Value) -> &Value {
    while let Value::Map(fields) = value
        && let [(_, field)] = fields.as_slice()
    {
        value = field;
    }
    value
}

/// Whether a value is a structure with this field.
pub(super) fn has_field(value: &Value, field: &str) -> bool {
    match value {
        Value::Map(fields) => fields.iter().any(|(name, _)| name == field),
        Value::Bool(_)
        | Value::Int(_)
        | Value::UInt(_)
        | Value::Float(_)
        | Value::Text(_)
        | Value::List(_) => false,
    }
}
