//! The ready-made policies (R4): pure functions from the ready candidates to one of them.
//!
//! They settle collisions only; they know neither authority nor time beyond what they are given.

use crate::record::Candidate;
use crate::spec::{Nanos, Policy, SchemaId};

/// What a policy may look at.
#[derive(Copy, Clone)]
pub(super) struct Field<'a> {
    /// The awake members in the father's order; at least one is ready.
    pub(super) candidates: &'a [Candidate],
    /// The place of the first that is ready.
    pub(super) first: Option<usize>,
    /// All members in the father's order.
    pub(super) members: &'a [SchemaId],
    /// Who is chosen at present.
    pub(super) chosen: Option<SchemaId>,
    /// When it was chosen.
    pub(super) since: Nanos,
    /// Who was chosen last, at present or before.
    pub(super) last: Option<SchemaId>,
    pub(super) now: Nanos,
}

/// A choice and the reason for it; `None` only if nobody is ready.
pub(super) type Choice = Option<(SchemaId, &'static str)>;

impl Field<'_> {
    /// Chooses by `policy`; by the father's order if that is for the father to say.
    pub(super) fn choose(&self, policy: Policy) -> Choice {
        match policy {
            Policy::Priority | Policy::Father => self.first(),
            Policy::HighestUrgency => self.most_urgent(),
            Policy::Sticky { dwell, hysteresis } => self.sticky(dwell, hysteresis),
            Policy::RoundRobin { turn } => self.round_robin(turn),
        }
    }

    /// When the choice could change although nothing happens: the end of a dwell time or turn that is still running,
    /// if another would be chosen then.
    pub(super) fn turn_end(&self, policy: Policy) -> Option<Nanos> {
        let stay = match policy {
            Policy::Sticky { dwell, .. } => dwell,
            Policy::RoundRobin { turn } => turn,
            Policy::Priority | Policy::HighestUrgency | Policy::Father => return None,
        };
        let end = self.since.saturating_add(stay);
        let then = Field { now: end, ..*self }.choose(policy).map(|(id, _)| id);
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

    /// The first in the father's order among the most urgent.
    fn top(&self) -> Option<&Candidate> {
        self.ready()
            .reduce(|top, c| if c.urgency > top.urgency { c } else { top })
    }
}
