//! Conditions that are watched together, and the moments at which they become true.

use std::collections::BTreeSet;

use jde_board::Nanos;
use jde_records::RunRecord;
use jde_records::event::Event;

use crate::condition::ConditionKind;
use crate::facts::{self, Fact};
use crate::signals;
use crate::watch::{ExpressionState, Pending, Trigger, TriggerState};
use crate::{Condition, Names, Signals};

/// Conditions that are watched together.
///
/// All that happens at one instant counts as one: an expression over signals is evaluated once the time
/// advances, with the time of that instant. So it is never evaluated in the middle of a selection, when the
/// loser is WINNER no longer and the winner is not yet.
pub struct Triggers {
    names: Names,
    signals: Signals,
    list: Vec<Trigger>,
    now: Nanos,
}

/// A condition that became true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Firing {
    /// The time, in ns since the application's start.
    pub time: Nanos,
    /// The index of the condition among those that are watched.
    pub condition: usize,
    /// What became true: `conflict in example/base`, or the expression.
    pub text: String,
}

impl Triggers {
    /// Watches conditions of an application that has these names.
    #[must_use]
    pub fn new(names: Names, conditions: Vec<Condition>) -> Self {
        let mut signals = Signals::new(&names);
        // The conditions receive the initial values.
        signals.take_changes(|_, _| {});
        let list = conditions
            .into_iter()
            .map(|condition| Trigger::new(condition, &signals))
            .collect();
        Self {
            names,
            signals,
            list,
            now: 0,
        }
    }

    /// Returns the full names of the variables whose values they need, each once.
    #[must_use]
    pub fn variables(&self) -> BTreeSet<&str> {
        let mut variables = BTreeSet::new();
        for trigger in &self.list {
            let ConditionKind::Expression(expression) = &trigger.condition.kind else {
                continue;
            };
            for input in expression.inputs() {
                match self.signals.find(input) {
                    Some(signal) => variables.extend(self.signals.variables(signal)),
                    None => _ = variables.insert(input),
                }
            }
        }
        variables
    }

    /// Returns the first part of a condition that somebody who comes after the start of the application cannot know: a signal
    /// that counts since the start, or a keyword, which waits for an event.
    #[must_use]
    pub fn unknown_to_late(&self) -> Option<&str> {
        self.list
            .iter()
            .find_map(|trigger| match &trigger.condition.kind {
                ConditionKind::Expression(expression) => expression
                    .inputs()
                    .find(|input| self.signals.find(input).is_some_and(signals::is_count)),
                ConditionKind::Conflict(_)
                | ConditionKind::Absence(_)
                | ConditionKind::Chatter { .. }
                | ConditionKind::Overrun(_)
                | ConditionKind::Fault(_)
                | ConditionKind::Refused
                | ConditionKind::Operator => Some(trigger.condition.text.as_str()),
            })
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
        self.begin(event.time(), fired);
        self.signals.process_event(event);
        if let Some(fact) = facts::of_event(event, &self.names) {
            apply_fact(&mut self.list, event.time(), &fact, fired);
        }
        self.pass_signals(event.time());
    }

    /// Processes a record of an application in another process.
    pub fn process_record(&mut self, record: &RunRecord, fired: &mut Vec<Firing>) {
        self.begin(record.time(), fired);
        self.signals.process_record(record);
        if let Some(fact) = facts::of_record(record) {
            apply_fact(&mut self.list, record.time(), &fact, fired);
        }
        self.pass_signals(record.time());
    }

    /// Processes a new value of a variable: all bytes of its type.
    pub fn process_value(&mut self, time: Nanos, variable: &str, bytes: &[u8], fired: &mut Vec<Firing>) {
        self.update_value(time, variable, Some(bytes), fired);
    }

    /// Processes the retraction of a variable's value.
    pub fn process_retraction(&mut self, time: Nanos, variable: &str, fired: &mut Vec<Firing>) {
        self.update_value(time, variable, None, fired);
    }

    /// Ends an instant: evaluates expressions whose signals changed, that name the time, or that were deferred
    /// because values arrived too soon after the last evaluation.
    pub fn advance(&mut self, time: Nanos, fired: &mut Vec<Firing>) {
        self.begin(time, fired);
        for state in expressions(&mut self.list) {
            if state.names_time() {
                state.pend(Pending::AtInterval);
            }
        }
        let is_due = |state: &ExpressionState, time| state.is_immediate(time) || state.is_interval_over(time);
        self.evaluate(self.now, is_due, fired);
    }

    fn update_value(&mut self, time: Nanos, variable: &str, value: Option<&[u8]>, fired: &mut Vec<Firing>) {
        self.begin(time, fired);
        // A deferred expression is first evaluated without this value.
        self.evaluate(time, ExpressionState::is_interval_over, fired);
        for state in expressions(&mut self.list) {
            state.set_variable(variable, value);
        }
        self.signals.process_value(variable, value);
        self.pass_signals(time);
        self.evaluate(time, ExpressionState::is_interval_over, fired);
    }

    /// Begins an instant, unless it is the present one: evaluates what the previous one changed.
    fn begin(&mut self, time: Nanos, fired: &mut Vec<Firing>) {
        if time > self.now {
            self.evaluate(self.now, ExpressionState::is_immediate, fired);
            self.now = time;
            self.signals.advance(time);
            self.pass_signals(time);
        }
    }

    /// Passes the signals that changed to the expressions that name them.
    fn pass_signals(&mut self, time: Nanos) {
        let list = &mut self.list;
        self.signals.take_changes(|signal, value| {
            for state in expressions(list) {
                state.set_signal(time, signal, value);
            }
        });
    }

    fn evaluate(
        &mut self,
        now: Nanos,
        which: impl Fn(&ExpressionState, Nanos) -> bool,
        fired: &mut Vec<Firing>,
    ) {
        for (condition, trigger) in self.list.iter_mut().enumerate() {
            if let TriggerState::Expression(state) = &mut trigger.state
                && which(state, now)
                && let Some(time) = state.evaluate(now)
            {
                fired.push(Firing {
                    time,
                    condition,
                    text: trigger.condition.text.clone(),
                });
            }
        }
    }
}

fn expressions(list: &mut [Trigger]) -> impl Iterator<Item = &mut ExpressionState> {
    list.iter_mut().filter_map(|trigger| match &mut trigger.state {
        TriggerState::Expression(state) => Some(&mut **state),
        TriggerState::Active(_) | TriggerState::Switches(_) => None,
    })
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
