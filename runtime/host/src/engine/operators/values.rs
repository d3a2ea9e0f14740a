//! Modulations and periods that operators set, and the values that they overwrote.

use std::sync::Arc;

use jde_abi::describe::Limits;
use jde_app::period;
use jde_board::value::{self, Value};
use jde_board::{Access, Refused, Stamp, Variable};
use jde_core::{Nanos, SchemaId};
use jde_records::event::OperatorAction;
use jde_records::turn::{Moment, Operation, Turn, TurnKind, WrittenPort};

use super::holds::{Actor, Overwritten, PreviousValue};
use super::{OPERATOR, Operators};

impl Operators {
    /// Changes a period, ns.
    pub(crate) fn retime(&self, by: &Actor, instance: SchemaId, period: Nanos) -> Result<(), String> {
        self.check_schema(instance)?;
        period::check(period).map_err(|error| error.to_string())?;
        let seconds = period as f64 / 1e9;
        let variable = self.variables.period(instance);
        self.overwrite(by, instance, variable, &seconds.to_ne_bytes())
            .map_err(|refused| refused.to_string())?;
        let action = OperatorAction::Period {
            schema: instance,
            period,
        };
        self.rules.report_operation(&by.name, action);
        Ok(())
    }

    /// Writes a modulation by name.
    pub(crate) fn modulate(
        &self,
        by: &Actor,
        instance: SchemaId,
        name: &str,
        new: &Value,
    ) -> Result<(), String> {
        self.check_schema(instance)?;
        let variable = self
            .board
            .get(&format!("{}.{name}", self.name(instance)))
            .map_err(|error| error.to_string())?;
        let declared = variable.describe();
        if declared.access != Access::Modulation {
            return Err(format!(
                "`{}.{name}` is not a modulation; only modulations can be set",
                self.name(instance)
            ));
        }
        let mut bytes = newest_bytes(&variable).unwrap_or_else(|| vec![0; declared.value_type.bytes]);
        let numbered = number_of(&declared.limits, new);
        let encoded = value::encode(&declared.value_type, numbered.as_ref().unwrap_or(new), &mut bytes);
        encoded.map_err(|error| error.to_string())?;
        if let Err(not_allowed) = declared.limits.check(&declared.value_type, &bytes)
            && !not_allowed.number.is_nan()
        {
            let words = not_allowed.words(&declared.unit);
            return Err(format!("`{}.{name}` {words}", self.name(instance)));
        }
        if Arc::ptr_eq(&variable, self.variables.period(instance)) {
            let seconds = bytes.try_into().map_or(f64::NAN, f64::from_ne_bytes);
            let period = period::from_seconds(seconds).map_err(|error| error.to_string())?;
            return self.retime(by, instance, period);
        }
        self.overwrite(by, instance, &variable, &bytes)
            .map_err(|refused| format!("`{}.{name}` stays as it is: {refused}", self.name(instance)))?;
        let action = OperatorAction::Modulate {
            schema: instance,
            variable: name.to_owned(),
            value: new.to_string(),
        };
        self.rules.report_operation(&by.name, action);
        Ok(())
    }

    /// Repeats an operator's write, in a replay.
    pub(crate) fn repeat_write(&self, variable: &Arc<Variable>, bytes: &[u8]) {
        // Only writes that succeeded were recorded.
        let _ = variable.put(OPERATOR, bytes, self.clock.now(), Nanos::MAX);
    }

