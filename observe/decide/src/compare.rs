//! Compares selections with the recorded ones, by group and in the order of their times.

use std::collections::{BTreeMap, VecDeque};

use jde_core::Nanos;
use jde_host::replay::PortReading;
use jde_records::{CandidateRecord, Decision};

use crate::{ReplayedDecision, Span};

/// The largest number of differences that are kept. Further ones are only counted.
const MAX_DIFFERENCES: usize = 100;
/// How long a selection waits for its counterpart, in ns. A selection is reported once its takeover is known,
/// which a hung winner may delay.
const COUNTERPART_WAIT: Nanos = 5_000_000_000;
/// The relative difference up to which urgencies count as equal, because another build may round differently.
const URGENCY_TOLERANCE: f64 = 1e-9;

/// The result of comparing selections.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// The number of equal selections.
    pub same: u64,
    /// The number of different, missing and new selections.
    pub different: u64,
    /// The first of these, in the order of their times.
    pub first: Vec<Difference>,
}

/// A selection that differs from the recorded one.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The time, in s since the application's start.
    pub time_s: f64,
    /// The group.
    pub group: String,
    /// The recorded selection, if there was one.
    pub recorded: Option<Side>,
    /// The selection of the replay, if there was one.
    pub replayed: Option<Side>,
    /// What the candidates of the replay saw at their last checks, by name.
    pub inputs: Vec<(String, Vec<PortReading>)>,
}

/// One of the two selections of a difference.
pub type Side = Decision;

/// Selections that wait for their counterparts.
pub(super) struct DecisionMatcher {
    span: Span,
    time_tolerance: Nanos,
    groups: BTreeMap<String, Group>,
    comparison: Comparison,
}

#[derive(Default)]
struct Group {
    recorded: VecDeque<Decision>,
    replayed: VecDeque<ReplayedDecision>,
}

impl DecisionMatcher {
    pub(super) fn new(span: Span, time_tolerance: Nanos) -> Self {
        Self {
            span,
            time_tolerance,
            groups: BTreeMap::new(),
            comparison: Comparison::default(),
        }
    }

    pub(super) fn push_recorded(&mut self, decision: Decision) {
        if self.is_in_span(&decision) {
            self.group(&decision.group).recorded.push_back(decision);
        }
    }

    pub(super) fn push_replayed(&mut self, decision: Decision, inputs: Vec<(String, Vec<PortReading>)>) {
        if self.is_in_span(&decision) {
            self.group(&decision.group).replayed.push_back((decision, inputs));
        }
    }

    /// Compares the selections that can be compared at this time.
    pub(super) fn compare_until(&mut self, now: Nanos) {
        self.compare(now.saturating_sub(COUNTERPART_WAIT));
    }

    /// Compares all remaining selections, up to the end of the replay. If the recording was cut off, a selection that still
    /// waits for its counterpart is not compared: that may be in the part that is lost.
    pub(super) fn finish(mut self, until: Nanos, is_cut_off: bool) -> Comparison {
        for group in self.groups.values_mut() {
            group.recorded.retain(|decision| ns(decision) <= until);
        }
        self.compare(if is_cut_off {
            until.saturating_sub(COUNTERPART_WAIT)
        } else {
            Nanos::MAX
        });
        self.comparison
            .first
            .sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        self.comparison
    }

    /// Compares all selections that have a counterpart, and those before `late` without one.
    fn compare(&mut self, late: Nanos) {
        for group in self.groups.values_mut() {
            while let Some((recorded, replayed)) = group.next(self.time_tolerance, late) {
                match (recorded, replayed) {
                    (Some(recorded), Some((replayed, _))) if is_same_decision(&recorded, &replayed) => {
                        self.comparison.same += 1
                    }
                    (None, None) => {}
                    (recorded, replayed) => {
                        self.comparison.different += 1;
                        if self.comparison.first.len() < MAX_DIFFERENCES {
                            self.comparison.first.push(Difference::of(recorded, replayed));
                        }
                    }
                }
            }
        }
    }

