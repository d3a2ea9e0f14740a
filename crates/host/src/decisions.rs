//! Why-records as lines of JSON, one for every selection (R15), in order: for files, pipes and the eyes of scripts.

use std::collections::VecDeque;
use std::io::Write;

use jde_core::{Case, Cause, Nanos, Record, SchemaId, State, Timer};
use serde::Serialize;

use crate::app::Application;
use crate::engine::decider_name;
use crate::event::{Event, Observer};

/// Writes a line for every selection it hears of, once the time to the winner's first iteration is known.
///
/// Keys of a line: `number`, `time_s`, `group`, `case`, `candidates` (`name`, `state`, `ready`, `urgency`), `before`, `choice`,
/// `decider`, `reason`, `cause`, `changed`, and `takeover_us` where a winner that was chosen began to iterate.
pub struct Decisions<W: Write + Send> {
    names: Vec<String>,
    groups: Vec<String>,
    waiting: VecDeque<Waiting>,
    out: W,
    failed: Option<std::io::Error>,
}

struct Waiting {
    record: Record,
    takeover: Option<Nanos>,
    complete: bool,
}

#[derive(Serialize)]
struct Line<'a> {
    number: u64,
    time_s: f64,
    group: &'a str,
    case: &'static str,
    candidates: Vec<CandidateLine<'a>>,
    before: Option<&'a str>,
    choice: Option<&'a str>,
    decider: &'static str,
    reason: &'a str,
    cause: String,
    changed: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    takeover_us: Option<f64>,
}

#[derive(Serialize)]
struct CandidateLine<'a> {
    name: &'a str,
    state: &'static str,
    ready: bool,
    urgency: f64,
}

impl<W: Write + Send> Decisions<W> {
    /// Writes to `out`; give it a buffer, since it writes line by line.
    pub fn new(application: &Application, out: W) -> Self {
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
            out,
            failed: None,
        }
    }

    /// Writes what still waits, and gives back what it wrote to.
    ///
    /// # Errors
    /// The first error of writing; lines after it were dropped, the application went on.
    pub fn finish(mut self) -> std::io::Result<W> {
        for waiting in std::mem::take(&mut self.waiting) {
            self.write(&waiting);
        }
        match self.failed {
            Some(error) => Err(error),
            None => {
                self.out.flush()?;
                Ok(self.out)
            }
        }
    }

    /// Hears one event.
    pub fn hear(&mut self, event: &Event) {
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
            _ => return,
        }
        while self.waiting.front().is_some_and(|waiting| waiting.complete) {
            if let Some(waiting) = self.waiting.pop_front() {
                self.write(&waiting);
            }
        }
    }

    fn write(&mut self, waiting: &Waiting) {
        let record = &waiting.record;
        let name = |id: SchemaId| self.names[id.index()].as_str();
        let line = Line {
            number: record.number,
            time_s: seconds(record.time),
            group: &self.groups[record.group.index()],
            case: case_name(record.case),
            candidates: record
                .candidates
                .iter()
                .map(|candidate| CandidateLine {
                    name: name(candidate.id),
                    state: state_name(candidate.state),
                    ready: candidate.ready,
                    urgency: candidate.urgency,
                })
                .collect(),
            before: record.before.map(name),
            choice: record.choice.map(name),
            decider: decider_name(record.decider),
            reason: &record.reason,
            cause: cause_words(record.cause, name),
            changed: record.changed,
            takeover_us: waiting.takeover.map(|latency| latency as f64 / 1e3),
        };
        let written = serde_json::to_writer(&mut self.out, &line).map_err(std::io::Error::from);
        if let Err(error) = written.and_then(|()| self.out.write_all(b"\n")) {
            self.failed.get_or_insert(error);
        }
    }
}

impl<W: Write + Send> Observer for Decisions<W> {
    fn hear(&mut self, event: &Event) {
        Decisions::hear(self, event);
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

fn cause_words<'a>(cause: Cause, name: impl Fn(SchemaId) -> &'a str) -> String {
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

/// Seconds, exact to the nanosecond for the first hundred days.
fn seconds(time: Nanos) -> f64 {
    time as f64 / 1e9
}
