//! What operators do from outside the hierarchy (R14).
//!
//! Each action on the hierarchy is one transaction, which also records the operator's number there. A replay repeats
//! the actions by these numbers, without names.

mod all;
mod exports;
mod holds;
mod losses;
mod unload;
mod values;

use std::sync::Arc;

use jde_app::{Application, InstancePort};
use jde_board::Board;
use jde_core::{Hierarchy, HoldAction, Holder, Operator, Refused, SchemaId, Transaction};
use jde_records::event::Loss;
use jde_records::snapshot::{Hold, HoldKind};
use jde_records::turn::{Moment, Operation, TurnKind};
use parking_lot::{Mutex, MutexGuard};

use super::{Rules, Variables};
use crate::clock::Clock;
use crate::journal::Journal;
pub(crate) use holds::Actor;
use holds::OperatorHolds;
use values::newest_writer;

/// The writer number of operators.
pub(crate) const OPERATOR: u32 = u32::MAX - 1;

/// The operators' way into a running application.
pub(crate) struct Operators {
    application: Arc<Application>,
    clock: Arc<Clock>,
    board: Arc<Board>,
    variables: Arc<Variables>,
    rules: Arc<Rules>,
    journal: Option<Arc<Journal>>,
    /// What operators have changed and not released. This lock is taken after the rules' lock, or alone.
    holds: Mutex<OperatorHolds>,
}

impl Operators {
    pub(super) fn new(
        application: &Arc<Application>,
        clock: &Arc<Clock>,
        board: &Arc<Board>,
        variables: &Arc<Variables>,
        rules: &Arc<Rules>,
        journal: Option<Arc<Journal>>,
    ) -> Self {
        Self {
            application: Arc::clone(application),
            clock: Arc::clone(clock),
            board: Arc::clone(board),
            variables: Arc::clone(variables),
            rules: Arc::clone(rules),
            journal,
            holds: Mutex::default(),
        }
    }

    /// Plays, stops, forces or releases a schema. Returns what awake schemas lose by it.
    pub(crate) fn operate(&self, by: &Actor, operator: Operator) -> Result<Vec<Loss>, String> {
        let instance = operated_schema(operator);
        let mut was_held = false;
        let ((done, losses), moment, holder) = self.transact_as(by, |transaction, holder| {
            was_held = self.check_schema(instance).is_ok() && transaction.holds(instance).next().is_some();
            self.with_losses(transaction, instance, |transaction| {
                let done = transaction.operator(holder, operator);
                done.map_err(|refused| self.refusal(&refused))
            })
        });
        self.record_operation(instance, operation(operator, holder), moment);
        done?;
        if let Operator::Release(_) = operator {
            let given_back = self.restore_values(instance, |_| true);
            let repaired = self.repair_exports(instance, |_| true);
            if !was_held && !given_back && !repaired {
                // Nothing was released, so nothing happened.
                return Ok(losses);
            }
        }
        self.rules.report_stop(&by.name, operator.into(), losses.clone());
        Ok(losses)
    }

    /// Repeats an operator's action on the hierarchy, in a replay. An action that was refused is refused
    /// again.
    pub(crate) fn repeat_operation(&self, by: Holder, operator: Operator) {
        // The original operator was informed of a refusal.
        let _ = self
            .rules
            .transact(|transaction| transaction.operator(by, operator));
    }

    /// Repeats the end of what one operator held, in a replay.
    pub(crate) fn repeat_undo(&self, by: Holder, instance: SchemaId) {
        // The original operator was informed of a refusal.
        let _ = self
            .rules
            .transact(|transaction| transaction.let_go(by, instance));
    }

    /// Ends what one lease, or one operator with all leases, holds of a schema.
    pub(crate) fn release_own(&self, by: &Actor, instance: SchemaId) -> Result<(), String> {
        self.check_schema(instance)?;
        let (held, moment, holder) =
            self.transact_as(by, |transaction, holder| transaction.let_go(holder, instance));
        let undone = match held {
            Ok(false) => Operation::Refused,
            Ok(true) | Err(_) => Operation::Undone(holder),
        };
        self.record_operation(instance, undone, moment);
        let held = held.map_err(|refused| refused.to_string())?;
        let given_back = self.restore_values(instance, |actor| by.covers(actor));
        let repaired = self.repair_exports(instance, |actor| by.covers(actor));
        if held || given_back || repaired {
            let release = Operator::Release(instance);
            self.rules.report_operation(&by.name, release.into());
        }
        Ok(())
    }

