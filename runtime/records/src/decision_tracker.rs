//! Pairs selections with their takeovers: a record arrives first, and the time to the winner's first
//! iteration later.
//!
//! A selection is held back only while that time can still arrive, and for [`MAX_WAIT`] at most. A winner
//! that does not begin therefore never hides a decision from readers.

use std::collections::VecDeque;

use jde_app::Application;
use jde_core::{Cause, GroupId, Nanos, Record, SchemaId, State, Table, Timer};

use super::{CandidateRecord, Decision, RefusedCandidate, seconds};
use crate::event::{Event, Occurrence, What};

/// How long a selection waits for the first iteration of its winner, ns. Takeovers take milliseconds (R17),
/// and a hung call is given up after a second unless the application states otherwise; a longer takeover is
/// reported as late, or as a fault.
pub const MAX_WAIT: Nanos = 5_000_000_000;
/// How many selections of one group wait behind an open one. While a winner does not begin, the readiness of
/// a sibling may change at any rate.
pub const MAX_QUEUED: usize = 256;

/// Turns records into [`Decision`]s, in the order of each group. Each is complete once its takeover time is
/// known or can no longer arrive.
pub struct DecisionTracker {
    names: Table<SchemaId, String>,
    /// The group in which each schema competes.
    group_of: Table<SchemaId, Option<GroupId>>,
    /// The last refusal of each schema by a guard.
    refusals: Table<SchemaId, Option<Refusal>>,
    groups: Table<GroupId, PendingGroup>,
    /// Selections that began to wait, in the order of their times: the group, the record's number, and until
    /// when. Those that wait no longer are skipped.
    waiting: VecDeque<(GroupId, u64, Nanos)>,
}

struct PendingGroup {
    name: String,
    /// The selection whose winner has not begun yet.
    open: Option<Selection>,
    /// The selections after it.
    queued: Vec<Selection>,
}

/// A selection with what refusals say of it: a later refusal has other words.
struct Selection {
    record: Record,
    cause: String,
    refused: Vec<RefusedCandidate>,
}

/// A refusal of a command by a guard (R18).
struct Refusal {
    words: String,
    /// When the schema may be READY again.
    until: Nanos,
}

impl DecisionTracker {
    /// Creates a tracker for an application.
    #[must_use]
    pub fn new(application: &Application) -> Self {
        let group = |name: &String| PendingGroup {
            name: name.clone(),
            open: None,
            queued: Vec::new(),
        };
        let instances = application.instances.iter();
        Self {
            names: instances.clone().map(|instance| instance.name.clone()).collect(),
            refusals: application.instances.map_ids(|_| None),
            group_of: instances.map(|instance| instance.group).collect(),
            groups: application.groups.iter().map(|of| group(&of.name)).collect(),
            waiting: VecDeque::new(),
        }
    }

    /// Processes an event. Returns the selections that are complete now.
    pub fn process(&mut self, event: &Event) -> Vec<Decision> {
        match event {
            Event::Decision(record) => {
                let mut completed = self.take_overdue(record.time);
                self.push_record(record, &mut completed);
                completed
            }
            Event::State(change) => {
                let mut completed = self.take_overdue(change.time);
                // It lost before it began, or fell asleep before it was promoted.
                let is_lost = change.from == State::Winner || change.to == State::Slept;
                if let Some(group) = self.group_of[change.schema].filter(|_| is_lost)
                    && self.has_open(group, |open| open.choice == Some(change.schema))
                {
                    self.close(group, None, &mut completed);
                }
                completed
            }
            Event::Other(Occurrence { time, what }) => {
                if let What::TookOver {
                    group,
                    record,
                    latency,
                    ..
                } = what
                {
                    let mut completed = self.take_overdue(*time);
                    if self.has_open(*group, |open| open.number == *record) {
                        self.close(*group, Some(*latency), &mut completed);
                    }
                    return completed;
                }
                if let What::Refused {
                    schema,
                    description,
                    retry: Some(retry),
                } = what
                {
                    self.refusals[*schema] = Some(Refusal {
                        words: description.clone(),
                        until: time.saturating_add(*retry),
                    });
                }
                Vec::new()
            }
        }
    }

    /// Returns the selections whose takeover did not occur, in their order.
    pub fn drain(&mut self) -> Vec<Decision> {
        let mut completed = Vec::new();
        for group in self.groups.ids() {
            self.close(group, None, &mut completed);
        }
        self.waiting.clear();
        completed.sort_by_key(|decision| decision.number);
        completed
    }

