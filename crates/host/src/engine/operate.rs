//! What operators and the end of the application do from outside the hierarchy (R14).

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, MutexGuard, PoisonError};

use jde_abi::describe::Limits;
use jde_app::period;
use jde_board::value::{self, Value};
use jde_board::{Refused as NotTaken, Stamp, Variable};
use jde_core::{Effect, Hierarchy, Nanos, Operator, Requester, SchemaId};
use jde_records::event::OperatorAction;
use jde_records::snapshot::{Hold, HoldKind};
use jde_records::turn::{Moment, Turn};

use super::Engine;

/// The writer number of operators.
pub(crate) const OPERATOR: u32 = u32::MAX - 1;

/// The actions of operators that were not released yet.
#[derive(Default)]
pub(super) struct OperatorHolds {
    /// The operator that last played, stopped or forced each schema.
    operators: BTreeMap<usize, String>,
    /// The operator that last stopped everything.
    pub(super) stop_all_operator: String,
    /// Schemas whose instances were ended by unloading.
    pub(super) unloaded: BTreeSet<usize>,
    values: Vec<Overwritten>,
}

/// A modulation or period that an operator overwrote.
struct Overwritten {
    owner: usize,
    variable: Arc<Variable>,
    previous: PreviousValue,
    by: String,
}

struct PreviousValue {
    writer: u32,
    bytes: Vec<u8>,
}

impl OperatorHolds {
    /// Records the operator that plays, stops or forces a schema.
    pub(super) fn set_hold(&mut self, instance: usize, by: &str) {
        self.operators.insert(instance, by.to_owned());
    }

    /// Whether this operator was the last to play, stop or force the schema.
    fn is_held_by(&self, instance: usize, by: &str) -> bool {
        self.operators.get(&instance).is_some_and(|hand| hand == by)
    }

    /// Forgets the hold on a schema.
    pub(super) fn remove_hold(&mut self, instance: usize) {
        self.operators.remove(&instance);
        self.unloaded.remove(&instance);
    }
}

impl Engine {
    /// Plays, stops, forces or releases a schema.
    pub(crate) fn operate(&self, by: &str, operator: Operator) -> Result<(), String> {
        let (done, moment) = self
            .rules
            .transact_recorded(|hierarchy, now, out| self.apply_operation(hierarchy, now, out, by, operator));
        self.rules.record_turn(
            Turn::OPERATED,
            operated_schema(operator),
            operator_code(operator),
            moment,
        );
        done?;
        if let Operator::Release(id) = operator {
            self.restore_values(id.index(), |_| true);
        }
        self.rules
            .report_operation(by, OperatorAction::Hierarchy(operator));
        Ok(())
    }

    /// Repeats an operator's action on the hierarchy, in a replay. An action that was refused is refused
    /// again.
    pub(crate) fn repeat_operation(&self, operator: Operator) {
        // The original operator was informed of a refusal.
        let _: Result<(), String> = self
            .rules
            .transact(|hierarchy, now, out| self.apply_operation(hierarchy, now, out, "", operator));
    }

    /// Repeats the release of one operator's hold, in a replay.
    pub(crate) fn repeat_undo(&self, instance: usize) {
        // The original operator was informed of a refusal.
        let _ = self
            .rules
            .transact(|hierarchy, now, out| self.undo(hierarchy, now, out, instance));
    }

    /// Undoes what operators did to a schema individually.
    pub(super) fn undo(
        &self,
        hierarchy: &mut Hierarchy,
        now: Nanos,
        out: &mut Vec<Effect>,
        instance: usize,
    ) -> Result<(), String> {
        hierarchy
            .let_go(now, super::schema(instance), out)
            .map_err(|refused| refused.to_string())?;
        self.holds().remove_hold(instance);
        Ok(())
    }

    /// Applies an operator's action to the hierarchy, and records the hold.
    pub(super) fn apply_operation(
        &self,
        hierarchy: &mut Hierarchy,
        now: Nanos,
        out: &mut Vec<Effect>,
        by: &str,
        operator: Operator,
    ) -> Result<(), String> {
        let instance = operated_schema(operator);
        if matches!(operator, Operator::Play(_)) && self.is_unloaded(instance) {
            return Err(format!("`{}` is unloaded; load it first", self.name(instance)));
        }
        hierarchy
            .operator(now, operator, out)
            .map_err(|refused| refused.to_string())?;
        let mut held = self.holds();
        match operator {
            Operator::Play(_) | Operator::Stop(_) | Operator::Force(_) => held.set_hold(instance, by),
            Operator::Release(_) => held.remove_hold(instance),
        }
        Ok(())
    }

