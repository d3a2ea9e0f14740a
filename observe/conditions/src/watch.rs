//! The state of one condition: whether it was true at the last evaluation, and for which schemas or groups.

use std::collections::{BTreeMap, BTreeSet};

use jde_board::Nanos;
use jde_records::chattering::ChatterDetector;

use super::Condition;
use super::condition::ConditionKind;
use super::expression::Expression;
use super::facts::Fact;
use super::signals::{self, Signals};

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
    expression: Expression,
    /// The signals that it names, and their places among its inputs.
    signals: Vec<(usize, usize)>,
    was_true: bool,
    /// The time of the last evaluation.
    evaluated_at: Option<Nanos>,
    pending: Pending,
    /// The time of the event that last changed a signal.
    changed_at: Nanos,
}

/// Whether an expression has to be evaluated, because an input changed since the last evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Pending {
    No,
    /// Once [`MIN_INTERVAL`] has passed: a value arrived, of which there may be many.
    AtInterval,
    /// At the end of the present instant: an event changed a signal.
    Immediately,
}

impl TriggerState {
    fn of(kind: &ConditionKind, signals: &Signals) -> Self {
        match kind {
            ConditionKind::Expression(expression) => {
                Self::Expression(Box::new(ExpressionState::new(expression, signals)))
            }
            ConditionKind::Chatter { .. } => Self::Switches(BTreeMap::new()),
            ConditionKind::Conflict(_)
            | ConditionKind::Absence(_)
            | ConditionKind::Overrun(_)
            | ConditionKind::Fault(_)
            | ConditionKind::Refused
            | ConditionKind::Operator => Self::Active(BTreeSet::new()),
        }
    }
}

impl Trigger {
    pub(crate) fn new(condition: Condition, signals: &Signals) -> Self {
        Self {
            state: TriggerState::of(&condition.kind, signals),
            condition,
        }
    }

    /// Returns what became true by a fact, if anything did.
    pub(crate) fn fact(&mut self, time: Nanos, fact: &Fact<'_>) -> Option<String> {
        let fits = |only: &Option<String>, name: &str| only.as_deref().is_none_or(|only| only == name);
        match (&self.condition.kind, &mut self.state, fact) {
            (
                ConditionKind::Conflict(only),
                TriggerState::Active(active),
                Fact::Selected { group, conflict, .. },
            ) if fits(only, group) => {
                update_active(active, group, *conflict).then(|| format!("conflict in {group}"))
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
    /// Receives the initial values of its signals.
    fn new(expression: &Expression, signals: &Signals) -> Self {
        let mut expression = expression.clone();
        let names: Vec<_> = expression.inputs().map(|name| signals.find(name)).collect();
        let count = names.len();
        let named = names.into_iter().enumerate();
        let named: Vec<_> = named
            .filter_map(|(place, signal)| Some((signal?, place)))
            .collect();
        for (signal, place) in &named {
            expression.set(*place, signals.value(*signal));
        }
        Self {
            expression,
            // An expression over signals alone may be true from the beginning.
            pending: if named.len() == count {
                Pending::AtInterval
            } else {
                Pending::No
            },
            signals: named,
            was_true: false,
            evaluated_at: None,
            changed_at: 0,
        }
    }

    pub(crate) fn names_time(&self) -> bool {
        self.signals.iter().any(|(signal, _)| *signal == signals::TIME)
    }

    pub(crate) fn pend(&mut self, pending: Pending) {
        self.pending = self.pending.max(pending);
    }

    pub(crate) fn set_variable(&mut self, variable: &str, value: Option<&[u8]>) {
        let place = self.expression.inputs().position(|name| name == variable);
        let is_signal = |place| self.signals.iter().any(|(_, signal)| *signal == place);
        if let Some(place) = place.filter(|place| !is_signal(*place)) {
            self.expression.set(place, value);
            self.pend(Pending::AtInterval);
        }
    }

    pub(crate) fn set_signal(&mut self, time: Nanos, signal: usize, value: Option<&[u8]>) {
        let Some((_, place)) = self.signals.iter().find(|(named, _)| *named == signal) else {
            return;
        };
        self.expression.set(*place, value);
        match signal {
            // It changes always.
            signals::TIME => {}
            signals::CLEARANCE | signals::COLLISIONS => self.pend(Pending::AtInterval),
            _ => {
                self.pend(Pending::Immediately);
                self.changed_at = time;
            }
        }
    }

    pub(crate) fn is_immediate(&self, _: Nanos) -> bool {
        self.pending == Pending::Immediately
    }

    pub(crate) fn is_interval_over(&self, time: Nanos) -> bool {
        let over = |at: Nanos| time >= at.saturating_add(MIN_INTERVAL);
        self.pending == Pending::AtInterval && self.evaluated_at.is_none_or(over)
    }

    /// Evaluates the expression. Returns when it became true, if it does: at the event that changed it, or now.
    pub(crate) fn evaluate(&mut self, now: Nanos) -> Option<Nanos> {
        let time = match std::mem::replace(&mut self.pending, Pending::No) {
            Pending::Immediately => self.changed_at,
            Pending::No | Pending::AtInterval => now,
        };
        self.evaluated_at = Some(time);
        let is_true = self.expression.is_true();
        let was_true = std::mem::replace(&mut self.was_true, is_true);
        (is_true && !was_true).then_some(time)
    }
}
