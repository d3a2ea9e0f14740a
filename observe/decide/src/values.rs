//! Compares the actions of schemas with the recorded ones: every value that they exported, commanded or wrote
//! to a child. Values must be equal to the bit, except for what a [`Tolerance`] allows.

use std::collections::BTreeMap;

use jde_abi::describe::Type;
use jde_app::Application;
use jde_board::value::{self, Value};
use jde_core::{SchemaId, Table};
use jde_host::replay::{PairedWrite, WriteOutcome, format_value};
use serde::Serialize;

use crate::{ReplayError, Span};

/// The largest value that is shown in full, in bytes.
const SHOWN_IN_FULL: usize = 64;

/// The result of comparing values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values {
    /// The number of equal values.
    pub same: u64,
    /// The number of different, missing and new values.
    pub different: u64,
    /// The number of values that the recording does not contain, by variable.
    pub unknown: Vec<(String, u64)>,
    /// The ports with different values, with the first of each, in the order of their times.
    pub first: Vec<Deviation>,
}

/// A port that wrote other values than recorded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// The time of the first difference, in s since the application's start.
    pub time_s: f64,
    /// The schema.
    pub schema: String,
    /// The port of the schema.
    pub port: String,
    /// The variable.
    pub variable: String,
    /// The first field that differs, such as `linear.x`. Empty if it is the whole value.
    pub field: String,
    /// The recorded value of the field, as text.
    #[serde(rename = "then")]
    pub recorded: String,
    /// The present value of the field, as text.
    #[serde(rename = "now")]
    pub replayed: String,
    /// The number of the port's values that differ.
    #[serde(rename = "different")]
    pub count: u64,
}

/// The largest difference between two numbers that count as equal, by the types of the values that contain
/// them. It is absolute, in the unit of the number. It applies to floating-point numbers only. Without a
/// tolerance, values must be equal to the bit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tolerance {
    all: f64,
    types: BTreeMap<String, f64>,
}

/// One entry of a tolerance: `1e-9` for all types, or `geometry_msgs/msg/Twist=1e-6` for one.
#[derive(Clone, Debug, PartialEq)]
pub struct ToleranceEntry {
    type_name: Option<String>,
    tolerance: f64,
}

/// The comparison so far.
pub(super) struct ValueComparer<'a> {
    span: Span,
    tolerance: &'a Tolerance,
    names: Table<SchemaId, String>,
    same: u64,
    unknown: BTreeMap<String, u64>,
    /// The first deviations, by schema and port.
    first: BTreeMap<(SchemaId, String), Deviation>,
}

impl std::str::FromStr for ToleranceEntry {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (type_name, number) = match text.rsplit_once('=') {
            Some((name, number)) => (Some(name.trim().to_owned()), number),
            None => (None, text),
        };
        let tolerance: f64 = number.trim().parse().map_err(|_| {
            format!("`{number}` is not a number; write 1e-9, or for one type: geometry_msgs/msg/Twist=1e-9")
        })?;
        if !tolerance.is_finite() || tolerance < 0.0 {
            return Err(format!("a tolerance is 0 or more and finite, not {tolerance}"));
        }
        Ok(Self { type_name, tolerance })
    }
}

impl Tolerance {
    /// Combines entries for an application. The last entry for a type applies.
    ///
    /// # Errors
    /// [`ReplayError::Tolerance`] for a type that no value of the application has.
    pub fn new(parts: &[ToleranceEntry], application: &Application) -> Result<Self, ReplayError> {
        let mut tolerance = Self::default();
        for ToleranceEntry {
            type_name,
            tolerance: limit,
        } in parts
        {
            let Some(name) = type_name else {
                tolerance.all = *limit;
                continue;
            };
            let ports = application
                .instances
                .iter()
                .flat_map(|instance| &instance.schema.ports);
            let types = ports.map(|port| port.value_type.name.as_str());
            if !types.clone().any(|known| known == name) {
                return Err(ReplayError::Tolerance {
                    name: name.clone(),
                    nearest: jde_nearest::nearest(name, types).map(str::to_owned),
                });
            }
            tolerance.types.insert(name.clone(), *limit);
        }
        Ok(tolerance)
    }

