//! Unloading and loading of schemas by operators (R14). The runner ends and creates the instance, between two
//! iterations (R10).

use jde_core::{Effect, Health, Hierarchy, Holder, Nanos, State};
use jde_records::event::{Loss, OperatorAction};
use jde_records::turn::Operation;

use super::holds::Actor;
use super::{Operators, schema};
use crate::engine::Signal;

impl Operators {
    /// Puts a schema to sleep and ends its instance. Its variables stay. Returns what awake schemas lose by it.
    pub(crate) fn unload(&self, by: &Actor, instance: usize) -> Result<Vec<Loss>, String> {
        self.check_schema(instance)?;
        let ((done, losses), moment, holder) = self.transact_as(by, |hierarchy, now, out, holder| {
            self.with_losses(hierarchy, instance, |hierarchy| {
                self.unload_within(hierarchy, now, out, holder, instance)
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
    pub(crate) fn repeat_unload(&self, by: Holder, instance: usize) {
        let done = self
            .rules
            .transact(|hierarchy, now, out| self.unload_within(hierarchy, now, out, by, instance));
        debug_assert!(done.is_ok(), "it was done then: {done:?}");
        if done == Ok(true) {
            self.rules.signals.notify(instance);
        }
    }

    /// Releases an unloaded schema. Lets a faulted schema try again, with all restarts that its policy
    /// grants. The schema gets a new instance when it wakes up, which is at once if it is requested.
    pub(crate) fn load(&self, by: &Actor, instance: usize) -> Result<(), String> {
        self.check_schema(instance)?;
        let (done, moment) = self
            .rules
            .transact_recorded(|hierarchy, now, out| self.load_within(hierarchy, now, out, instance));
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
    pub(crate) fn repeat_load(&self, instance: usize) {
        // The original operator was informed of a refusal.
        let _ = self
            .rules
            .transact(|hierarchy, now, out| self.load_within(hierarchy, now, out, instance));
    }

    /// Whether an operator unloaded the schema.
    pub(crate) fn is_unloaded(&self, instance: usize) -> bool {
        self.rules.read(|rules| is_unloaded(&rules.hierarchy, instance))
    }

    /// Unloads within a transaction. Returns whether to notify the instance's thread after it.
    fn unload_within(
        &self,
        hierarchy: &mut Hierarchy,
        now: Nanos,
        out: &mut Vec<Effect>,
        by: Holder,
        instance: usize,
    ) -> Result<bool, String> {
        hierarchy
            .unload(now, by, schema(instance), out)
            .map_err(|refused| refused.to_string())?;
        // The instance may be asleep already; it ends as soon as it is.
        Ok(self.rules.signals.post(instance, Signal::Unloaded))
    }

    fn load_within(
        &self,
        hierarchy: &mut Hierarchy,
        now: Nanos,
        out: &mut Vec<Effect>,
        instance: usize,
    ) -> Result<(), String> {
        let name = self.name(instance);
        let (unloaded, faulted) = (is_unloaded(hierarchy, instance), is_faulted(hierarchy, instance));
        if !unloaded && !faulted {
            return Err(format!(
                "`{name}` is not unloaded and has not faulted; unload it first to give it a fresh start"
            ));
        }
        if hierarchy.state(schema(instance)) != State::Slept {
            return Err(format!("`{name}` has not come to rest yet; try again"));
        }
        let loaded = hierarchy.load(now, schema(instance), out);
        loaded.map_err(|refused| refused.to_string())?;
        if faulted {
            hierarchy.restored(now, schema(instance), out);
        }
        Ok(())
    }
}

fn is_unloaded(hierarchy: &Hierarchy, instance: usize) -> bool {
    let mut holds = hierarchy.holds(schema(instance));
    holds.any(|hold| hold.action == jde_core::HoldAction::Unloaded)
}

fn is_faulted(hierarchy: &Hierarchy, instance: usize) -> bool {
    matches!(hierarchy.health(schema(instance)), Health::Faulted(_))
}
