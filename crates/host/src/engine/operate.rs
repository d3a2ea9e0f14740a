//! What operators and the end of the application do from outside the hierarchy (R14).

use std::sync::{Arc, MutexGuard, PoisonError};

use jde_board::value::{self, Value};
use jde_board::{Refused, Stamp, Variable};
use jde_core::{Nanos, Operator};

use super::{Engine, Rules, Signal};
use crate::event::OperatorAction;

/// Shortest period anyone may set: what the timers of a machine can keep.
const SHORTEST: Nanos = 100_000;

/// The writer number of operators.
pub(crate) const OPERATOR: u32 = u32::MAX - 1;

/// Modulations and periods that operators wrote over: owner, variable, and what was there before.
#[derive(Default)]
pub(super) struct Held {
    values: Vec<(usize, Arc<Variable>, Before)>,
}

struct Before {
    writer: u32,
    bytes: Vec<u8>,
}

impl Engine {
    /// Plays, stops, forces or releases a schema.
    pub(crate) fn operate(&self, operator: Operator) -> Result<(), String> {
        self.transact(|hierarchy, now, out| hierarchy.operator(now, operator, out))
            .map_err(|error| error.to_string())?;
        if let Operator::Release(id) = operator {
            self.give_back(id.index());
        }
        self.operated(&mut self.lock(), OperatorAction::Hierarchy(operator));
        Ok(())
    }

    /// Changes a period.
    pub(crate) fn retime(&self, instance: usize, period: Nanos) -> Result<(), String> {
        self.known(instance)?;
        if period < SHORTEST {
            return Err(format!(
                "a period of {period} ns is too short; give at least 0.1 ms"
            ));
        }
        let seconds = period as f64 / 1e9;
        let variable = self.variables.period(instance);
        self.overwrite(instance, variable, &seconds.to_ne_bytes())
            .map_err(|refused| refused.to_string())?;
        self.operated(
            &mut self.lock(),
            OperatorAction::Period {
                schema: instance,
                period,
            },
        );
        Ok(())
    }

    /// Writes a modulation by name.
    pub(crate) fn modulate(&self, instance: usize, name: &str, new: &Value) -> Result<(), String> {
        self.known(instance)?;
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
        value::encode(&declared.value_type, new, &mut bytes).map_err(|error| error.to_string())?;
        self.overwrite(instance, &variable, &bytes)
            .map_err(|refused| format!("`{}.{name}` stays as it is: {refused}", self.name(instance)))?;
        let action = OperatorAction::Modulate {
            schema: instance,
            variable: name.to_owned(),
            value: new.to_string(),
        };
        self.operated(&mut self.lock(), action);
        Ok(())
    }

    /// A new period was published: it counts from the next iteration on.
    pub(crate) fn period_of(&self, instance: usize) -> Option<Nanos> {
        let bytes = newest_bytes(self.variables.period(instance))?;
        let seconds = f64::from_ne_bytes(bytes.try_into().ok()?);
        // A father's nonsense leaves the period as it was.
        (seconds.is_finite() && seconds * 1e9 >= SHORTEST as f64).then(|| (seconds * 1e9).round() as Nanos)
    }

    pub(crate) fn retimed(&self, instance: usize, period: Nanos) {
        self.meters[instance]
            .period
            .store(period, std::sync::atomic::Ordering::Relaxed);
        self.transact(|hierarchy, _, _| hierarchy.set_period(super::schema(instance), period));
        self.renew_contract();
    }

    /// Works out the contract anew (R17), after a period or a policy changed.
    pub(super) fn renew_contract(&self) {
        let Rules {
            hierarchy, groups, ..
        } = &mut *self.lock();
        groups.agree(hierarchy);
    }

    /// What an operator wrote over at an instance, in a word.
    pub(super) fn overwritten(&self, instance: usize) -> Option<&'static str> {
        let period = self.variables.period(instance);
        let held = self.held();
        let mut names = held
            .values
            .iter()
            .filter(|(owner, variable, _)| *owner == instance && newest_writer(variable) == OPERATOR);
        let (_, first, _) = names.next()?;
        Some(if Arc::ptr_eq(first, period) {
            "re-timed"
        } else {
            "modulated"
        })
    }

    /// Writes as an operator, and remembers what was there before.
    fn overwrite(&self, instance: usize, variable: &Arc<Variable>, bytes: &[u8]) -> Result<(), Refused> {
        let mut held = self.held();
        let before = newest(variable);
        variable.put(OPERATOR, bytes, self.clock.now(), Nanos::MAX)?;
        if let Some(before) = before.filter(|before| before.writer != OPERATOR) {
            held.values.retain(|(_, other, _)| !Arc::ptr_eq(other, variable));
            held.values.push((instance, Arc::clone(variable), before));
        }
        Ok(())
    }

    /// Undoes what operators wrote over at an instance; what a father has written since stands.
    fn give_back(&self, instance: usize) {
        let mut held = self.held();
        let now = self.clock.now();
        for (_, variable, before) in held.values.extract_if(.., |(owner, ..)| *owner == instance) {
            if newest_writer(&variable) == OPERATOR {
                let put = variable.put(before.writer, &before.bytes, now, Nanos::MAX);
                put.expect("it was in force before");
            }
        }
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn known(&self, instance: usize) -> Result<(), String> {
        let count = self.application.instances.len();
        if instance < count {
            return Ok(());
        }
        Err(format!(
            "there is no schema number {instance}; the application has {count}"
        ))
    }

    /// Takes all authority away and sends every actuator its neutral value; nobody gains authority afterwards.
    /// Answers with the drivers that have commands to carry out.
    pub(crate) fn brake_all(&self) -> Vec<usize> {
        let mut rules = self.lock();
        rules.closing.get_or_insert_default();
        let drivers = rules.commands.brake_all(self.clock.now());
        for driver in &drivers {
            self.ring(*driver, Signal::Triggered);
        }
        drivers
    }

    /// Tells one instance that it sleeps, in the order that [`Self::put_to_sleep`] gave.
    pub(crate) fn send_to_sleep(&self, instance: usize) {
        self.ring(instance, Signal::Asleep);
    }

    /// Puts everything to sleep; answers with the order in which it must happen, children before fathers.
    pub(crate) fn put_to_sleep(&self) -> Vec<usize> {
        self.transact(|hierarchy, now, out| hierarchy.shutdown(now, out));
        self.lock().closing.replace(Vec::new()).unwrap_or_default()
    }
}

fn newest(variable: &Arc<Variable>) -> Option<Before> {
    variable.reader("host").latch().map(|latched| Before {
        writer: latched.stamp.writer,
        bytes: latched.bytes.to_vec(),
    })
}

fn newest_bytes(variable: &Arc<Variable>) -> Option<Vec<u8>> {
    newest(variable).map(|newest| newest.bytes)
}

fn newest_writer(variable: &Arc<Variable>) -> u32 {
    newest(variable).map_or(Stamp::NOBODY, |newest| newest.writer)
}
