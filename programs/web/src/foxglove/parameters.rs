//! Modulations as parameters, under the names that `jde set` takes, with values of their own types. One set of subscriptions
//! serves all clients, for as long as any has asked for parameters.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jde_board::value::Value;
use jde_link::message::{Action, VariableInfo};
use jde_link::value::to_json;
use jde_link::{Error, Rate, Remote, Sample, Subscription};
use parking_lot::Mutex;
use serde_json::{Value as Json, json};
use tokio::sync::watch;

use super::outbox::Outbox;

/// How often changes are looked for. A father may modulate at every iteration.
const RATE: Rate = Rate::Hz(5);
/// The largest modulation that is a parameter, bytes. Larger ones are channels only.
const MAX_BYTES: usize = 4096;

/// The parameters of an application.
pub(super) struct Parameters {
    modulations: BTreeMap<String, VariableInfo>,
    shared: Arc<Shared>,
    /// How many have a value, or are known to have none.
    known: watch::Receiver<usize>,
    _subscriptions: Vec<Subscription>,
}

#[derive(Default)]
struct Shared {
    values: Mutex<BTreeMap<String, Known>>,
    clients: Mutex<Vec<(Arc<Outbox>, BTreeSet<String>)>>,
}

/// What is known of a parameter.
struct Known {
    sequence: u64,
    /// As clients get it.
    parameter: Option<Json>,
}

impl Parameters {
    /// Subscribes to the modulations. Waits for the link.
    ///
    /// # Errors
    /// There is no connection.
    pub(super) fn open(remote: &Remote, variables: &[VariableInfo]) -> Result<Self, Error> {
        let is_small = |variable: &VariableInfo| {
            variable
                .value_type()
                .is_ok_and(|value_type| value_type.bytes <= MAX_BYTES)
        };
        let modulations: BTreeMap<_, _> = variables
            .iter()
            .filter(|variable| variable.access == "modulation" && is_small(variable))
            .map(|variable| (variable.name.clone(), variable.clone()))
            .collect();
        let shared = Arc::new(Shared::default());
        let (count, known) = watch::channel(0);
        let count = Arc::new(count);
        let mut subscriptions = Vec::new();
        for name in modulations.keys() {
            let (shared, count, known) = (Arc::clone(&shared), Arc::clone(&count), name.clone());
            subscriptions.push(remote.watch(name, RATE, move |sample| {
                shared.update(&known, &sample);
                count.send_replace(shared.values.lock().len());
            })?);
        }
        Ok(Self {
            modulations,
            shared,
            known,
            _subscriptions: subscriptions,
        })
    }

    /// Waits until all values have arrived once.
    pub(super) async fn arrived(&self) {
        let all = self.modulations.len();
        // The sender lives as long as the subscriptions.
        let _ = self.known.clone().wait_for(|known| *known >= all).await;
    }

    /// Returns the parameters of these names, or all.
    pub(super) fn get(&self, names: &[String]) -> Vec<Json> {
        let values = self.shared.values.lock();
        if names.is_empty() {
            return values
                .values()
                .filter_map(|known| known.parameter.clone())
                .collect();
        }
        let names: BTreeSet<&String> = names.iter().collect();
        let of = |name: &String| values.get(name).and_then(|known| known.parameter.clone());
        names.into_iter().filter_map(of).collect()
    }

    /// Returns the action that sets a parameter.
    ///
    /// # Errors
    /// There is none of this name, or a parameter cannot have the value, in words.
    pub(super) fn action(&self, name: &str, value: Json) -> Result<Action, String> {
        let known = self.modulations.get(name);
        let VariableInfo { owner, variable, .. } =
            known.ok_or_else(|| format!("there is no modulation `{name}`"))?;
        let schema = owner.clone();
        if value.is_null() {
            return Err(format!("{name} cannot be removed"));
        }
        if variable == "period" {
            let period_s = value
                .as_f64()
                .ok_or_else(|| format!("{name} is a number of seconds"))?;
            return Ok(Action::Period { schema, period_s });
        }
        let variable = variable.clone();
        Ok(Action::Modulate {
            schema,
            variable,
            value,
        })
    }

