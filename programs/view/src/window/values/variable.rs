//! The data received of a variable: its newest value, decoded once, and the rate of its values.

use std::sync::Arc;

use jde_abi::describe::Type;
use jde_board::value::Value;
use jde_link::Sample;
use jde_link::message::VariableInfo;

/// Minimum time over which a rate is measured, in ns.
const RATE_WINDOW: u64 = 1_000_000_000;

/// The data received of a variable.
pub(super) struct VariableState {
    value_type: Option<Arc<Type>>,
    sample: Option<Arc<Sample>>,
    value: Option<Value>,
    /// Sequence number and time, in ns, at the beginning of the current measurement of the rate.
    begun: Option<(u64, u64)>,
    rate: Option<f64>,
}

impl VariableState {
    /// The state before any sample. The type is known from the declaration.
    pub(super) fn new(info: &VariableInfo) -> Self {
        Self {
            value_type: info.value_type().ok().map(Arc::new),
            sample: None,
            value: None,
            begun: None,
            rate: None,
        }
    }

    /// Takes a sample. The same sample again costs nothing.
    pub(super) fn take(&mut self, sample: &Arc<Sample>) {
        if self.sample.as_ref().is_some_and(|old| Arc::ptr_eq(old, sample)) {
            return;
        }
        match self.begun {
            Some((sequence, time)) if sample.sequence >= sequence && sample.time >= time => {
                let passed = sample.time - time;
                if passed >= RATE_WINDOW {
                    self.rate = Some((sample.sequence - sequence) as f64 * 1e9 / passed as f64);
                    self.begun = Some((sample.sequence, sample.time));
                }
            }
            // The first sample, or a recording jumped back.
            Some(_) | None => self.begun = Some((sample.sequence, sample.time)),
        }
        self.value = sample.value();
        self.sample = Some(Arc::clone(sample));
    }

    pub(super) fn value_type(&self) -> Option<&Type> {
        self.value_type.as_deref()
    }

    /// Whether a sample arrived, with a value or without.
    pub(super) fn is_known(&self) -> bool {
        self.sample.is_some()
    }

    /// The sequence number of the newest sample, 0 before the first.
    pub(super) fn sequence(&self) -> u64 {
        self.sample.as_ref().map_or(0, |sample| sample.sequence)
    }

    /// A part of the value, by its names from the outermost in. A structure with a single field is replaced
    /// by that field.
    pub(super) fn part(&self, names: &[String]) -> Option<&Value> {
        let mut value = self.value.as_ref()?;
        for name in names {
            let Value::Map(fields) = value else { return None };
            value = fields
                .iter()
                .find(|(field, _)| field == name)
                .map(|(_, value)| value)?;
        }
        while let Value::Map(fields) = value {
            match fields.as_slice() {
                [(_, only)] => value = only,
                _ => break,
            }
        }
        Some(value)
    }

    /// The age of the value at a time `now` in s, as text: "0.2 s". Empty without a value.
    pub(super) fn age(&self, now: f64) -> String {
        let Some(sample) = self.sample.as_ref().filter(|sample| sample.bytes.is_some()) else {
            return String::new();
        };
        match (now - sample.time as f64 / 1e9).max(0.0) {
            age if age < 10.0 => format!("{age:.1} s"),
            age if age < 600.0 => format!("{age:.0} s"),
            age => format!("{:.0} min", age / 60.0),
        }
    }

    /// The rate of the variable, as text: "13.3 Hz".
    pub(super) fn rate(&self) -> String {
        self.rate.map(|rate| format!("{rate:.1} Hz")).unwrap_or_default()
    }

    pub(super) fn writer(&self) -> &str {
        self.sample.as_ref().map_or("", |sample| sample.writer.as_str())
    }
}
