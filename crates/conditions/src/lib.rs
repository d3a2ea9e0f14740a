//! Conditions over selections, health and variables, and the moments at which they become true.
//!
//! A [`Condition`] is checked against the names of an application before it starts. [`Triggers`] process
//! events and values, and report a [`Firing`] whenever a condition changes from false to true. They depend
//! only on what they receive, in its order, so a run in virtual time always fires in the same way. They have
//! no thread, no clock and no file. The caller acts on a firing.

mod check;
mod condition;
mod expression;
mod facts;
mod kind;
mod names;
mod value_view;
mod watch;

use std::collections::BTreeSet;

use jde_board::Nanos;
use jde_records::RunRecord;
use jde_records::event::Event;

use condition::ConditionKind;
pub use condition::{BadCondition, Condition, Reason};
use facts::Fact;
pub use names::Names;
use watch::{ExpressionState, Trigger, TriggerState};

/// Conditions that are watched together.
pub struct Triggers {
    names: Names,
    list: Vec<Trigger>,
}

/// A condition that became true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Firing {
    /// The time, in ns since the application's start.
    pub time: Nanos,
    /// The index of the condition among those that are watched.
    pub condition: usize,
    /// What became true: `collision in example/base`, or the expression.
    pub text: String,
}

impl Triggers {
    /// Watches conditions of an application that has these names.
    #[must_use]
    pub fn new(names: Names, conditions: Vec<Condition>) -> Self {
        let list = conditions.into_iter().map(Trigger::new).collect();
        Self { names, list }
    }

    /// Returns the full names of the variables whose values they need, each once.
    #[must_use]
    pub fn variables(&self) -> BTreeSet<&str> {
        let named = self
            .list
            .iter()
            .filter_map(|trigger| match &trigger.condition.kind {
                ConditionKind::Expression(expression) => Some(expression.variables()),
                _ => None,
            });
        named.flatten().collect()
    }

    /// Returns the text of a condition.
    #[must_use]
    pub fn condition(&self, index: usize) -> Option<&str> {
        self.list
            .get(index)
            .map(|trigger| trigger.condition.text.as_str())
    }

    /// Processes an event of the application that has these names.
    pub fn process_event(&mut self, event: &Event, fired: &mut Vec<Firing>) {
        if let Some((time, fact)) = facts::of_event(event, &self.names) {
            apply_fact(&mut self.list, time, &fact, fired);
        }
    }

    /// Processes a record of an application in another process.
    pub fn process_record(&mut self, record: &RunRecord, fired: &mut Vec<Firing>) {
        if let Some(fact) = facts::of_record(record) {
            apply_fact(&mut self.list, record.time(), &fact, fired);
        }
    }

    /// Processes a new value of a variable: all bytes of its type.
    pub fn process_value(&mut self, time: Nanos, variable: &str, bytes: &[u8], fired: &mut Vec<Firing>) {
        self.update_expressions(time, fired, |state| {
            state.expression.set_value(variable, Some(bytes))
        });
    }

    /// Processes the retraction of a variable's value.
    pub fn process_retraction(&mut self, time: Nanos, variable: &str, fired: &mut Vec<Firing>) {
        self.update_expressions(time, fired, |state| state.expression.set_value(variable, None));
    }

    /// Advances the time, and evaluates expressions that were deferred because values arrived too soon after
    /// the last evaluation.
    pub fn advance(&mut self, time: Nanos, fired: &mut Vec<Firing>) {
        self.update_expressions(time, fired, |_| false);
    }

    fn update_expressions(
        &mut self,
        time: Nanos,
        fired: &mut Vec<Firing>,
        set_value: impl Fn(&mut ExpressionState) -> bool,
    ) {
        for (condition, trigger) in self.list.iter_mut().enumerate() {
            let TriggerState::Expression(state) = &mut trigger.state else {
                continue;
            };
            // A deferred expression is first evaluated without this value.
            let before = state.is_due(time) && state.evaluate(time);
            state.is_pending |= set_value(state);
            let now = state.is_due(time) && state.evaluate(time);
            if before || now {
                fired.push(Firing {
                    time,
                    condition,
                    text: trigger.condition.text.clone(),
                });
            }
        }
    }
}

fn apply_fact(list: &mut [Trigger], time: Nanos, fact: &Fact<'_>, fired: &mut Vec<Firing>) {
    for (condition, trigger) in list.iter_mut().enumerate() {
        if let Some(text) = trigger.fact(time, fact) {
            fired.push(Firing {
                time,
                condition,
                text,
            });
        }
    }
}

#[cfg(test)]
mod tests;