    fn of(&self, value_type: &Type) -> f64 {
        self.types.get(&value_type.name).copied().unwrap_or(self.all)
    }
}

impl<'a> ValueComparer<'a> {
    pub(super) fn new(span: Span, tolerance: &'a Tolerance, application: &Application) -> Self {
        let instances = application.instances.iter();
        Self {
            span,
            tolerance,
            names: instances.map(|instance| instance.name.clone()).collect(),
            same: 0,
            unknown: BTreeMap::new(),
            first: BTreeMap::new(),
        }
    }

    pub(super) fn add(&mut self, write: &PairedWrite) {
        if !(self.span.from..=self.span.to).contains(&write.time) {
            return;
        }
        if write.recorded == WriteOutcome::Unknown && matches!(write.replayed, WriteOutcome::Wrote(_)) {
            *self.unknown.entry(write.variable.clone()).or_default() += 1;
            return;
        }
        let Some((field, then, now)) = difference(write, self.tolerance.of(&write.value_type)) else {
            self.same += 1;
            return;
        };
        let first = self.first.entry((write.schema, write.port.clone()));
        let deviation = first.or_insert_with(|| Deviation {
            time_s: write.time as f64 / 1e9,
            schema: self.names[write.schema].clone(),
            port: write.port.clone(),
            variable: write.variable.clone(),
            field,
            recorded: then,
            replayed: now,
            count: 0,
        });
        deviation.count += 1;
    }

    pub(super) fn finish(self) -> Values {
        let mut first: Vec<_> = self.first.into_values().collect();
        first.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        Values {
            same: self.same,
            different: first.iter().map(|deviation| deviation.count).sum(),
            unknown: self.unknown.into_iter().collect(),
            first,
        }
    }
}

/// Returns the field in which two actions differ, with its recorded and its present value. `None` if they are
/// equal.
fn difference(write: &PairedWrite, tolerance: f64) -> Option<(String, String, String)> {
    let (WriteOutcome::Wrote(then), WriteOutcome::Wrote(now)) = (&write.recorded, &write.replayed) else {
        let text = |outcome: &WriteOutcome| describe(outcome, &write.value_type);
        return (write.recorded != write.replayed)
            .then(|| (String::new(), text(&write.recorded), text(&write.replayed)));
    };
    if then == now {
        return None;
    }
    // The bytes between fields have no meaning.
    let (then, now) = (
        value::decode(&write.value_type, then),
        value::decode(&write.value_type, now),
    );
    let (field, then, now) = first_difference(&then, &now, tolerance, &mut String::new())?;
    Some((field, then.to_string(), now.to_string()))
}

/// Returns the first place where two values differ by more than allowed, with both values.
fn first_difference(
    then: &Value,
    now: &Value,
    tolerance: f64,
    path: &mut String,
) -> Option<(String, Value, Value)> {
    let whole_value = |path: &String| Some((path.clone(), then.clone(), now.clone()));
    let length = path.len();
    let mut within = |name: &str, then: &Value, now: &Value| {
        path.push_str(name);
        let found = first_difference(then, now, tolerance, path);
        path.truncate(length);
        found
    };
    match (then, now) {
        (Value::Float(a), Value::Float(b)) => {
            let is_equal = a.to_bits() == b.to_bits() || tolerance > 0.0 && (a - b).abs() <= tolerance;
            if is_equal { None } else { whole_value(path) }
        }
        (Value::Map(fields), Value::Map(others)) => {
            let mut pairs = fields.iter().zip(others);
            pairs.find_map(|((name, then), (_, now))| {
                let dot = if length == 0 { "" } else { "." };
                within(&format!("{dot}{name}"), then, now)
            })
        }
        (Value::List(elements), Value::List(others)) if elements.len() == others.len() => {
            let mut pairs = elements.iter().zip(others).enumerate();
            pairs.find_map(|(index, (then, now))| within(&format!("[{index}]"), then, now))
        }
        (Value::List(elements), Value::List(others)) => {
            let length = |list: &[Value]| Value::UInt(list.len() as u64);
            Some((format!("the length of {path}"), length(elements), length(others)))
        }
        _ if then == now => None,
        _ => whole_value(path),
    }
}

