//! The values of the schema that a page shows, at a low rate, as text. The newest value wins.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_board::value::Value;
use jde_link::{Rate, Sample, Subscription};
use parking_lot::Mutex;
use serde::Serialize;

use crate::model::Model;

/// How often a page shows a value.
const RATE: Rate = Rate::Hz(5);
/// Variables of a schema that are shown.
const MAX_VARIABLES: usize = 64;
/// The longest value that is shown as text, bytes: a scan of a laser is larger.
const MAX_BYTES: usize = 1024;
/// The longest text of a value, in characters.
const MAX_TEXT: usize = 300;

/// A value as a page shows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ValueText {
    name: String,
    access: String,
    doc: String,
    text: String,
}

/// The values of a schema, for as long as a page shows them.
pub(crate) struct Values {
    pub(crate) schema: String,
    changed: Arc<Mutex<BTreeMap<usize, ValueText>>>,
    _subscriptions: Vec<Subscription>,
}

impl Values {
    /// Subscribes to the variables of a schema. Waits for the link.
    ///
    /// # Errors
    /// There is no such schema, or no connection.
    pub(crate) fn open(model: &Model, schema: &str) -> Result<Self, String> {
        if !model.schemas.schemas.iter().any(|known| known.name == schema) {
            return Err(format!("there is no schema `{schema}`"));
        }
        let changed: Arc<Mutex<BTreeMap<usize, ValueText>>> = Arc::default();
        let mut subscriptions = Vec::new();
        let of_schema = model.variables.iter().filter(|variable| variable.owner == schema);
        for (place, variable) in of_schema.take(MAX_VARIABLES).enumerate() {
            let shown = ValueText {
                name: variable.variable.clone(),
                access: variable.access.clone(),
                doc: variable.doc.clone(),
                text: "no value yet".to_owned(),
            };
            let value_type = variable.value_type().map_err(|error| error.to_string())?;
            if value_type.bytes > MAX_BYTES {
                let text = format!("{}: shown in the windows of jde view", variable.type_name);
                changed.lock().insert(place, ValueText { text, ..shown });
                continue;
            }
            changed.lock().insert(place, shown.clone());
            let (sink, unit, choices) = (
                Arc::clone(&changed),
                variable.unit.clone(),
                variable.range.choices.clone(),
            );
            let watched = model.remote.watch(&variable.name, RATE, move |sample| {
                let text = text(&sample, &unit, &choices);
                sink.lock().insert(
                    place,
                    ValueText {
                        text,
                        ..shown.clone()
                    },
                );
            });
            subscriptions.push(watched.map_err(|error| error.to_string())?);
        }
        Ok(Self {
            schema: schema.to_owned(),
            changed,
            _subscriptions: subscriptions,
        })
    }

    /// Returns the values that changed since the last call.
    pub(crate) fn take_changed(&self) -> Vec<ValueText> {
        std::mem::take(&mut *self.changed.lock()).into_values().collect()
    }
}

fn text(sample: &Sample, unit: &str, choices: &[String]) -> String {
    let Some(value) = sample.value() else {
        return "no value".to_owned();
    };
    let value = value.into_only_field();
    let chosen = value.as_number().and_then(|number| choices.get(number as usize));
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