    /// Runs a transaction of an operator, who gets a number in the hierarchy.
    fn transact_as<R>(
        &self,
        by: &Actor,
        change: impl FnOnce(&mut Transaction, Holder) -> R,
    ) -> (R, Moment, Holder) {
        let mut holder = Holder::UNKNOWN;
        let (result, moment) = self.rules.transact_recorded(|transaction| {
            holder = self.holds().holder(transaction, by);
            change(transaction, holder)
        });
        (result, moment, holder)
    }

    fn record_operation(&self, instance: SchemaId, operation: Operation, moment: Moment) {
        self.rules
            .record_turn(TurnKind::Operated(operation), instance, moment);
    }

    /// Describes a refusal, with the operator who holds and what ends that.
    fn refusal(&self, refused: &Refused) -> String {
        let Refused::HeldStopped { schema, stop } = refused else {
            return refused.to_string();
        };
        let held = self.holds();
        let by = held.name(stop.by);
        let end = match stop.action {
            HoldAction::StoppedWithAll => "`jde release --all` lets everything go on".to_owned(),
            HoldAction::Unloaded => format!("`jde load {schema}` loads it"),
            HoldAction::Stopped | HoldAction::Forced | HoldAction::Played => {
                format!("`jde release {schema}` ends that")
            }
        };
        let word = hold_kind(stop.action).word();
        format!("`{schema}` is {word} by {by}, and an action with a lease does not end that: {end}")
    }

    /// Everything that operators hold a schema to, in the order of the kinds.
    pub(super) fn hold_views(&self, hierarchy: &Hierarchy, instance: SchemaId) -> Vec<Hold> {
        let held = self.holds();
        let with_all = |hold: jde_core::Hold| hold.action == HoldAction::StoppedWithAll;
        let everything = hierarchy.holds(instance).any(with_all);
        let in_hierarchy = hierarchy.holds(instance).map(|hold| Hold {
            kind: hold_kind(hold.action),
            with_everything: with_all(hold) || everything && hold.action == HoldAction::Unloaded,
            leased: hold.by.leased,
            by: held.name(hold.by).to_owned(),
        });
        let failing = held
            .failing
            .range(InstancePort::new(instance, 0)..=InstancePort::new(instance, usize::MAX));
        let failing = failing.flat_map(|(_, failures)| failures);
        let failing = failing.map(|(actor, _)| actor.hold(HoldKind::Failing));
        let in_force = |value: &&holds::Overwritten| {
            value.owner == instance && newest_writer(&value.variable) == OPERATOR
        };
        let values = held.values.iter().filter(in_force).flat_map(|value| {
            let retimed = Arc::ptr_eq(&value.variable, self.variables.period(instance));
            let kind = if retimed {
                HoldKind::Retimed
            } else {
                HoldKind::Modulated
            };
            value.writes.iter().map(move |(actor, _)| actor.hold(kind))
        });
        let mut holds: Vec<_> = in_hierarchy.chain(failing).chain(values).collect();
        holds.sort_by_key(|hold| (hold.kind, !hold.with_everything));
        // An operator may hold several values.
        holds.dedup();
        holds
    }

    fn name(&self, instance: SchemaId) -> &str {
        &self.application.instances[instance].name
    }

    fn holds(&self) -> MutexGuard<'_, OperatorHolds> {
        self.holds.lock()
    }

    pub(crate) fn check_schema(&self, instance: SchemaId) -> Result<(), String> {
        let instances = &self.application.instances;
        if instances.get(instance).is_some() {
            return Ok(());
        }
        let (SchemaId(number), count) = (instance, instances.len());
        Err(format!(
            "there is no schema number {number}; the application has {count}"
        ))
    }
}

/// An operator's action, as turns have it.
fn operation(operator: Operator, by: Holder) -> Operation {
    match operator {
        Operator::Play(_) => Operation::Played(by),
        Operator::Stop(_) => Operation::Stopped(by),
        Operator::Force(_) => Operation::Forced(by),
        Operator::Release(_) => Operation::Released(by),
    }
}

/// The schema that an operator acted on.
fn operated_schema(operator: Operator) -> SchemaId {
    match operator {
        Operator::Play(id) | Operator::Stop(id) | Operator::Force(id) | Operator::Release(id) => id,
    }
}

fn hold_kind(action: HoldAction) -> HoldKind {
    match action {
        HoldAction::Unloaded => HoldKind::Unloaded,
        HoldAction::StoppedWithAll | HoldAction::Stopped => HoldKind::Stopped,
        HoldAction::Forced => HoldKind::Forced,
        HoldAction::Played => HoldKind::Played,
    }
}