fn describe(outcome: &WriteOutcome, value_type: &Type) -> String {
    match outcome {
        WriteOutcome::Nothing => "nothing".to_owned(),
        WriteOutcome::Retracted => "retracted its value".to_owned(),
        WriteOutcome::Unknown => "a value that is not in the recording".to_owned(),
        WriteOutcome::Wrote(bytes) if bytes.len() <= SHOWN_IN_FULL => format_value(value_type, bytes),
        WriteOutcome::Wrote(_) => format!("a {}", value_type.name),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use jde_types::{Twist, Value as _};

    use super::*;

    fn paired(then: WriteOutcome, now: WriteOutcome) -> PairedWrite {
        PairedWrite {
            time: 7,
            schema: SchemaId(0),
            port: "base".to_owned(),
            variable: "robot.velocity".to_owned(),
            value_type: Arc::new(Twist::describe()),
            recorded: then,
            replayed: now,
        }
    }

    fn speed(x: f64) -> WriteOutcome {
        let mut twist = Twist::ZERO;
        twist.linear.x = x;
        WriteOutcome::Wrote(twist.as_bytes().to_vec())
    }

    #[test]
    fn values_must_be_equal_to_the_bit_without_a_tolerance() {
        let rounded = paired(speed(0.3), speed(0.1 + 0.2));
        assert_eq!(difference(&paired(speed(0.3), speed(0.3)), 0.0), None);
        let (field, then, now) = difference(&rounded, 0.0).unwrap();
        assert_eq!(
            (field.as_str(), then.as_str(), now.as_str()),
            ("linear.x", "0.3", "0.30000000000000004")
        );
        assert_eq!(difference(&rounded, 1e-9), None);
        let opposite = paired(speed(0.3), speed(-0.3));
        assert!(difference(&opposite, 1e-9).is_some());
        let nan = paired(speed(f64::NAN), speed(f64::NAN));
        assert_eq!(difference(&nan, 0.0), None);
        assert!(difference(&paired(speed(f64::NAN), speed(0.0)), 1e9).is_some());
    }

    #[test]
    fn a_missing_or_retracted_value_differs_from_every_value() {
        for (then, now) in [
            (WriteOutcome::Nothing, speed(0.0)),
            (speed(0.0), WriteOutcome::Nothing),
            (speed(0.0), WriteOutcome::Retracted),
            (WriteOutcome::Retracted, WriteOutcome::Nothing),
            (WriteOutcome::Unknown, WriteOutcome::Nothing),
        ] {
            assert!(
                difference(&paired(then.clone(), now.clone()), 1e9).is_some(),
                "{then:?} {now:?}"
            );
        }
        assert_eq!(
            difference(&paired(WriteOutcome::Retracted, WriteOutcome::Retracted), 0.0),
            None
        );
    }

    #[test]
    fn a_tolerance_is_parsed_or_refused() {
        let parse = |text: &str| text.parse::<ToleranceEntry>();
        assert_eq!(
            parse("geometry_msgs/msg/Twist=1e-6"),
            Ok(ToleranceEntry {
                type_name: Some("geometry_msgs/msg/Twist".to_owned()),
                tolerance: 1e-6
            })
        );
        assert_eq!(
            parse("0.5"),
            Ok(ToleranceEntry {
                type_name: None,
                tolerance: 0.5
            })
        );
        for wrong in ["", "x", "-1", "nan", "inf", "geometry_msgs/msg/Twist", "a=b"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
