//! What operators and the end of the application do from outside the hierarchy (R14).

use std::sync::Arc;

use jde_board::Variable;
use jde_board::value::{self, Value};
use jde_core::{Nanos, Operator};

use super::{Engine, Signal};
use crate::event::OperatorAction;

/// Shortest period anyone may set: what the timers of a machine can keep.
const SHORTEST: Nanos = 100_000;

/// The writer number of operators.
pub(crate) const OPERATOR: u32 = u32::MAX - 1;

impl Engine {
    /// Plays, stops, forces or releases a schema.
    pub(crate) fn operate(&self, operator: Operator) -> Result<(), String> {
        self.transact(|hierarchy, now, out| hierarchy.operator(now, operator, out))
            .map_err(|error| error.to_string())?;
        self.operated(&mut self.lock(), OperatorAction::Hierarchy(operator));
        Ok(())
    }

    /// Changes a period.
    pub(crate) fn retime(&self, instance: usize, period: Nanos) -> Result<(), String> {
        if period < SHORTEST {
            return Err(format!(
                "a period of {period} ns is too short; give at least 0.1 ms"
            ));
        }
        let seconds = period as f64 / 1e9;
        let now = self.clock.now();
        let put = self
            .variables
            .period(instance)
            .put(OPERATOR, &seconds.to_ne_bytes(), now, Nanos::MAX);
        put.map_err(|refused| refused.to_string())?;
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
        let put = variable.put(OPERATOR, &bytes, self.clock.now(), Nanos::MAX);
        put.map_err(|refused| format!("`{}.{name}` stays as it is: {refused}", self.name(instance)))?;
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

fn newest_bytes(variable: &Arc<Variable>) -> Option<Vec<u8>> {
    variable
        .reader("host")
        .latch()
        .map(|latched| latched.bytes.to_vec())
}