    fn push_record(&mut self, record: &Record, completed: &mut Vec<Decision>) {
        let id = record.group;
        if record.changed || self.groups[id].queued.len() >= MAX_QUEUED {
            // A choice that was not carried out gets no takeover time.
            self.close(id, None, completed);
        }
        // A present winner that is chosen again was about to hand over, and now does not; there is no
        // takeover to wait for.
        let is_winner = |id| {
            let mut candidates = record.candidates.iter();
            candidates.any(|candidate| candidate.id == id && candidate.state == State::Winner)
        };
        let selection = Selection {
            record: record.clone(),
            cause: self.cause_text(record.cause),
            refused: self.refused_candidates(record),
        };
        let group = &mut self.groups[id];
        if record.changed && record.choice.is_some_and(|choice| !is_winner(choice)) {
            group.open = Some(selection);
            let until = record.time.saturating_add(MAX_WAIT);
            self.waiting.push_back((id, record.number, until));
        } else if group.open.is_some() {
            group.queued.push(selection);
        } else {
            completed.push(self.decision(selection, None));
        }
    }

    fn has_open(&self, group: GroupId, which: impl Fn(&Record) -> bool) -> bool {
        self.groups[group]
            .open
            .as_ref()
            .is_some_and(|open| which(&open.record))
    }

    /// Completes the open selection of a group and those behind it.
    fn close(&mut self, id: GroupId, takeover: Option<Nanos>, completed: &mut Vec<Decision>) {
        let group = &mut self.groups[id];
        let Some(open) = group.open.take() else {
            return;
        };
        let queued = std::mem::take(&mut group.queued);
        completed.push(self.decision(open, takeover));
        completed.extend(queued.into_iter().map(|selection| self.decision(selection, None)));
        // Every selection that waited is skipped once.
        while let Some((group, number, _)) = self.waiting.front()
            && !self.has_open(*group, |open| open.number == *number)
        {
            self.waiting.pop_front();
        }
    }

    fn cause_text(&self, cause: Cause) -> String {
        let refusal = match cause {
            Cause::Refused(id) => self.refusals[id].as_ref().map(|refusal| refusal.words.as_str()),
            _ => None,
        };
        cause_text(cause, |id| self.names[id].clone(), refusal)
    }

    fn refused_candidates(&self, record: &Record) -> Vec<RefusedCandidate> {
        let unready = record.candidates.iter().filter(|candidate| !candidate.ready);
        let refused = unready.filter_map(|candidate| {
            let Refusal { words, until } = self.refusals[candidate.id].as_ref()?;
            (*until > record.time).then(|| RefusedCandidate {
                name: self.names[candidate.id].clone(),
                reason: words.clone(),
                left_s: seconds(until - record.time),
            })
        });
        refused.collect()
    }

    /// Completes the selections that have waited too long.
    fn take_overdue(&mut self, now: Nanos) -> Vec<Decision> {
        let mut completed = Vec::new();
        while let Some((group, _, _)) = self.waiting.front().filter(|(_, _, until)| *until <= now) {
            self.close(*group, None, &mut completed);
        }
        completed
    }

    fn decision(&self, selection: Selection, takeover: Option<Nanos>) -> Decision {
        let Selection {
            record,
            cause,
            refused,
        } = selection;
        let name = |id: SchemaId| self.names[id].clone();
        Decision {
            number: record.number,
            time_s: seconds(record.time),
            group: self.groups[record.group].name.clone(),
            case: record.case,
            candidates: record
                .candidates
                .iter()
                .map(|candidate| CandidateRecord {
                    name: name(candidate.id),
                    state: candidate.state,
                    ready: candidate.ready,
                    urgency: Some(candidate.urgency).filter(|urgency| urgency.is_finite()),
                })
                .collect(),
            before: record.before.map(name),
            choice: record.choice.map(name),
            decider: record.decider.into(),
            reason: record.reason.to_string(),
            cause,
            changed: record.changed,
            takeover_us: takeover.map(|latency| latency as f64 / 1e3),
            refused,
        }
    }
}

fn cause_text(cause: Cause, name: impl Fn(SchemaId) -> String, refusal: Option<&str>) -> String {
    match cause {
        Cause::Start => String::from("the application started"),
        Cause::Readiness(id) => format!("the readiness of {} changed", name(id)),
        Cause::Woken(id) => format!("{} was woken", name(id)),
        Cause::Slept(id) => format!("{} was put to sleep", name(id)),
        Cause::Faulted(id) => format!("{} faulted", name(id)),
        Cause::Iterated(id) => format!("{} ended an iteration", name(id)),
        Cause::Refused(id) => format!(
            "{}: {}",
            name(id),
            refusal.unwrap_or("command refused by a guard")
        ),
        Cause::PolicyChanged => String::from("the father changed the policy"),
        Cause::Operator(id) => format!("an operator acted on {}", name(id)),
        Cause::Timer(Timer::Patience(_)) => String::from("the patience with the loser is over"),
        Cause::Timer(Timer::Arbitration(_)) => String::from("the father's time to arbitrate is over"),
        Cause::Timer(Timer::Turn(_)) => String::from("a dwell time or turn is over"),
        Cause::Timer(Timer::Hold(_)) => String::from("the last command has stood long enough"),
        Cause::Timer(Timer::Retry(id)) => format!("{} may be READY again after a refusal", name(id)),
        Cause::Timer(Timer::Restart(id)) => format!("the back-off of {} is over", name(id)),
    }
}