    /// Takes a value that was asked for.
    pub(super) fn update(&self, name: &str, sample: &Sample) {
        self.shared.update(name, sample);
    }

    /// Lets a client know changes of these parameters, or of all.
    pub(super) fn watch(&self, client: &Arc<Outbox>, names: Vec<String>) {
        let names: BTreeSet<String> = match names.is_empty() {
            true => self.modulations.keys().cloned().collect(),
            false => names
                .into_iter()
                .filter(|name| self.modulations.contains_key(name))
                .collect(),
        };
        let mut clients = self.shared.clients.lock();
        match clients.iter_mut().find(|(other, _)| Arc::ptr_eq(other, client)) {
            Some((_, known)) => known.extend(names),
            None => clients.push((Arc::clone(client), names)),
        }
    }

    /// Ends that.
    pub(super) fn unwatch(&self, client: &Arc<Outbox>, names: &[String]) {
        let names: BTreeSet<&String> = names.iter().collect();
        let mut clients = self.shared.clients.lock();
        for (_, known) in clients.iter_mut().filter(|(other, _)| Arc::ptr_eq(other, client)) {
            known.retain(|name| !names.is_empty() && !names.contains(name));
        }
        clients.retain(|(_, known)| !known.is_empty());
    }
}

impl Shared {
    fn update(&self, name: &str, sample: &Sample) {
        let value = sample.value().map(Value::into_only_field);
        let parameter = value.map(|value| parameter(name, &value));
        let sequence = sample.sequence;
        let mut values = self.values.lock();
        let before = values.get(name);
        // One that was asked for may be newer than the next of a subscription.
        let is_new = before.is_none_or(|before| before.sequence < sequence && before.parameter != parameter);
        if !is_new {
            return;
        }
        if let (Some(_), Some(parameter)) = (before, &parameter) {
            for (client, names) in &*self.clients.lock() {
                if names.contains(name) {
                    client.parameter(name, parameter);
                }
            }
        }
        values.insert(name.to_owned(), Known { sequence, parameter });
    }
}

/// Returns a parameter as clients get it. Whole numbers of a type with fractions say so.
fn parameter(name: &str, value: &Value) -> Json {
    let is_float = |value: &Value| matches!(value, Value::Float(number) if number.is_finite());
    let hint = match value {
        Value::List(list) if !list.is_empty() && list.iter().all(is_float) => Some("float64_array"),
        one if is_float(one) => Some("float64"),
        Value::Bool(_)
        | Value::Int(_)
        | Value::UInt(_)
        | Value::Float(_)
        | Value::Text(_)
        | Value::List(_)
        | Value::Map(_) => None,
    };
    let mut parameter = json!({ "name": name, "value": to_json(value) });
    if let Some(hint) = hint {
        parameter["type"] = json!(hint);
    }
    parameter
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_keep_their_types() {
        let of = |value: Value| parameter("goon.fast", &value);
        assert_eq!(
            of(Value::Float(1.0)),
            json!({ "name": "goon.fast", "value": 1.0, "type": "float64" })
        );
        assert_eq!(of(Value::UInt(1)), json!({ "name": "goon.fast", "value": 1 }));
        assert_eq!(
            of(Value::Float(f64::NAN)),
            json!({ "name": "goon.fast", "value": "nan" })
        );
        let list = Value::List(vec![Value::Float(1.0), Value::Float(2.5)]);
        assert_eq!(of(list)["type"], "float64_array");
        let map = Value::Map(vec![("on".to_owned(), Value::Bool(true))]);
        assert_eq!(of(map)["value"], json!({ "on": true }));
    }
}
