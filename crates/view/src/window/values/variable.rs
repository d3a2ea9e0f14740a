//! What was seen of a variable: its newest value taken apart once, and how often it comes.

use std::sync::Arc;

use jde_abi::describe::Type;
use jde_board::value::Value;
use jde_link::Sample;
use jde_link::message::VariableInfo;

/// Rates are measured over at least so long, ns.
const WINDOW: u64 = 1_000_000_000;

/// What was seen of a variable.
pub(super) struct VariableState {
    value_type: Option<Arc<Type>>,
    sample: Option<Arc<Sample>>,
    value: Option<Value>,
    /// Sequence and time at the beginning of the window in which the rate is measured.
    begun: Option<(u64, u64)>,
    rate: Option<f64>,
}

impl VariableState {
    /// Nothing yet.
    pub(super) fn new(info: &VariableInfo) -> Self {
        Self {
            value_type: info.value_type().ok().map(Arc::new),
            sample: None,
            value: None,
            begun: None,
            rate: None,
        }
    }

    /// A sample; the same again costs nothing.
    pub(super) fn take(&mut self, sample: &Arc<Sample>) {
        if self.sample.as_ref().is_some_and(|old| Arc::ptr_eq(old, sample)) {
            return;
        }
        match self.begun {
            Some((sequence, time)) if sample.sequence >= sequence && sample.time >= time => {
                let passed = sample.time - time;
                if passed >= WINDOW {
                    self.rate = Some((sample.sequence - sequence) as f64 * 1e9 / passed as f64);
                    self.begun = Some((sample.sequence, sample.time));
                }
            }
            // The first one; or a recording went back.
            Some(_) | None => self.begun = Some((sample.sequence, sample.time)),
        }
        self.value = sample.value();
        self.sample = Some(Arc::clone(sample));
    }

    pub(super) fn value_type(&self) -> Option<&Type> {
        self.value_type.as_deref()
    }

    /// Whether anything came: a value, or that there is none.
    pub(super) fn is_known(&self) -> bool {
        self.sample.is_some()
    }

    /// Counts its values.
    pub(super) fn sequence(&self) -> u64 {
        self.sample.as_ref().map_or(0, |sample| sample.sequence)
    }

    /// A part of its value by its names from the outside in; a structure of one number is that number.
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

    /// "0.2 s", at so many seconds of the application.
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

    /// "13.3 Hz".
    pub(super) fn rate(&self) -> String {
        self.rate.map(|rate| format!("{rate:.1} Hz")).unwrap_or_default()
    }

    pub(super) fn writer(&self) -> &str {
        self.sample.as_ref().map_or("", |sample| sample.writer.as_str())
    }
}
