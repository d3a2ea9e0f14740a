//! Holds selections against the recorded ones, group by group, in the order of their times.

use std::collections::{BTreeMap, VecDeque};

use jde_core::Nanos;
use jde_host::replay::Sight;
use jde_host::story::{Candidate, Decision};

use super::{Seen, Span};

/// Differences that are kept whole; more are counted.
const KEPT: usize = 100;
/// How long a selection waits for its counterpart: its takeover has to be known first, which a hung winner may hold up.
const WAIT: Nanos = 5_000_000_000;
/// Urgencies this near are one: another build may round otherwise.
const URGENCY: f64 = 1e-9;

/// What came of holding selections against each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Selections that are as they were.
    pub same: u64,
    /// Those that are not: other, missing, or new.
    pub different: u64,
    /// The first of them.
    pub first: Vec<Difference>,
}

/// A selection that is not as it was.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// When, s since the start.
    pub time_s: f64,
    /// In which group.
    pub group: String,
    /// The recorded selection; none if there was none.
    pub recorded: Option<Side>,
    /// The one of the replay; none if there is none.
    pub replayed: Option<Side>,
    /// What the candidates of the replay saw at their last checks, by name.
    pub saw: Vec<(String, Vec<Sight>)>,
}

/// One selection of two.
pub type Side = Decision;

/// Selections on their way to their counterparts.
pub(super) struct Compared {
    span: Span,
    apart: Nanos,
    groups: BTreeMap<String, Group>,
    done: Comparison,
}

#[derive(Default)]
struct Group {
    recorded: VecDeque<Decision>,
    replayed: VecDeque<Seen>,
}

impl Compared {
    pub(super) fn new(span: Span, apart: Nanos) -> Self {
        Self {
            span,
            apart,
            groups: BTreeMap::new(),
            done: Comparison::default(),
        }
    }

    pub(super) fn recorded(&mut self, decision: Decision) {
        if self.has(&decision) {
            self.group(&decision.group).recorded.push_back(decision);
        }
    }

    pub(super) fn replayed(&mut self, decision: Decision, saw: Vec<(String, Vec<Sight>)>) {
        if self.has(&decision) {
            self.group(&decision.group).replayed.push_back((decision, saw));
        }
    }

    /// Compares what can be compared now.
    pub(super) fn settle(&mut self, now: Nanos) {
        self.compare(now.saturating_sub(WAIT));
    }

    /// Compares the rest, up to the end of the replay.
    pub(super) fn finish(mut self, until: Nanos) -> Comparison {
        for group in self.groups.values_mut() {
            group.recorded.retain(|decision| ns(decision) <= until);
        }
        self.compare(Nanos::MAX);
        self.done.first.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        self.done
    }

    /// Whoever has no counterpart by `late` gets none.
    fn compare(&mut self, late: Nanos) {
        for group in self.groups.values_mut() {
            while let Some((recorded, replayed)) = group.next(self.apart, late) {
                match (recorded, replayed) {
                    (Some(recorded), Some((replayed, _))) if same(&recorded, &replayed) => {
                        self.done.same += 1
                    }
                    (None, None) => {}
                    (recorded, replayed) => {
                        self.done.different += 1;
                        if self.done.first.len() < KEPT {
                            self.done.first.push(Difference::of(recorded, replayed));
                        }
                    }
                }
            }
        }
    }

    fn has(&self, decision: &Decision) -> bool {
        (self.span.from..=self.span.to).contains(&ns(decision))
    }

    fn group(&mut self, name: &str) -> &mut Group {
        self.groups.entry(name.to_owned()).or_default()
    }
}

impl Group {
    /// The next selection, with its counterpart if it has one.
    fn next(&mut self, apart: Nanos, late: Nanos) -> Option<(Option<Decision>, Option<Seen>)> {
        let recorded = self.recorded.front().map(ns);
        let replayed = self.replayed.front().map(|(decision, _)| ns(decision));
        match (recorded, replayed) {
            (Some(then), Some(now)) if then.abs_diff(now) <= apart => {
                Some((self.recorded.pop_front(), self.replayed.pop_front()))
            }
            (Some(then), Some(now)) if then < now => Some((self.recorded.pop_front(), None)),
            (Some(_), Some(_)) => Some((None, self.replayed.pop_front())),
            (Some(then), None) if then < late => Some((self.recorded.pop_front(), None)),
            (None, Some(now)) if now < late => Some((None, self.replayed.pop_front())),
            (Some(_), None) | (None, Some(_)) | (None, None) => None,
        }
    }
}

impl Difference {
    fn of(recorded: Option<Decision>, replayed: Option<Seen>) -> Self {
        let (replayed, saw) = replayed.unzip();
        let either = recorded.as_ref().or(replayed.as_ref());
        Self {
            time_s: either.map_or(0.0, |decision| decision.time_s),
            group: either.map_or(String::new(), |decision| decision.group.clone()),
            recorded,
            replayed,
            saw: saw.unwrap_or_default(),
        }
    }
}

/// When a selection was, ns.
fn ns(decision: &Decision) -> Nanos {
    (decision.time_s * 1e9).round() as Nanos
}

/// Whether two selections are one: all but their numbers and the time the takeover took.
fn same(then: &Decision, now: &Decision) -> bool {
    then.case == now.case
        && then.before == now.before
        && then.choice == now.choice
        && then.decider == now.decider
        && then.reason == now.reason
        && then.cause == now.cause
        && then.changed == now.changed
        && then.candidates.len() == now.candidates.len()
        && then
            .candidates
            .iter()
            .zip(&now.candidates)
            .all(|(then, now)| alike(then, now))
}

fn alike(then: &Candidate, now: &Candidate) -> bool {
    let urgency = match (then.urgency, now.urgency) {
        (Some(then), Some(now)) => (then - now).abs() <= URGENCY * then.abs().max(now.abs()).max(1.0),
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    };
    urgency && then.name == now.name && then.state == now.state && then.ready == now.ready
}
