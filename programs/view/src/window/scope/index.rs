//! Indices into the past: switches by group, and events by schema, both sorted by time. An update costs only
//! the new entries of a frame.

use std::collections::{HashMap, VecDeque};

use jde_core::Health;
use jde_link::message::Schemas;
use jde_records::Decision;
use jde_records::event::{Occurrence, What};

use crate::session::{History, Progress};

/// Switches and events, to be found by time.
#[derive(Debug, Default)]
pub(super) struct Index {
    processed: Progress,
    /// Indices of the schemas, by name.
    places: HashMap<String, usize>,
    groups: HashMap<String, VecDeque<Switch>>,
    marks: HashMap<String, VecDeque<Mark>>,
    /// The selection numbers of all switches.
    switches: VecDeque<u64>,
}

/// A change of winner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Switch {
    /// In s since the application's start.
    pub(super) time: f64,
    /// The number of its selection.
    pub(super) number: u64,
    /// The index of the previous winner's schema.
    pub(super) from: Option<usize>,
    /// The index of the new winner's schema.
    pub(super) to: Option<usize>,
}

/// An event of a schema.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mark {
    /// In s since the application's start.
    pub(super) time: f64,
    /// The kind of event.
    pub(super) sign: Sign,
    /// The description.
    pub(super) text: String,
}

/// The kinds of events, the least important first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Sign {
    Recovered,
    Operator,
    Refused,
    Overrun,
    Fault,
}

impl Index {
    /// Adds the new entries of the past. Rebuilds the index if a recording jumped back or the number of
    /// schemas changed.
    pub(super) fn take(&mut self, past: &History, schemas: &Schemas) {
        let processed = past.progress();
        if processed.turns != self.processed.turns || self.places.len() != schemas.schemas.len() {
            let places = schemas.schemas.iter().enumerate();
            *self = Self {
                places: places
                    .map(|(position, schema)| (schema.name.clone(), position))
                    .collect(),
                processed: Progress {
                    turns: processed.turns,
                    ..Progress::default()
                },
                ..Self::default()
            };
        }
        for decision in newest(past.decisions(), processed.decisions - self.processed.decisions) {
            if decision.changed {
                self.add_decision(decision, past);
            }
        }
        for event in newest(past.events(), processed.events - self.processed.events) {
            self.add_event(event, past);
        }
        self.processed = processed;
    }

    /// The switches of a group, oldest first.
    pub(super) fn group(&self, name: &str) -> Option<&VecDeque<Switch>> {
        self.groups.get(name)
    }

    /// The events of a schema, oldest first.
    pub(super) fn marks(&self, schema: &str) -> Option<&VecDeque<Mark>> {
        self.marks.get(schema)
    }

    /// The selection numbers of all switches, oldest first.
    pub(super) fn switches(&self) -> &VecDeque<u64> {
        &self.switches
    }

    fn add_decision(&mut self, decision: &Decision, past: &History) {
        let position = |name: &Option<String>| self.places.get(name.as_ref()?).copied();
        let switch = Switch {
            time: decision.time_s,
            number: decision.number,
            from: position(&decision.before),
            to: position(&decision.choice),
        };
        let first = past.decisions().front().map_or(0, |decision| decision.number);
        while self.switches.pop_front_if(|number| *number < first).is_some() {}
        self.switches.push_back(decision.number);
        if !self.groups.contains_key(&decision.group) {
            self.groups.insert(decision.group.clone(), VecDeque::new());
        }
        if let Some(group) = self.groups.get_mut(&decision.group) {
            while group.pop_front_if(|switch| switch.number < first).is_some() {}
            group.push_back(switch);
        }
    }

    fn add_event(&mut self, event: &Occurrence<String>, past: &History) {
        let (Some(schema), Some(sign)) = (event.what.schema(), sign(&event.what)) else {
            return;
        };
        let first = past.events().front().map_or(0.0, Occurrence::time_s);
        if !self.marks.contains_key(schema) {
            self.marks.insert(schema.clone(), VecDeque::new());
        }
        if let Some(marks) = self.marks.get_mut(schema) {
            while marks.pop_front_if(|mark| mark.time < first).is_some() {}
            // Binary search needs the order by time. Lines of one kind arrive in that order.
            let time = marks
                .back()
                .map_or(event.time_s(), |last| last.time.max(event.time_s()));
            marks.push_back(Mark {
                time,
                sign,
                text: event.text(),
            });
        }
    }
}

/// The mark of an event on the track of its schema, if it has one.
fn sign(what: &What<String>) -> Option<Sign> {
    match what {
        What::HealthChanged { health, .. } => Some(match health {
            Health::Ok => Sign::Recovered,
            Health::Overrun | Health::ArbitrationFailed(_) => Sign::Overrun,
            Health::Faulted(_) => Sign::Fault,
        }),
        What::Overrun { .. } => Some(Sign::Overrun),
        What::Hung { .. } | What::CallAbandoned { .. } => Some(Sign::Fault),
        What::Refused { .. } => Some(Sign::Refused),
        What::Operator { action, .. } if !action.goes_on() => Some(Sign::Operator),
        What::Operator { .. }
        | What::TookOver { .. }
        | What::ChatteringStarted { .. }
        | What::ChatteringEnded { .. }
        | What::StoodStill { .. }
        | What::WentOn { .. }
        | What::Stalled { .. }
        | What::AbandonedCallReturned { .. }
        | What::Limited { .. }
        | What::Reloaded { .. }
        | What::ReloadRolledBack { .. }
        | What::Retracted { .. }
        | What::Triggered { .. }
        | What::Ended { .. }
        | What::Unknown { .. } => None,
    }
}

/// The selection with a number.
pub(super) fn decision(past: &History, number: u64) -> Option<&Decision> {
    let decisions = past.decisions();
    let position = decisions.partition_point(|decision| decision.number < number);
    decisions
        .get(position)
        .filter(|decision| decision.number == number)
}

/// The last `count` entries, or as many as are still kept.
pub(super) fn newest<T>(list: &VecDeque<T>, count: u64) -> impl Iterator<Item = &T> {
    let count = usize::try_from(count).unwrap_or(usize::MAX).min(list.len());
    list.range(list.len() - count..)
}

#[cfg(test)]
mod tests {
    use jde_records::RunRecord;

    use super::super::fixture;
    use super::*;

    #[test]
    fn new_entries_are_indexed_once_and_a_jump_back_in_time_removes_later_ones() {
        let mut fixed = fixture::navigation();
        let mut index = Index::default();
        index.take(&fixed.past, &fixed.schemas);
        let before = index.switches().len();
        index.take(&fixed.past, &fixed.schemas);
        assert_eq!(index.switches().len(), before);
        let last = fixed
            .past
            .decisions()
            .back()
            .expect("the fixture has selections")
            .clone();
        let next = Decision {
            number: last.number + 1,
            time_s: last.time_s + 0.1,
            ..last
        };
        fixed.past.add_line(RunRecord::Decision(next), 0);
        index.take(&fixed.past, &fixed.schemas);
        assert_eq!(index.switches().len(), before + 1);

        let mut earlier = fixed.snapshot.clone();
        earlier.time = 2_000_000_000;
        fixed.past.add_snapshot(&earlier);
        index.take(&fixed.past, &fixed.schemas);
        let group = index.group("example/base").expect("the group has switches");
        assert!(group.iter().all(|switch| switch.time <= 2.0));
    }
}