    /// Repeats an operator's write, in a replay.
    pub(crate) fn repeat_write(&self, variable: &Arc<Variable>, bytes: &[u8]) {
        // Only writes that succeeded were recorded.
        let _ = variable.put(OPERATOR, bytes, self.clock.now(), Nanos::MAX);
    }

    /// Undoes what one operator did to a schema.
    pub(crate) fn release_own(&self, by: &str, instance: usize) -> Result<(), String> {
        self.check_schema(instance)?;
        let release = Operator::Release(super::schema(instance));
        let (held, moment) = self.rules.transact_recorded(|hierarchy, now, out| {
            if !self.holds().is_held_by(instance, by) {
                return Ok(false);
            }
            self.undo(hierarchy, now, out, instance).map(|()| true)
        });
        let way = if held == Ok(false) { 0 } else { Turn::UNDONE };
        self.rules.record_turn(Turn::OPERATED, instance, way, moment);
        let held = held?;
        let given_back = self.restore_values(instance, |writer| writer == by);
        if held || given_back {
            self.rules
                .report_operation(by, OperatorAction::Hierarchy(release));
        }
        Ok(())
    }

    /// Changes a period, ns.
    pub(crate) fn retime(&self, by: &str, instance: usize, period: Nanos) -> Result<(), String> {
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
        self.rules.report_operation(by, action);
        Ok(())
    }

