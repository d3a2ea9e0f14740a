//! Unloading and loading of schemas by operators (R14). The runner ends and creates the instance, between two
//! iterations (R10).

use jde_core::{Health, Hierarchy, Holder, SchemaId, State, Transaction};
use jde_records::event::{Loss, OperatorAction};
use jde_records::turn::Operation;

use super::Operators;
use super::holds::Actor;
use crate::engine::Signal;

impl Operators {
    /// Puts a schema to sleep and ends its instance. Its variables stay. Returns what awake schemas lose by it.
    pub(crate) fn unload(&self, by: &Actor, instance: SchemaId) -> Result<Vec<Loss>, String> {
        self.check_schema(instance)?;
        let ((done, losses), moment, holder) = self.transact_as(by, |transaction, holder| {
            self.with_losses(transaction, instance, |transaction| {
                self.unload_within(transaction, holder, instance)
            })
        });
        let unloaded = match done {
            Ok(_) => Operation::Unloaded(holder),
            Err(_) => Operation::Refused,
        };
        self.record_operation(instance, unloaded, moment);
        if done? {
            self.rules.signals.notify(instance);
        }
        let action = OperatorAction::Unload { schema: instance };
        self.rules.report_stop(&by.name, action, losses.clone());
        Ok(losses)
    }

    /// Repeats an operator's unloading, in a replay. Refused unloadings were not recorded.
    pub(crate) fn repeat_unload(&self, by: Holder, instance: SchemaId) {
        let done = self
            .rules
            .transact(|transaction| self.unload_within(transaction, by, instance));
        debug_assert!(done.is_ok(), "it was done then: {done:?}");
        if done == Ok(true) {
            self.rules.signals.notify(instance);
        }
    }

    /// Releases an unloaded schema. Lets a faulted schema try again, with all restarts that its policy
    /// grants. The schema gets a new instance when it wakes up, which is at once if it is requested.
    pub(crate) fn load(&self, by: &Actor, instance: SchemaId) -> Result<(), String> {
        self.check_schema(instance)?;
        let (done, moment) = self
            .rules
            .transact_recorded(|transaction| self.load_within(transaction, instance));
        let loaded = match done {
            Ok(()) => Operation::Loaded,
            Err(_) => Operation::Refused,
        };
        self.record_operation(instance, loaded, moment);
        done?;
        self.rules
            .report_operation(&by.name, OperatorAction::Load { schema: instance });
        Ok(())
    }

    /// Repeats an operator's loading, in a replay.
    pub(crate) fn repeat_load(&self, instance: SchemaId) {
        // The original operator was informed of a refusal.
        let _ = self
            .rules
            .transact(|transaction| self.load_within(transaction, instance));
    }

    /// Whether an operator unloaded the schema.
    pub(crate) fn is_unloaded(&self, instance: SchemaId) -> bool {
        self.rules.read(|rules| is_unloaded(&rules.hierarchy, instance))
    }

    /// Unloads within a transaction. Returns whether to notify the instance's thread after it.
    fn unload_within(
        &self,
        transaction: &mut Transaction,
        by: Holder,
        instance: SchemaId,
    ) -> Result<bool, String> {
        transaction
            .unload(by, instance)
            .map_err(|refused| refused.to_string())?;
        // The instance may be asleep already; it ends as soon as it is.
        Ok(self.rules.signals.post(instance, Signal::Unloaded))
    }

    fn load_within(&self, transaction: &mut Transaction, instance: SchemaId) -> Result<(), String> {
        let name = self.name(instance);
        let (unloaded, faulted) = (
            is_unloaded(transaction, instance),
            is_faulted(transaction, instance),
        );
        if !unloaded && !faulted {
            return Err(format!(
                "`{name}` is not unloaded and has not faulted; unload it first to give it a fresh start"
            ));
        }
        if transaction.state(instance) != State::Slept {
            return Err(format!("`{name}` has not come to rest yet; try again"));
        }
        let loaded = transaction.load(instance);
        loaded.map_err(|refused| refused.to_string())?;
        if faulted {
            transaction.restored(instance);
        }
        Ok(())
    }
}

fn is_unloaded(hierarchy: &Hierarchy, instance: SchemaId) -> bool {
    let mut holds = hierarchy.holds(instance);
    holds.any(|hold| hold.action == jde_core::HoldAction::Unloaded)
}

fn is_faulted(hierarchy: &Hierarchy, instance: SchemaId) -> bool {
    matches!(hierarchy.health(instance), Health::Faulted(_))
}
