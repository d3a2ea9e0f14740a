//! Values of any type to and from JSON, as operators type them and scripts read them. Units and ranges are
//! not checked: the owner of a variable does that.

use jde_board::value::Value;
use serde_json::{Map, Number};

/// Converts a value to JSON. A NaN or an infinity, for which JSON has no number, becomes the text `nan`,
/// `inf` or `-inf`.
#[must_use]
pub fn to_json(value: &Value) -> serde_json::Value {
    use serde_json::Value as Json;
    match value {
        Value::Bool(flag) => Json::Bool(*flag),
        Value::Int(number) => Json::from(*number),
        Value::UInt(number) => Json::from(*number),
        Value::Float(number) => match Number::from_f64(*number) {
            Some(number) => Json::Number(number),
            None if number.is_nan() => Json::from("nan"),
            None if *number > 0.0 => Json::from("inf"),
            None => Json::from("-inf"),
        },
        Value::Text(text) => Json::from(text.as_str()),
        Value::List(values) => Json::Array(values.iter().map(to_json).collect()),
        Value::Map(fields) => {
            let fields = fields.iter().map(|(name, value)| (name.clone(), to_json(value)));
            Json::Object(fields.collect::<Map<_, _>>())
        }
    }
}

/// Converts JSON to a value.
///
/// # Errors
/// `null` is not a value.
pub fn from_json(json: &serde_json::Value) -> Result<Value, String> {
    use serde_json::Value as Json;
    Ok(match json {
        Json::Null => return Err("null is not a value; omit the field to keep its value".to_owned()),
        Json::Bool(flag) => Value::Bool(*flag),
        Json::Number(number) => match (number.as_i64(), number.as_u64()) {
            (Some(number), _) => Value::Int(number),
            (None, Some(number)) => Value::UInt(number),
            (None, None) => Value::Float(number.as_f64().unwrap_or(f64::NAN)),
        },
        Json::String(text) => Value::Text(text.clone()),
        Json::Array(values) => Value::List(values.iter().map(from_json).collect::<Result<_, _>>()?),
        Json::Object(fields) => {
            let field = |(name, value): (&String, &Json)| Ok((name.clone(), from_json(value)?));
            Value::Map(fields.iter().map(field).collect::<Result<_, String>>()?)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_survive_conversion_to_json_and_back() {
        let value = Value::Map(vec![
            ("gain".to_owned(), Value::Float(0.5)),
            (
                "list".to_owned(),
                Value::List(vec![Value::Int(-3), Value::UInt(u64::MAX)]),
            ),
            ("name".to_owned(), Value::Text("goon".to_owned())),
            ("on".to_owned(), Value::Bool(true)),
        ]);
        assert_eq!(from_json(&to_json(&value)), Ok(value));
    }

    #[test]
    fn nan_and_infinities_become_text() {
        assert_eq!(to_json(&Value::Float(f64::NAN)), "nan");
        assert_eq!(to_json(&Value::Float(f64::NEG_INFINITY)), "-inf");
        assert!(from_json(&serde_json::json!([null])).is_err());
    }
}
