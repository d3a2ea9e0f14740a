//! The ready-made policies (R4): pure functions from the READY candidates to one of them.
//!
//! They settle collisions only. They refuse to use authority, and any time other than the given one.

use crate::record::Candidate;
use crate::spec::{Nanos, Policy, SchemaId};

/// The input of a policy.
#[derive(Copy, Clone)]
pub(super) struct PolicyInput<'a> {
    /// The awake members in the father's order; at least one is READY.
    pub(super) candidates: &'a [Candidate],
    /// The index of the first READY candidate.
    pub(super) first: Option<usize>,
    /// All members in the father's order.
    pub(super) members: &'a [SchemaId],
    /// The present choice.
    pub(super) chosen: Option<SchemaId>,
    /// When the present choice was made.
    pub(super) since: Nanos,
    /// The last choice, present or past.
    pub(super) last: Option<SchemaId>,
    pub(super) now: Nanos,
}

/// A choice and its reason; `None` only if no candidate is READY.
pub(super) type Choice = Option<(SchemaId, &'static str)>;

impl PolicyInput<'_> {
    /// Chooses by `policy`. [`Policy::Father`] falls back to the father's order.
    pub(super) fn choose(&self, policy: Policy) -> Choice {
        match policy {
            Policy::Priority | Policy::Father => self.first(),
            Policy::HighestUrgency => self.most_urgent(),
            Policy::Sticky { dwell, hysteresis } => self.sticky(dwell, hysteresis),
            Policy::RoundRobin { turn } => self.round_robin(turn),
        }
    }

    /// Returns when the choice could change without an event: the end of a running dwell time or turn, if
    /// another candidate would be chosen then.
    pub(super) fn turn_end(&self, policy: Policy) -> Option<Nanos> {
        let stay = match policy {
            Policy::Sticky { dwell, .. } => dwell,
            Policy::RoundRobin { turn } => turn,
            Policy::Priority | Policy::HighestUrgency | Policy::Father => return None,
        };
        let end = self.since.saturating_add(stay);
        let then = PolicyInput { now: end, ..*self }.choose(policy).map(|(id, _)| id);
        (end > self.now && self.chosen.is_some() && then != self.chosen).then_some(end)
    }

    fn ready(&self) -> impl Iterator<Item = &Candidate> {
        self.candidates.iter().filter(|c| c.ready)
    }

    fn incumbent(&self) -> Option<&Candidate> {
        self.ready().find(|c| Some(c.id) == self.chosen)
    }

    fn first(&self) -> Choice {
        let first = self.candidates.get(self.first?)?;
        Some((first.id, "the first of the ready in the father's order"))
    }

    fn most_urgent(&self) -> Choice {
        let top = self.top()?;
        match self.incumbent() {
            Some(incumbent) if incumbent.urgency >= top.urgency => {
                Some((incumbent.id, "nobody is more urgent than the one already chosen"))
            }
            Some(_) | None => Some((top.id, "the most urgent of the ready")),
        }
    }

    fn sticky(&self, dwell: Nanos, hysteresis: f64) -> Choice {
        let top = self.top()?;
        let Some(incumbent) = self.incumbent() else {
            return Some((
                top.id,
                "the most urgent of the ready; the one before is not ready",
            ));
        };
        let margin = top.urgency - incumbent.urgency;
        if self.now.saturating_sub(self.since) < dwell {
            Some((incumbent.id, "already chosen, and its dwell time is not over"))
        } else if margin > 0.0 && margin >= hysteresis {
            Some((top.id, "more urgent by the margin than the one before"))
        } else {
            Some((
                incumbent.id,
                "already chosen, and nobody is more urgent by the margin",
            ))
        }
    }

    fn round_robin(&self, turn: Nanos) -> Choice {
        if let Some(incumbent) = self.incumbent()
            && self.now.saturating_sub(self.since) < turn
        {
            return Some((incumbent.id, "its turn is not over"));
        }
        let after = self
            .last
            .and_then(|last| self.members.iter().position(|&m| m == last));
        let start = after.map_or(0, |at| at + 1);
        let in_turn = self.members.iter().cycle().skip(start).take(self.members.len());
        in_turn
            .filter_map(|&m| self.ready().find(|c| c.id == m))
            .map(|c| (c.id, "its turn has come"))
            .next()
    }

    /// Returns the first in the father's order among the most urgent.
    fn top(&self) -> Option<&Candidate> {
        self.ready()
            .reduce(|top, c| if c.urgency > top.urgency { c } else { top })
    }
}
