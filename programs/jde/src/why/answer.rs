//! The answer to a question: the selection that it asks for. Prints nothing.

use jde_records::event::Occurrence;
use jde_records::{CandidateRecord, Decision};

use super::asleep::{Asleep, Past};
use super::question::{NOBODY, Question};
use super::steps::{self, DueStep};

/// How far a time that a user read and rounded may be from the actual one, s.
const ROUNDING_S: f64 = 0.1;

/// The span of time whose selections are known, s since the application's start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KnownSpan {
    /// The beginning; earlier selections are no longer known.
    pub(crate) from: f64,
    /// The end; later selections have not occurred yet, or were not recorded.
    pub(crate) until: f64,
}

impl KnownSpan {
    /// Returns a reason if a time, s, lies outside the span. `what` is known in the span, in the plural.
    pub(crate) fn outside_reason(self, at: f64, what: &str) -> Option<String> {
        let Self { from, until } = self;
        if at > until + ROUNDING_S {
            Some(format!("{at} s is after {what}, which end at {until:.2} s"))
        } else if at < from - ROUNDING_S {
            Some(format!("{at} s is before {what}, which begin at {from:.2} s"))
        } else {
            None
        }
    }
}

/// The answer to a question.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Answer<'d> {
    /// This selection, with the takeovers of its group before and after it.
    Match {
        /// The selection.
        decision: &'d Decision,
        /// The takeover before it.
        before: Option<&'d Decision>,
        /// The takeover after it.
        after: Option<&'d Decision>,
        /// How guards and the driver limited the commands of the chosen schema until then (R18).
        limits: Vec<&'d Occurrence<String>>,
        /// The first and the last command of a chunk that came due in that time; those that led to it if it chose nobody.
        steps: Vec<&'d DueStep>,
    },
    /// There was nobody to select.
    Asleep(Asleep<'d>),
    /// There is no such selection; the text gives the reason.
    NoMatch(String),
}

impl Question {
    /// Finds the selection that the question asks for. The selections and `limits`, the events of limited commands, are in
    /// the order in which they were made.
    pub(crate) fn answer<'d>(&self, past: Past<'d>, limits: &'d [Occurrence<String>]) -> Answer<'d> {
        if let Some(reason) = self.out_of_span_reason(past.known) {
            return Answer::NoMatch(reason);
        }
        if let Some(asleep) = self.asleep(past) {
            return Answer::Asleep(asleep);
        }
        let decisions = past.decisions;
        let found = if self.negated {
            self.find_not_chosen(decisions)
        } else if self.winner.as_deref() == Some(NOBODY) && self.time_s.is_none() {
            self.find_absence(decisions)
        } else {
            self.find_takeover(decisions)
                .or_else(|| self.find_lasting(decisions))
        };
        let Some(index) = found else {
            return Answer::NoMatch(self.no_match_reason(decisions));
        };
        let decision = &decisions[index];
        let of_group = |other: &&Decision| other.changed && other.group == decision.group;
        let after = decisions[index + 1..].iter().find(of_group);
        let until = after.map_or(f64::INFINITY, |after| after.time_s);
        let is_limit = |event: &&Occurrence<String>| {
            event.what.schema() == decision.choice.as_ref()
                && (decision.time_s..=until).contains(&event.time_s())
        };
        Answer::Match {
            decision,
            before: decisions[..index].iter().rev().find(of_group),
            after,
            limits: limits.iter().filter(is_limit).collect(),
            steps: steps::of_decision(decision, until, past.steps),
        }
    }

    /// Returns a reason if the question's time lies outside the known span.
    fn out_of_span_reason(&self, known: KnownSpan) -> Option<String> {
        known.outside_reason(self.time_s?, "the known selections")
    }

