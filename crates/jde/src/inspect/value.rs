//! Values and times as people read them.

use std::path::Path;

use jde_abi::describe::Type;
use jde_board::value::{self, Value};
use jde_host::app::is_path;

use crate::failure;

/// A value with its unit; what is a single number or text is shown as such.
pub(super) fn shown(value_type: &Type, bytes: &[u8], unit: &str) -> String {
    with_unit(plain(value_type, bytes), unit)
}

/// A value with its unit; paths as the user would write them.
pub(crate) fn with_unit(value: Value, unit: &str) -> String {
    match value {
        Value::Text(path) if is_path(unit) && !path.is_empty() => {
            Value::Text(failure::shown(Path::new(&path))).to_string()
        }
        value if unit.is_empty() || is_path(unit) => rounded(value).to_string(),
        value => format!("{} {unit}", rounded(value)),
    }
}

/// The value with six digits to a number, which is as much as anybody reads.
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

/// A value; what is a single number or text is given as such.
pub(crate) fn plain(value_type: &Type, bytes: &[u8]) -> Value {
    match value::decode(value_type, bytes) {
        Value::Map(mut fields) if fields.len() == 1 => fields.remove(0).1,
        other => other,
    }
}

/// The name of a type without its package, where that is as good.
pub(super) fn short(value_type: &Type) -> &str {
    value_type
        .name
        .strip_prefix("std_msgs/msg/")
        .unwrap_or(&value_type.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_with_as_many_digits_as_anybody_reads() {
        let pose = Value::List(vec![Value::Float(core::f64::consts::PI), Value::Float(0.5)]);
        assert_eq!(rounded(pose).to_string(), "[3.14159, 0.5]");
        assert_eq!(rounded(Value::Float(1_234_567.0)).to_string(), "1234570");
        assert_eq!(rounded(Value::Float(f64::INFINITY)).to_string(), "inf");
        assert_eq!(rounded(Value::Float(0.0)).to_string(), "0");
    }
}
