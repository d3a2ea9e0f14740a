//! Which values of modulations are the same, although one was rounded or is stated in another form.

use jde_board::value::Value;

/// The greatest difference between equal numbers, as a share of them: more than conversions of units and JSON cause.
const ROUNDING: f64 = 1e-9;

/// Whether two values are the same but for rounding. A structure with one field is that field; fields that only one of the
/// two has do not count.
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
        (one, other) => match (one.as_number(), other.as_number()) {
            (Some(one), Some(other)) => (one - other).abs() <= ROUNDING * one.abs().max(other.abs()),
            (Some(_), None) | (None, Some(_)) => false,
            (None, None) => one == other,
        },
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
