//! Unloading and loading of schemas by operators (R14). The runner ends and creates the instance, between two
//! iterations (R10).
//!
//! A schema that an awake schema needs is not unloaded: without its driver, an acting schema would act on
//! nothing. A motor schema can always be unloaded: its level selects again, since the schema sleeps.

use jde_abi::describe::Kind;
use jde_core::{Effect, Health, Hierarchy, Nanos, Operator, Requester, State};
use jde_records::event::OperatorAction;
use jde_records::turn::Turn;

use super::{Operators, schema};
use crate::engine::Signal;

impl Operators {
    /// Puts a schema to sleep and ends its instance. Its variables stay.
    pub(crate) fn unload(&self, by: &str, instance: usize) -> Result<(), String> {
        self.check_schema(instance)?;
        let (done, moment) = self.rules.transact_recorded(|hierarchy, now, out| {
            self.refuse_needed(hierarchy, instance)?;
            self.unload_within(hierarchy, now, out, by, instance)
        });
        let way = if done.is_ok() { Turn::UNLOADED } else { 0 };
        self.rules.record_turn(Turn::OPERATED, instance, way, moment);
        if done? {
            self.rules.signals.notify(instance);
        }
        self.rules
            .report_operation(by, OperatorAction::Unload { schema: instance });
        Ok(())
    }

    /// Repeats an operator's unloading, in a replay. Refused unloadings were not recorded.
    pub(crate) fn repeat_unload(&self, instance: usize) {
        let done = self
            .rules
            .transact(|hierarchy, now, out| self.unload_within(hierarchy, now, out, "", instance));
        debug_assert!(done.is_ok(), "it was done then: {done:?}");
        if done == Ok(true) {
            self.rules.signals.notify(instance);
        }
    }

    /// Releases an unloaded schema. Lets a faulted schema try again, with all restarts that its policy
    /// grants. The schema gets a new instance when it wakes up, which is at once if it is requested.
    pub(crate) fn load(&self, by: &str, instance: usize) -> Result<(), String> {
        self.check_schema(instance)?;
        let (done, moment) = self
            .rules
            .transact_recorded(|hierarchy, now, out| self.load_within(hierarchy, now, out, instance));
        let way = if done.is_ok() { Turn::LOADED } else { 0 };
        self.rules.record_turn(Turn::OPERATED, instance, way, moment);
        done?;
        self.rules
            .report_operation(by, OperatorAction::Load { schema: instance });
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
        self.holds().unloaded.contains(&instance)
    }

    /// Unloads within a transaction. Returns whether to notify the instance's thread after it.
    fn unload_within(
        &self,
        hierarchy: &mut Hierarchy,
        now: Nanos,
        out: &mut Vec<Effect>,
        by: &str,
        instance: usize,
    ) -> Result<bool, String> {
        self.apply_operation(hierarchy, now, out, by, Operator::Stop(schema(instance)))?;
        self.holds().unloaded.insert(instance);
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
        let (unloaded, faulted) = (self.is_unloaded(instance), is_faulted(hierarchy, instance));
        if !unloaded && !faulted {
            return Err(format!(
                "`{name}` is not unloaded and has not faulted; unload it first to give it a fresh start"
            ));
        }
        if hierarchy.state(schema(instance)) != State::Slept {
            return Err(format!("`{name}` has not come to rest yet; try again"));
        }
        if unloaded {
            self.undo(hierarchy, now, out, instance)?;
        }
        if faulted {
            hierarchy.restored(now, schema(instance), out);
        }
        Ok(())
    }

    fn refuse_needed(&self, hierarchy: &Hierarchy, instance: usize) -> Result<(), String> {
        if self.application.instances[instance].schema.kind == Kind::Motor {
            return Ok(());
        }
        let users = hierarchy.requesters(schema(instance)).iter();
        let users: Vec<_> = users
            .filter_map(|requester| match requester {
                Requester::Need(user) | Requester::Father(user) => Some(self.name(user.index())),
                Requester::Application | Requester::Operator => None,
            })
            .collect();
        if users.is_empty() {
            return Ok(());
        }
        Err(format!(
            "`{}` is needed by {}, awake now; stop what needs it first",
            self.name(instance),
            users.join(", ")
        ))
    }
}

fn is_faulted(hierarchy: &Hierarchy, instance: usize) -> bool {
    matches!(hierarchy.health(schema(instance)), Health::Faulted(_))
}
