//! The state of one condition: whether it was true at the last evaluation, and for which schemas or groups.

use std::collections::{BTreeMap, BTreeSet};

use jde_board::Nanos;
use jde_records::chattering::ChatterDetector;

use super::Condition;
use super::condition::ConditionKind;
use super::expression::Expression;
use super::facts::Fact;

/// The shortest time between two evaluations of an expression, in ns.
const MIN_INTERVAL: Nanos = 10_000_000;

/// A condition and its state.
pub(crate) struct Trigger {
    pub(crate) condition: Condition,
    pub(crate) state: TriggerState,
}

pub(crate) enum TriggerState {
    /// The groups or schemas for which the condition is true now.
    Active(BTreeSet<String>),
    /// The last switches of every group, and whether they are too many.
    Switches(BTreeMap<String, ChatterDetector<()>>),
    /// The values of an expression.
    Expression(Box<ExpressionState>),
}

pub(crate) struct ExpressionState {
    pub(crate) expression: Expression,
    was_true: bool,
    /// The time of the last evaluation.
    evaluated_at: Option<Nanos>,
    /// Whether a value has arrived since the last evaluation.
    pub(crate) is_pending: bool,
}

impl TriggerState {
    fn of(kind: &ConditionKind) -> Self {
        match kind {
            ConditionKind::Expression(expression) => Self::Expression(Box::new(ExpressionState {
                expression: expression.clone(),
                was_true: false,
                evaluated_at: None,
                is_pending: false,
            })),
            ConditionKind::Chatter { .. } => Self::Switches(BTreeMap::new()),
            ConditionKind::Collision(_)
            | ConditionKind::Absence(_)
            | ConditionKind::Overrun(_)
            | ConditionKind::Fault(_)
            | ConditionKind::Refused
            | ConditionKind::Operator => Self::Active(BTreeSet::new()),
        }
    }
}

impl Trigger {
    pub(crate) fn new(condition: Condition) -> Self {
        Self {
            state: TriggerState::of(&condition.kind),
            condition,
        }
    }

    /// Returns what became true by a fact, if anything did.
    pub(crate) fn fact(&mut self, time: Nanos, fact: &Fact<'_>) -> Option<String> {
        let fits = |only: &Option<String>, name: &str| only.as_deref().is_none_or(|only| only == name);
        match (&self.condition.kind, &mut self.state, fact) {
            (
                ConditionKind::Collision(only),
                TriggerState::Active(active),
                Fact::Selected { group, collision, .. },
            ) if fits(only, group) => {
                update_active(active, group, *collision).then(|| format!("collision in {group}"))
            }
            (
                ConditionKind::Absence(only),
                TriggerState::Active(active),
                Fact::Selected { group, absence, .. },
            ) if fits(only, group) => {
                update_active(active, group, *absence).then(|| format!("nobody wins in {group}"))
            }
            (
                ConditionKind::Chatter {
                    more_than,
                    group: only,
                },
                TriggerState::Switches(groups),
                Fact::Selected {
                    group,
                    switched: true,
                    ..
                },
            ) if fits(only, group) => {
                // A pause between switches starts a new series.
                let chatter = groups
                    .entry((*group).to_owned())
                    .or_insert_with(|| ChatterDetector::new(*more_than, *more_than));
                let count = chatter.record_switch(time, ())?;
                Some(format!("chattering: {count} switches within a second in {group}"))
            }
            (
                ConditionKind::Overrun(only),
                TriggerState::Active(active),
                Fact::Health { schema, overrun, .. },
            ) if fits(only, schema) => {
                update_active(active, schema, *overrun).then(|| format!("overrun of {schema}"))
            }
            (
                ConditionKind::Fault(only),
                TriggerState::Active(active),
                Fact::Health { schema, fault, .. },
            ) if fits(only, schema) => update_active(active, schema, fault.is_some())
                .then(|| format!("fault of {schema}: {}", fault.unwrap_or_default())),
            (ConditionKind::Refused, _, Fact::Refused { schema, text }) => {
                Some(format!("refused to {schema}: {text}"))
            }
            (ConditionKind::Operator, _, Fact::Operator(text)) => Some(format!("operator: {text}")),
            _ => None,
        }
    }
}

/// Returns whether a condition becomes true for a schema or group for which it was false.
fn update_active(active: &mut BTreeSet<String>, name: &str, is_true: bool) -> bool {
    if is_true {
        active.insert(name.to_owned())
    } else {
        active.remove(name);
        false
    }
}

impl ExpressionState {
    pub(crate) fn is_due(&self, time: Nanos) -> bool {
        self.is_pending
            && self
                .evaluated_at
                .is_none_or(|at| time >= at.saturating_add(MIN_INTERVAL))
    }

    /// Evaluates the expression. Returns whether it becomes true.
    pub(crate) fn evaluate(&mut self, time: Nanos) -> bool {
        self.evaluated_at = Some(time);
        self.is_pending = false;
        let now = self.expression.is_true();
        let before = std::mem::replace(&mut self.was_true, now);
        now && !before
    }
}