    fn is_in_span(&self, decision: &Decision) -> bool {
        (self.span.from..=self.span.to).contains(&ns(decision))
    }

    fn group(&mut self, name: &str) -> &mut Group {
        self.groups.entry(name.to_owned()).or_default()
    }
}

impl Group {
    /// Returns the next selection, with its counterpart if it has one.
    fn next(
        &mut self,
        time_tolerance: Nanos,
        late: Nanos,
    ) -> Option<(Option<Decision>, Option<ReplayedDecision>)> {
        let recorded = self.recorded.front().map(ns);
        let replayed = self.replayed.front().map(|(decision, _)| ns(decision));
        match (recorded, replayed) {
            (Some(recorded), Some(replayed)) if recorded.abs_diff(replayed) <= time_tolerance => {
                Some((self.recorded.pop_front(), self.replayed.pop_front()))
            }
            (Some(recorded), Some(replayed)) if recorded < replayed => {
                Some((self.recorded.pop_front(), None))
            }
            (Some(_), Some(_)) => Some((None, self.replayed.pop_front())),
            (Some(recorded), None) if recorded < late => Some((self.recorded.pop_front(), None)),
            (None, Some(replayed)) if replayed < late => Some((None, self.replayed.pop_front())),
            (Some(_), None) | (None, Some(_)) | (None, None) => None,
        }
    }
}

impl Difference {
    fn of(recorded: Option<Decision>, replayed: Option<ReplayedDecision>) -> Self {
        let (replayed, inputs) = replayed.unzip();
        let either = recorded.as_ref().or(replayed.as_ref());
        Self {
            time_s: either.map_or(0.0, |decision| decision.time_s),
            group: either.map_or(String::new(), |decision| decision.group.clone()),
            recorded,
            replayed,
            inputs: inputs.unwrap_or_default(),
        }
    }
}

/// Returns the time of a selection, in ns.
fn ns(decision: &Decision) -> Nanos {
    (decision.time_s * 1e9).round() as Nanos
}

/// Returns whether two selections are equal, apart from their numbers, their times and the duration of their
/// takeovers.
fn is_same_decision(then: &Decision, now: &Decision) -> bool {
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
            .all(|(then, now)| is_same_candidate(then, now))
}

fn is_same_candidate(then: &CandidateRecord, now: &CandidateRecord) -> bool {
    let urgency = match (then.urgency, now.urgency) {
        (Some(then), Some(now)) => {
            (then - now).abs() <= URGENCY_TOLERANCE * then.abs().max(now.abs()).max(1.0)
        }
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    };
    urgency && then.name == now.name && then.state == now.state && then.ready == now.ready
}

#[cfg(test)]
mod tests {
    use jde_core::Case;
    use jde_records::DecidedBy;

    use super::*;

    fn decision(time_s: f64) -> Decision {
        Decision {
            number: 1,
            time_s,
            group: "roots".to_owned(),
            case: Case::Alone,
            candidates: Vec::new(),
            before: None,
            choice: None,
            decider: DecidedBy::Nobody,
            reason: String::new(),
            cause: String::new(),
            changed: false,
            takeover_us: None,
            refused: Vec::new(),
        }
    }

    /// Returns the counts of equal and of different selections, if the last two are not in the recording.
    fn compared(is_cut_off: bool) -> (u64, u64) {
        let mut matcher = DecisionMatcher::new(Span::default(), 0);
        matcher.push_recorded(decision(1.0));
        for time in [1.0, 2.0, 9.9] {
            matcher.push_replayed(decision(time), Vec::new());
        }
        let comparison = matcher.finish(9_900_000_000, is_cut_off);
        (comparison.same, comparison.different)
    }

    #[test]
    fn what_a_cut_recording_has_lost_at_its_end_is_no_difference() {
        assert_eq!(compared(false), (1, 2));
        assert_eq!(compared(true), (1, 1), "that of 2 s is too old to be lost");
    }
}
