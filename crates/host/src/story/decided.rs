//! Selections with their takeovers: a record comes first, and the time to the winner's first iteration a little later.

use std::collections::VecDeque;

use jde_core::{Case, Cause, Nanos, Record, SchemaId, State, Timer};

use super::{Candidate, Decision, seconds};
use crate::app::Application;
use crate::engine::decider_name;
use crate::event::Event;

/// Turns records into [`Decision`]s, in order, each once its takeover is known or can no longer come.
pub struct Decided {
    names: Vec<String>,
    groups: Vec<String>,
    waiting: VecDeque<Waiting>,
}

struct Waiting {
    record: Record,
    takeover: Option<Nanos>,
    complete: bool,
}

impl Decided {
    /// Of an application.
    #[must_use]
    pub fn new(application: &Application) -> Self {
        Self {
            names: application
                .instances
                .iter()
                .map(|instance| instance.name.clone())
                .collect(),
            groups: application
                .groups
                .iter()
                .map(|group| group.name.clone())
                .collect(),
            waiting: VecDeque::new(),
        }
    }

    /// Hears an event; answers with the selections that are complete now.
    pub fn hear(&mut self, event: &Event) -> Vec<Decision> {
        match event {
            Event::Decided(record) => {
                // A choice that was never carried out gets no takeover time.
                for waiting in self
                    .waiting
                    .iter_mut()
                    .filter(|waiting| waiting.record.group == record.group)
                {
                    waiting.complete |= record.changed;
                }
                let complete = !record.changed || record.choice.is_none();
                self.waiting.push_back(Waiting {
                    record: record.clone(),
                    takeover: None,
                    complete,
                });
            }
            Event::Took { record, latency, .. } => {
                if let Some(waiting) = self
                    .waiting
                    .iter_mut()
                    .find(|waiting| waiting.record.number == *record)
                {
                    (waiting.takeover, waiting.complete) = (Some(*latency), true);
                }
            }
            _ => return Vec::new(),
        }
        let mut complete = Vec::new();
        while let Some(waiting) = self.waiting.pop_front_if(|waiting| waiting.complete) {
            complete.push(self.decision(&waiting));
        }
        complete
    }

    /// Selections whose takeover never came.
    pub fn rest(&mut self) -> Vec<Decision> {
        let waiting = std::mem::take(&mut self.waiting);
        waiting.iter().map(|waiting| self.decision(waiting)).collect()
    }

    fn decision(&self, waiting: &Waiting) -> Decision {
        let record = &waiting.record;
        let name = |id: SchemaId| self.names[id.index()].clone();
        Decision {
            number: record.number,
            time_s: seconds(record.time),
            group: self.groups[record.group.index()].clone(),
            case: case_name(record.case).to_owned(),
            candidates: record
                .candidates
                .iter()
                .map(|candidate| Candidate {
                    name: name(candidate.id),
                    state: state_name(candidate.state).to_owned(),
                    ready: candidate.ready,
                    urgency: Some(candidate.urgency).filter(|urgency| urgency.is_finite()),
                })
                .collect(),
            before: record.before.map(name),
            choice: record.choice.map(name),
            decider: decider_name(record.decider).to_owned(),
            reason: record.reason.to_string(),
            cause: cause_words(record.cause, name),
            changed: record.changed,
            takeover_us: waiting.takeover.map(|latency| latency as f64 / 1e3),
        }
    }
}

/// A state's name as people write it.
#[must_use]
pub fn state_name(state: State) -> &'static str {
    match state {
        State::Slept => "slept",
        State::Checking => "checking",
        State::Ready => "ready",
        State::Winner => "winner",
    }
}

fn case_name(case: Case) -> &'static str {
    match case {
        Case::Alone => "alone",
        Case::Collision => "collision",
        Case::Absence => "absence",
        Case::Forced => "forced",
    }
}

fn cause_words(cause: Cause, name: impl Fn(SchemaId) -> String) -> String {
    match cause {
        Cause::Start => String::from("the application started"),
        Cause::Readiness(id) => format!("the readiness of {} changed", name(id)),
        Cause::Woken(id) => format!("{} was woken", name(id)),
        Cause::Slept(id) => format!("{} was put to sleep", name(id)),
        Cause::Faulted(id) => format!("{} faulted", name(id)),
        Cause::Iterated(id) => format!("{} ended an iteration", name(id)),
        Cause::PolicyChanged => String::from("the father changed the policy"),
        Cause::Operator(id) => format!("an operator acted on {}", name(id)),
        Cause::Timer(Timer::Patience(_)) => String::from("the patience with the loser is over"),
        Cause::Timer(Timer::Arbitration(_)) => String::from("the father's time to arbitrate is over"),
        Cause::Timer(Timer::Turn(_)) => String::from("a dwell time or turn is over"),
        Cause::Timer(Timer::Hold(_)) => String::from("the last command has stood long enough"),
        Cause::Timer(Timer::Restart(id)) => format!("the back-off of {} is over", name(id)),
    }
}
