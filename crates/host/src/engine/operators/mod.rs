//! What operators do from outside the hierarchy (R14).
//!
//! Each action on the hierarchy is one transaction, which also records the operator. A replay repeats the
//! actions without their operators.

mod all;
mod exports;
mod holds;
mod unload;
mod values;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use jde_app::Application;
use jde_board::Board;
use jde_core::{Effect, Hierarchy, Nanos, Operator, Requester, SchemaId};
use jde_records::event::OperatorAction;
use jde_records::snapshot::{Hold, HoldKind};
use jde_records::turn::Turn;

use super::{Rules, Variables, schema};
use crate::clock::Clock;
use crate::journal::Journal;
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
            self.repair_exports(id.index(), |_| true);
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
    fn undo(
        &self,
        hierarchy: &mut Hierarchy,
        now: Nanos,
        out: &mut Vec<Effect>,
        instance: usize,
    ) -> Result<(), String> {
        hierarchy
            .let_go(now, schema(instance), out)
            .map_err(|refused| refused.to_string())?;
        self.holds().remove_hold(instance);
        Ok(())
    }

    /// Applies an operator's action to the hierarchy, and records the hold.
    fn apply_operation(
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

    /// Undoes what one operator did to a schema.
    pub(crate) fn release_own(&self, by: &str, instance: usize) -> Result<(), String> {
        self.check_schema(instance)?;
        let release = Operator::Release(schema(instance));
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
        let repaired = self.repair_exports(instance, |operator| operator == by);
        if held || given_back || repaired {
            self.rules
                .report_operation(by, OperatorAction::Hierarchy(release));
        }
        Ok(())
    }

    /// The hold of an operator on a schema, and the operator.
    pub(super) fn hold_view(&self, hierarchy: &Hierarchy, instance: usize) -> Option<Hold> {
        let held = self.holds();
        if let Some(kind) = hold_kind(hierarchy, schema(instance)) {
            let unloaded = held.unloaded.contains(&instance);
            let kind = if unloaded { HoldKind::Unloaded } else { kind };
            let with_everything = hierarchy.is_stopped_with_all(schema(instance));
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
        let mut failing = held.failing.range((instance, 0)..=(instance, usize::MAX));
        if let Some((_, by)) = failing.next() {
            return Some(Hold {
                kind: HoldKind::Failing,
                with_everything: false,
                by: by.clone(),
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

    fn name(&self, instance: usize) -> &str {
        &self.application.instances[instance].name
    }

    fn holds(&self) -> MutexGuard<'_, OperatorHolds> {
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