    /// Returns the takeover that the question asks for: the nearest to its time, or the last.
    fn find_takeover(&self, decisions: &[Decision]) -> Option<usize> {
        let mut matching = decisions
            .iter()
            .enumerate()
            .filter(|(_, decision)| self.is_match(decision));
        let Some(at) = self.time_s else {
            return matching.next_back().map(|(index, _)| index);
        };
        if self.winner.is_none() && self.loser.is_none() {
            // A question with a time alone asks for the takeover in force at that time.
            return matching
                .take_while(|(_, decision)| decision.time_s <= at + ROUNDING_S / 2.0)
                .last()
                .map(|(index, _)| index);
        }
        let distance = |decision: &Decision| (decision.time_s - at).abs();
        matching
            .min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)))
            .map(|(index, _)| index)
    }

    /// Returns a selection that the winner of the question won again: it took over before the known selections begin, and
    /// was in force. The nearest to the question's time, or the first.
    fn find_lasting(&self, decisions: &[Decision]) -> Option<usize> {
        if self.loser.is_some() || self.winner.as_deref() == Some(NOBODY) {
            return None;
        }
        // After the first change of its group, what a selection says is no longer what was before.
        let mut changed = Vec::new();
        let mut lasting = Vec::new();
        for (index, decision) in decisions.iter().enumerate() {
            let is_of_group = self.group.as_ref().is_none_or(|group| *group == decision.group);
            if !is_of_group || changed.contains(&&decision.group) {
                continue;
            }
            match (decision.changed, &decision.choice) {
                (true, _) => changed.push(&decision.group),
                (false, Some(choice)) if self.winner.as_ref().is_none_or(|winner| winner == choice) => {
                    lasting.push(index);
                }
                (false, Some(_) | None) => {}
            }
        }
        let distance = |index: &usize| {
            self.time_s
                .map_or(0.0, |at| (decisions[*index].time_s - at).abs())
        };
        lasting
            .into_iter()
            .min_by(|one, other| distance(one).total_cmp(&distance(other)))
    }

    /// Returns the last selection without a winner; one that is still in force takes precedence.
    fn find_absence(&self, decisions: &[Decision]) -> Option<usize> {
        let is_in_force = |index: usize| {
            let mut later = decisions[index + 1..].iter();
            later.all(|other| other.group != decisions[index].group)
        };
        let indices = (0..decisions.len()).filter(|index| self.is_match(&decisions[*index]));
        indices.max_by_key(|index| (is_in_force(*index), *index))
    }

    /// Returns the last selection of the schema's group up to the question's time in which the schema was not
    /// chosen, even if it was not awake then.
    fn find_not_chosen(&self, decisions: &[Decision]) -> Option<usize> {
        let loser = self.winner.as_deref()?;
        let until = self.time_s.map_or(f64::INFINITY, |at| at + ROUNDING_S / 2.0);
        let is_loser = |candidate: &CandidateRecord| candidate.name == loser;
        let known = decisions
            .iter()
            .find(|decision| decision.candidates.iter().any(is_loser))?;
        decisions.iter().rposition(|decision| {
            decision.time_s <= until
                && decision.choice.as_deref() != Some(loser)
                && decision.group == known.group
        })
    }

    fn is_match(&self, decision: &Decision) -> bool {
        let matches = |expected: &Option<String>, actual: &str| {
            expected.as_deref().is_none_or(|expected| expected == actual)
        };
        // A selection without a winner is no takeover. It matches a question about nobody.
        (decision.changed || self.winner.as_deref() == Some(NOBODY) && self.loser.is_none())
            && matches(&self.winner, decision.choice_name())
            && matches(&self.loser, decision.before_name())
            && self.group.as_ref().is_none_or(|group| *group == decision.group)
    }

    /// Returns the reason why no selection fits, and what would fit.
    fn no_match_reason(&self, decisions: &[Decision]) -> String {
        let takeovers = decisions.iter().filter(|decision| {
            decision.changed && self.group.as_ref().is_none_or(|group| *group == decision.group)
        });
        let (Some(first), Some(last)) = (decisions.first(), decisions.last()) else {
            return String::from("no selection has been made yet");
        };
        let winner = self.winner.as_deref();
        let won = takeovers
            .clone()
            .filter(|decision| Some(decision.choice_name()) == winner)
            .count();
        match (winner, self.loser.as_deref()) {
            (Some(name), _) if self.negated => {
                format!("{name} has been a candidate of no selection that another schema won")
            }
            (Some(NOBODY), loser) => format!(
                "every selection{}{} from {:.2} s to {:.2} s has a winner",
                self.group
                    .as_ref()
                    .map_or_else(String::new, |group| format!(" of {group}")),
                loser.map_or_else(String::new, |loser| format!(" after {loser}")),
                first.time_s,
                last.time_s
            ),
            (Some(name), _) if won == 0 => format!(
                "{name} never took over from {:.2} s to {:.2} s",
                first.time_s, last.time_s
            ),
            (Some(name), Some(loser)) => {
                let mut others: Vec<_> = takeovers
                    .filter(|decision| Some(decision.choice_name()) == winner)
                    .map(|decision| decision.before_name())
                    .collect();
                others.sort_unstable();
                others.dedup();
                format!(
                    "{name} never took over from {loser}, only from {}",
                    others.join(", ")
                )
            }
            _ => format!(
                "there was no such takeover from {:.2} s to {:.2} s",
                first.time_s, last.time_s
            ),
        }
    }
}
