//! Why nobody wins in a group whose members all sleep: no selection says so, because there was nobody to select.

use jde_core::{Nanos, State};
use jde_records::Decision;
use jde_records::event::{Occurrence, OperatorAction, What};
use jde_timeline::{Hierarchy, MarkKind, Timeline};
use serde::Serialize;

use super::answer::KnownSpan;
use super::question::{NOBODY, Question};
use super::steps::DueStep;

/// How far the cause of a sleep may lie from it, ns. Both are of one transaction, but for an end: the schemas sleep before
/// the application has ended.
const CAUSE_DISTANCE: Nanos = 1_000_000_000;

/// A group without a winner, because its members sleep.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Asleep<'d> {
    /// The group.
    pub(crate) group: String,
    /// Since when, s since the application's start.
    pub(crate) since_s: f64,
    /// The winner until then.
    pub(crate) loser: Option<String>,
    /// The father that sleeps too, if the group has one.
    pub(crate) father: Option<String>,
    /// The selection in which one of the fathers lost.
    pub(crate) selection: Option<&'d Decision>,
    /// What an operator, a fault or the end of the application did.
    pub(crate) event: Option<&'d Occurrence<String>>,
}

/// What is known of a run.
#[derive(Clone, Copy)]
pub(crate) struct Past<'d> {
    pub(crate) timeline: &'d Timeline,
    pub(crate) decisions: &'d [Decision],
    /// Events of operators, faults and ends.
    pub(crate) events: &'d [Occurrence<String>],
    /// The commands of chunks that came due.
    pub(crate) steps: &'d [DueStep],
    pub(crate) known: KnownSpan,
}

/// Whether an event can be the reason that a schema sleeps.
pub(crate) fn is_cause(event: &Occurrence<String>) -> bool {
    let puts_to_sleep = matches!(
        &event.what,
        What::Operator {
            action: OperatorAction::Stop { .. }
                | OperatorAction::Unload { .. }
                | OperatorAction::Release { .. },
            ..
        }
    );
    puts_to_sleep || matches!(MarkKind::of(&event.what), MarkKind::Fault | MarkKind::Ended)
}

impl Question {
    /// Returns the group that a question about nobody means, if its members sleep at the question's time.
    pub(crate) fn asleep<'d>(&self, past: Past<'d>) -> Option<Asleep<'d>> {
        let asks = self.winner.as_deref() == Some(NOBODY) && !self.negated && self.loser.is_none();
        if !asks {
            return None;
        }
        let at = self.time_s.unwrap_or(past.known.until);
        let hierarchy = past.timeline.hierarchy();
        let groups = hierarchy.groups().iter().enumerate();
        // Below a loser, all groups sleep: without a name, the question is of the roots.
        let is_meant = |name: &str, is_root: bool| match &self.group {
            Some(group) => group == name,
            None => is_root,
        };
        let meant = groups.filter(|(_, group)| is_meant(&group.name, group.father.is_none()));
        // The end of a run says nothing of the time before.
        let has_ended = |asleep: &Asleep<'_>| {
            let cause = asleep.event.map(|event| &event.what);
            self.time_s.is_none() && matches!(cause, Some(What::Ended { .. }))
        };
        meant
            .filter_map(|(place, _)| past.asleep(place, at))
            .filter(|asleep| !has_ended(asleep))
            .max_by(|one, other| one.since_s.total_cmp(&other.since_s))
    }
}

impl<'d> Past<'d> {
    fn asleep(self, group: usize, at_s: f64) -> Option<Asleep<'d>> {
        let hierarchy = self.timeline.hierarchy();
        let about = &hierarchy.groups()[group];
        let slept_since = |member: &usize| {
            let states = &self.timeline.schemas()[*member].states;
            let (interval, _) = states.at_s(at_s)?;
            (interval.value == State::Slept).then_some(interval.from)
        };
        let slept: Option<Vec<Nanos>> = about.members.iter().map(slept_since).collect();
        let slept = slept?.into_iter().max()?;
        let winners = &self.timeline.groups()[group].winners;
        let (since, loser) = match winners.at_s(at_s) {
            Some((nobody, _)) => {
                let before = winners.partition_point(|interval| interval.from < nobody.from);
                let before = before.checked_sub(1).and_then(|place| winners.get(place));
                (nobody.from, before.and_then(|interval| interval.value))
            }
            // It has never had one.
            None => (0, None),
        };
        // Nobody may have been ready before they fell asleep: a selection says that.
        let (since, loser) = match slept > since.saturating_add(CAUSE_DISTANCE) {
            true => (slept, None),
            false => (since, loser),
        };
        let fell = loser.or(about.father);
        let above: Vec<usize> = fell.map_or(Vec::new(), |schema| hierarchy.fathers(schema).collect());
        Some(Asleep {
            group: about.name.clone(),
            since_s: since as f64 / 1e9,
            loser: loser.map(|loser| hierarchy.name(Some(loser)).to_owned()),
            father: about.father.map(|father| hierarchy.name(Some(father)).to_owned()),
            selection: self.selection(hierarchy, &above, since),
            event: self.event(hierarchy, &above, since),
        })
    }

    /// The selection in which one of the schemas lost at a time.
    fn selection(self, hierarchy: &Hierarchy, above: &[usize], time: Nanos) -> Option<&'d Decision> {
        let lost = |decision: &&Decision| {
            let before = decision.before.as_deref().and_then(|name| hierarchy.find(name));
            let is_near = (decision.time_s * 1e9 - time as f64).abs() <= CAUSE_DISTANCE as f64;
            decision.changed && is_near && before.is_some_and(|before| above.contains(&before))
        };
        let lost = self.decisions.iter().filter(lost);
        lost.min_by(|one, other| {
            let distance = |decision: &Decision| (decision.time_s * 1e9 - time as f64).abs();
            distance(one).total_cmp(&distance(other))
        })
    }

    /// What happened to one of the schemas, or to all, about a time.
    fn event(self, hierarchy: &Hierarchy, above: &[usize], time: Nanos) -> Option<&'d Occurrence<String>> {
        let concerns = |event: &&Occurrence<String>| {
            let schema = event.what.schema().and_then(|name| hierarchy.find(name));
            let is_near = event.time.abs_diff(time) <= CAUSE_DISTANCE;
            is_near && schema.is_none_or(|schema| above.contains(&schema))
        };
        let near = self.events.iter().filter(concerns);
        near.min_by_key(|event| event.time.abs_diff(time))
    }
}