    /// Writes a modulation by name.
    pub(crate) fn modulate(&self, by: &str, instance: usize, name: &str, new: &Value) -> Result<(), String> {
        self.check_schema(instance)?;
        let variable = self
            .board
            .get(&format!("{}.{name}", self.name(instance)))
            .map_err(|error| error.to_string())?;
        let declared = variable.describe();
        if declared.access != jde_board::Access::Modulation {
            return Err(format!(
                "`{}.{name}` is no modulation; only modulations can be set",
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
        self.rules.report_operation(by, action);
        Ok(())
    }

    /// The newest published period, ns; it counts from the next iteration. `None` if it is not a valid
    /// period.
    pub(crate) fn period_of(&self, instance: usize) -> Option<Nanos> {
        let bytes = newest_bytes(self.variables.period(instance))?;
        let seconds = f64::from_ne_bytes(bytes.try_into().ok()?);
        // An invalid period from a father leaves the period as it was.
        period::from_seconds(seconds).ok()
    }

    /// The hold of an operator on a schema, and the operator.
    pub(super) fn hold_view(&self, hierarchy: &Hierarchy, instance: usize) -> Option<Hold> {
        let held = self.holds();
        if let Some(kind) = hold_kind(hierarchy, super::schema(instance)) {
            let unloaded = held.unloaded.contains(&instance);
            let kind = if unloaded { HoldKind::Unloaded } else { kind };
            let with_everything = hierarchy.is_stopped_with_all(super::schema(instance));
            // The operator is recorded in the transaction that causes the hold.
            let by = if with_everything && !unloaded {
                held.stop_all_operator.clone()
            } else {
                held.operators.get(&instance).cloned().unwrap_or_default()
            };
            return Some(Hold {
                kind,
                with_everything,
                by,
            });
        }
        let value = held
            .values
            .iter()
            .find(|value| value.owner == instance && newest_writer(&value.variable) == OPERATOR)?;
        let retimed = Arc::ptr_eq(&value.variable, self.variables.period(instance));
        Some(Hold {
            kind: if retimed {
                HoldKind::Retimed
            } else {
                HoldKind::Modulated
            },
            with_everything: false,
            by: value.by.clone(),
        })
    }

    /// Writes as an operator, and keeps the previous value.
    fn overwrite(
        &self,
        by: &str,
        owner: usize,
        variable: &Arc<Variable>,
        bytes: &[u8],
    ) -> Result<(), NotTaken> {
        let mut held = self.holds();
        let now = newest(variable);
        self.write_recorded(owner, variable, OPERATOR, bytes)?;
        let place = held
            .values
            .iter()
            .position(|value| Arc::ptr_eq(&value.variable, variable));
        let earlier = place.map(|place| held.values.swap_remove(place));
        // An operator that overwrites another takes over the hold. The value to restore is the newest one
        // that no operator wrote.
        let before = match (now, earlier) {
            (Some(now), _) if now.writer != OPERATOR => Some(now),
            (_, earlier) => earlier.map(|earlier| earlier.previous),
        };
        held.values.extend(before.map(|before| Overwritten {
            owner,
            variable: Arc::clone(variable),
            previous: before,
            by: by.to_owned(),
        }));
        Ok(())
    }

    /// Restores what the operators selected by `whose` overwrote at an instance. A value that a father has
    /// written since remains. Returns whether anything was restored.
    pub(super) fn restore_values(&self, instance: usize, whose: impl Fn(&str) -> bool) -> bool {
        let mut held = self.holds();
        let mut any = false;
        let theirs = |value: &mut Overwritten| value.owner == instance && whose(&value.by);
        for value in held.values.extract_if(.., theirs) {
            if newest_writer(&value.variable) == OPERATOR {
                let PreviousValue { writer, bytes } = &value.previous;
                let put = self.write_recorded(instance, &value.variable, *writer, bytes);
                put.expect("it was in force before");
                any = true;
            }
        }
        any
    }

    /// Writes a value chosen by an operator, and records it as a turn.
    fn write_recorded(
        &self,
        owner: usize,
        variable: &Arc<Variable>,
        writer: u32,
        bytes: &[u8],
    ) -> Result<(), NotTaken> {
        let time = self.clock.now();
        // The order is taken before the value is visible, so that every reader of the value has a later one.
        let order = self.journal.as_ref().map(|journal| journal.next());
        let put = variable.put(writer, bytes, time, Nanos::MAX);
        if let (Some(journal), Some(order)) = (&self.journal, order) {
            let ports = &self.application.instances[owner].schema.ports;
            let name = &variable.describe().name;
            let port = ports.iter().position(|port| port.name == *name);
            let mut turn = Turn {
                way: if put.is_ok() { Turn::WROTE } else { 0 },
                detail: port.map_or(Turn::PERIOD, |port| port as u64),
                checked: Moment { order, time },
                ..Turn::new(Turn::OPERATED, owner)
            };
            turn.inputs.resize(1)[0] = put.as_ref().map_or(Turn::NO_VALUE, |sequence| *sequence as u32);
            journal.forward(&turn);
        }
        put.map(drop)
    }

    pub(super) fn holds(&self) -> MutexGuard<'_, OperatorHolds> {
        self.holds.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn check_schema(&self, instance: usize) -> Result<(), String> {
        let count = self.application.instances.len();
        if instance < count {
            return Ok(());
        }
        Err(format!(
            "there is no schema number {instance}; the application has {count}"
        ))
    }
}

/// An operator's action, as turns encode it.
fn operator_code(operator: Operator) -> u8 {
    match operator {
        Operator::Play(_) => Turn::PLAYED,
        Operator::Stop(_) => Turn::STOPPED,
        Operator::Force(_) => Turn::FORCED,
        Operator::Release(_) => Turn::RELEASED,
    }
}

/// The schema that an operator acted on.
fn operated_schema(operator: Operator) -> usize {
    match operator {
        Operator::Play(id) | Operator::Stop(id) | Operator::Force(id) | Operator::Release(id) => id.index(),
    }
}

/// What an operator holds a schema to in the hierarchy.
fn hold_kind(hierarchy: &Hierarchy, id: SchemaId) -> Option<HoldKind> {
    let forced = hierarchy.group_of(id).and_then(|group| hierarchy.forced(group)) == Some(id);
    if hierarchy.is_stopped(id) {
        Some(HoldKind::Stopped)
    } else if forced {
        Some(HoldKind::Forced)
    } else if hierarchy.requesters(id).contains(&Requester::Operator) {
        Some(HoldKind::Played)
    } else {
        None
    }
}

fn newest(variable: &Arc<Variable>) -> Option<PreviousValue> {
    variable.reader("host").latch().map(|latched| PreviousValue {
        writer: latched.stamp.writer,
        bytes: latched.bytes.to_vec(),
    })
}

fn newest_bytes(variable: &Arc<Variable>) -> Option<Vec<u8>> {
    newest(variable).map(|newest| newest.bytes)
}

fn newest_writer(variable: &Arc<Variable>) -> u32 {
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
