//! The values of a schema at a low rate: as text, and as numbers for curves. The newest value wins.

use std::sync::Arc;

use jde_board::value::Value;
use jde_link::{Rate, Subscription};
use serde::Serialize;

use crate::feeds::Parts;
use crate::model::Model;

/// How often a page shows a value.
const RATE: Rate = Rate::Hz(5);
/// Variables of a schema that are shown.
const MAX_VARIABLES: usize = 64;
/// The longest value that is shown as text, bytes: a scan of a laser is larger.
const MAX_BYTES: usize = 1024;
/// The longest text of a value, in characters.
const MAX_TEXT: usize = 300;

/// Numbers of a value that a page can draw over time.
const MAX_NUMBERS: usize = 16;

/// A value as a page shows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct ValueView {
    name: String,
    access: String,
    doc: String,
    text: String,
    /// When it was written, s.
    time_s: f64,
    /// Its numbers, each with the name of its field.
    numbers: Vec<(String, f64)>,
}

/// Subscribes to the variables of a schema, which become the parts of a topic. Waits for the link.
///
/// # Errors
/// There is no such schema, or no connection.
pub(crate) fn open(model: &Model, schema: &str, parts: &Arc<Parts>) -> Result<Vec<Subscription>, String> {
    if !model.schemas.schemas.iter().any(|known| known.name == schema) {
        return Err(format!("there is no schema `{schema}`"));
    }
    let mut subscriptions = Vec::new();
    let of_schema = model.variables.iter().filter(|variable| variable.owner == schema);
    for (place, variable) in of_schema.take(MAX_VARIABLES).enumerate() {
        let mut view = ValueView {
            name: variable.variable.clone(),
            access: variable.access.clone(),
            doc: variable.doc.clone(),
            text: "no value yet".to_owned(),
            time_s: 0.0,
            numbers: Vec::new(),
        };
        let value_type = variable.value_type().map_err(|error| error.to_string())?;
        if value_type.bytes > MAX_BYTES {
            view.text = format!("{}: too large to be shown as text", variable.type_name);
            parts.set(place, &view);
            continue;
        }
        parts.set(place, &view);
        let sink = Arc::clone(parts);
        let (unit, choices) = (variable.unit.clone(), variable.range.choices.clone());
        let watched = model.remote.watch(&variable.name, RATE, move |sample| {
            view.time_s = sample.time as f64 / 1e9;
            view.numbers.clear();
            view.text = match sample.value() {
                Some(value) => {
                    let value = value.into_only_field();
                    numbers("", &value, &mut view.numbers);
                    text(value, &unit, &choices)
                }
                None => "no value".to_owned(),
            };
            sink.set(place, &view);
        });
        subscriptions.push(watched.map_err(|error| error.to_string())?);
    }
    Ok(subscriptions)
}

/// Adds the numbers of a value, each with the name of its field.
fn numbers(name: &str, value: &Value, all: &mut Vec<(String, f64)>) {
    let mut add = |part: &str, value: &Value| {
        let name = if name.is_empty() {
            part.to_owned()
        } else {
            format!("{name}.{part}")
        };
        numbers(&name, value, all);
    };
    match value {
        Value::Map(fields) => fields.iter().for_each(|(part, value)| add(part, value)),
        Value::List(list) => (0..)
            .zip(list)
            .for_each(|(place, value)| add(&format!("{place}"), value)),
        Value::Float(_) | Value::Bool(_) | Value::Int(_) | Value::UInt(_) | Value::Text(_) => {
            let number = value
                .as_number()
                .filter(|number| number.is_finite() && all.len() < MAX_NUMBERS);
            all.extend(number.map(|number| (name.to_owned(), number)));
        }
    }
}

fn text(value: Value, unit: &str, choices: &[String]) -> String {
    let place = value
        .as_number()
        .filter(|number| *number >= 0.0 && number.fract() == 0.0);
    let chosen = place.and_then(|number| choices.get(number as usize));
    if let Some(chosen) = chosen {
        return chosen.clone();
    }
    let mut text = rounded(value).to_string();
    if text.chars().count() > MAX_TEXT {
        text = text.chars().take(MAX_TEXT).chain([' ', '…']).collect();
    }
    if unit.is_empty() {
        text
    } else {
        format!("{text} {unit}")
    }
}

/// Rounds numbers to what fits on a phone.
fn rounded(value: Value) -> Value {
    match value {
        Value::Float(number) if number.is_finite() => {
            let text = format!("{number:.3e}");
            Value::Float(text.parse().unwrap_or(number))
        }
        Value::List(list) => Value::List(list.into_iter().map(rounded).collect()),
        Value::Map(fields) => {
            let fields = fields.into_iter();
            Value::Map(fields.map(|(name, value)| (name, rounded(value))).collect())
        }
        Value::Float(_) | Value::Bool(_) | Value::Int(_) | Value::UInt(_) | Value::Text(_) => value,
    }
}
