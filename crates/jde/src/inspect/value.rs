//! Values and times as people read them.

use jde_abi::describe::Type;
use jde_board::value::{self, Value};

/// A value with its unit; what is a single number or text is shown as such.
pub(super) fn shown(value_type: &Type, bytes: &[u8], unit: &str) -> String {
    let value = plain(value_type, bytes);
    let unit = if unit == "path" || unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    format!("{value}{unit}")
}

/// A value; what is a single number or text is given as such.
pub(super) fn plain(value_type: &Type, bytes: &[u8]) -> Value {
    match value::decode(value_type, bytes) {
        Value::Map(mut fields) if fields.len() == 1 => fields.remove(0).1,
        other => other,
    }
}

/// A value for a tool.
pub(super) fn json(value: &Value) -> serde_json::Value {
    match value {
        Value::Bool(value) => (*value).into(),
        Value::Int(value) => (*value).into(),
        Value::UInt(value) => (*value).into(),
        // JSON has no NaN and no infinities.
        Value::Float(value) if !value.is_finite() => value.to_string().into(),
        Value::Float(value) => (*value).into(),
        Value::Text(text) => text.as_str().into(),
        Value::List(list) => list.iter().map(json).collect(),
        Value::Map(fields) => fields
            .iter()
            .map(|(name, value)| (name.clone(), json(value)))
            .collect(),
    }
}

/// The name of a type without its package, where that is as good.
pub(super) fn short(value_type: &Type) -> &str {
    value_type
        .name
        .strip_prefix("std_msgs/msg/")
        .unwrap_or(&value_type.name)
}
