//! Formats values and times for people.

use std::path::Path;

use jde_abi::describe::{Limits, Port, Type};
use jde_app::is_path;
use jde_board::value::{self, Value};

use crate::failure;

/// Decodes and formats a value with its unit. A structure with one field is formatted as that field.
pub(super) fn format_value(value_type: &Type, bytes: &[u8], unit: &str) -> String {
    format_with_unit(decode_plain(value_type, bytes), unit)
}

/// Decodes and formats the value of a modulation with its unit, or as the name of a choice.
pub(super) fn format_modulation(port: &Port, limits: &Limits, bytes: &[u8]) -> String {
    let number = port.value_type.number_of(bytes);
    let chosen = number.and_then(|number| limits.choices.get(number as usize));
    chosen
        .cloned()
        .unwrap_or_else(|| format_value(&port.value_type, bytes, &port.unit))
}

/// Formats a value with its unit. A path is formatted as the user would write it.
pub(crate) fn format_with_unit(value: Value, unit: &str) -> String {
    match value {
        Value::Text(path) if is_path(unit, &path) => {
            Value::Text(failure::display_path(Path::new(&path))).to_string()
        }
        text @ Value::Text(_) => text.to_string(),
        value if unit.is_empty() => rounded(value).to_string(),
        value => format!("{} {unit}", rounded(value)),
    }
}

/// Rounds all floating-point numbers to six digits.
fn rounded(value: Value) -> Value {
    match value {
        Value::Float(number) if number.is_finite() => {
            let text = format!("{number:.5e}");
            Value::Float(text.parse().unwrap_or(number))
        }
        Value::List(list) => Value::List(list.into_iter().map(rounded).collect()),
        Value::Map(fields) => {
            let fields = fields.into_iter();
            Value::Map(fields.map(|(name, value)| (name, rounded(value))).collect())
        }
        other => other,
    }
}

/// Decodes a value. A structure with one field is replaced by that field.
pub(crate) fn decode_plain(value_type: &Type, bytes: &[u8]) -> Value {
    value::decode(value_type, bytes).into_only_field()
}

/// Returns the name of a type, without the package `std_msgs`.
pub(super) fn short_type_name(value_type: &Type) -> &str {
    value_type
        .name
        .strip_prefix("std_msgs/msg/")
        .unwrap_or(&value_type.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_with_few_digits() {
        let pose = Value::List(vec![Value::Float(core::f64::consts::PI), Value::Float(0.5)]);
        assert_eq!(rounded(pose).to_string(), "[3.14159, 0.5]");
        assert_eq!(rounded(Value::Float(1_234_567.0)).to_string(), "1234570");
        assert_eq!(rounded(Value::Float(f64::INFINITY)).to_string(), "inf");
        assert_eq!(rounded(Value::Float(0.0)).to_string(), "0");
    }
}