    /// Writes as an operator, and keeps what was in force before.
    fn overwrite(
        &self,
        by: &Actor,
        owner: SchemaId,
        variable: &Arc<Variable>,
        bytes: &[u8],
    ) -> Result<(), Refused> {
        let mut held = self.holds();
        let now = newest(variable);
        self.write_recorded(owner, variable, OPERATOR, bytes)?;
        let place = held
            .values
            .iter()
            .position(|value| Arc::ptr_eq(&value.variable, variable));
        let earlier = place.map(|place| held.values.swap_remove(place));
        let overwritten = match (now, earlier) {
            // A father has written since, or nobody held it.
            (Some(previous), _) if previous.writer != OPERATOR => Some(Overwritten {
                owner,
                variable: Arc::clone(variable),
                previous,
                writes: Vec::new(),
            }),
            (_, earlier) => earlier,
        };
        held.values.extend(overwritten.map(|mut value| {
            value.writes.retain(|(actor, _)| actor != by);
            value.writes.push((by.clone(), bytes.to_vec()));
            value
        }));
        Ok(())
    }

    /// Ends what the actors selected by `whose` wrote at an instance. The newest write that is left is in force again,
    /// or else the value before all of them. A value that a father has written since remains. Returns whether a value
    /// changed.
    pub(super) fn restore_values(&self, instance: SchemaId, whose: impl Fn(&Actor) -> bool) -> bool {
        let mut held = self.holds();
        let mut any = false;
        for value in held.values.iter_mut().filter(|value| value.owner == instance) {
            let is_newest = value.writes.last().is_some_and(|(actor, _)| whose(actor));
            value.writes.retain(|(actor, _)| !whose(actor));
            if !is_newest || newest_writer(&value.variable) != OPERATOR {
                continue;
            }
            let (writer, bytes) = match value.writes.last() {
                Some((_, bytes)) => (OPERATOR, bytes),
                None => (value.previous.writer, &value.previous.bytes),
            };
            // It was in force before. If another build refuses it, the value stays.
            any |= self
                .write_recorded(instance, &value.variable, writer, bytes)
                .is_ok();
        }
        held.values.retain(|value| !value.writes.is_empty());
        any
    }

    /// Writes a value chosen by an operator, and records it as a turn.
    fn write_recorded(
        &self,
        owner: SchemaId,
        variable: &Arc<Variable>,
        writer: u32,
        bytes: &[u8],
    ) -> Result<(), Refused> {
        let time = self.clock.now();
        // The order is taken before the value is visible, so that every reader of the value has a later one.
        let order = self.journal.as_ref().map(|journal| journal.next());
        let put = variable.put(writer, bytes, time, Nanos::MAX);
        if let (Some(journal), Some(order)) = (&self.journal, order) {
            let ports = &self.application.instances[owner].schema.ports;
            let name = &variable.describe().name;
            let port = ports.iter().position(|port| port.name == *name);
            let port = port.map_or(WrittenPort::Period, |port| WrittenPort::Port(port as u64));
            let operation = match put {
                Ok(_) => Operation::Wrote(port),
                Err(_) => Operation::Refused,
            };
            let mut turn = Turn::new(TurnKind::Operated(operation), owner);
            turn.checked = Moment { order, time };
            turn.inputs.resize(1)[0] = put.as_ref().map_or(Turn::NO_VALUE, |sequence| *sequence as u32);
            journal.forward(&turn);
        }
        put.map(drop)
    }
}

fn newest(variable: &Arc<Variable>) -> Option<PreviousValue> {
    variable.reader("host").latch(0).map(|latched| PreviousValue {
        writer: latched.stamp.writer,
        bytes: latched.bytes.to_vec(),
    })
}

fn newest_bytes(variable: &Arc<Variable>) -> Option<Vec<u8>> {
    newest(variable).map(|newest| newest.bytes)
}

pub(super) fn newest_writer(variable: &Arc<Variable>) -> u32 {
    newest(variable).map_or(Stamp::NO_WRITER, |newest| newest.writer)
}

/// The number of a choice given by name; `None` if no choice has that name.
fn number_of(limits: &Limits, new: &Value) -> Option<Value> {
    match new {
        Value::Text(name) => limits.choice(name).map(|number| Value::UInt(number as u64)),
        Value::Bool(_)
        | Value::Int(_)
        | Value::UInt(_)
        | Value::Float(_)
        | Value::List(_)
        | Value::Map(_) => None,
    }
}
