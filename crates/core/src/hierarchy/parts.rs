//! The changing facts of schemas and groups.
//!
//! Data only; no rule is decided here.

use std::hash::{Hash, Hasher};

use super::handover::Handover;
use super::selection::Why;
use crate::spec::{Nanos, SchemaId};
use crate::state::{Health, Requester, Standing, State};

#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) enum Phase {
    Fresh,
    Running,
    Over,
}

/// The changing facts of one schema.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Node {
    pub(super) state: State,
    pub(super) health: Health,
    pub(super) run: Run,
    /// R7: WINNER with all its fathers, and not withdrawn.
    pub(super) authority: bool,
    pub(super) reign: Reign,
    /// Whether its precondition held at its last check; false while it sleeps or its iteration is abandoned.
    pub(super) ready: bool,
    /// Whether it was checked since it woke.
    pub(super) checked: bool,
    pub(super) urgency: Urgency,
    /// Sorted, each once.
    pub(super) requesters: Vec<Requester>,
    /// The perceptive schemas it woke as a father.
    pub(super) woke: Vec<SchemaId>,
    /// An operator stopped it by itself.
    pub(super) stopped: bool,
    /// An operator stopped everything, it among it.
    pub(super) stopped_with_all: bool,
    /// When it was restarted, the latest last: those that its restart policy counts still, and perhaps older ones.
    pub(super) restarts: Vec<Nanos>,
}

/// How far a schema with authority is in taking over the commands that were given before.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) enum Reign {
    /// It has not begun an iteration.
    New,
    /// It is in its first one.
    First,
    /// It has ended one, or has no authority.
    Settled,
}

/// Where a schema is with respect to its iteration.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) enum Run {
    Between,
    Iterating,
    /// It iterates still, but lost its place or was put to sleep meanwhile.
    Abandoned,
}

/// The changing facts of one group.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Group {
    /// The member whose state is WINNER.
    pub(super) winner: Option<SchemaId>,
    /// Away from the winner; there is none without a winner.
    pub(super) handover: Option<Handover>,
    pub(super) asked: Option<Asked>,
    pub(super) standing: Standing,
    /// When the present choice was made.
    pub(super) since: Nanos,
    /// The last one chosen, for round robin.
    pub(super) last: Option<SchemaId>,
    pub(super) forced: Option<SchemaId>,
    /// The winner was promoted by this and has not begun an iteration yet.
    pub(super) taking: Option<Origin>,
    /// Who was chosen and fell out before a selection could say so.
    pub(super) lost: Option<SchemaId>,
}

/// The selection that a promotion carries out.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Origin {
    pub(super) record: u64,
    pub(super) cause_time: Nanos,
}

/// An open question to the father.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Asked {
    pub(super) ticket: u64,
    pub(super) case: crate::record::Case,
    /// Whom the father may name.
    pub(super) offered: Vec<SchemaId>,
    pub(super) why: Why,
    /// The first trigger that came after the question.
    pub(super) again: Option<Why>,
    /// If no answer comes in time, that is not the father's fault.
    pub(super) excused: bool,
}

/// A number without NaN and without a negative zero, so that it can be compared and hashed to the bit.
#[derive(Copy, Clone, Debug)]
pub(super) struct Urgency(f64);

impl Node {
    /// Whether it is to be awake: somebody wants it, and neither an operator nor a fault keeps it down.
    pub(super) fn wanted(&self) -> bool {
        !self.requesters.is_empty() && !self.is_stopped() && !matches!(self.health, Health::Faulted(_))
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stopped || self.stopped_with_all
    }
}

impl Default for Node {
    fn default() -> Self {
        Self {
            state: State::Slept,
            health: Health::Ok,
            run: Run::Between,
            authority: false,
            reign: Reign::Settled,
            ready: false,
            checked: false,
            urgency: Urgency::new(0.0),
            requesters: Vec::new(),
            woke: Vec::new(),
            stopped: false,
            stopped_with_all: false,
            restarts: Vec::new(),
        }
    }
}

impl Default for Group {
    fn default() -> Self {
        Self {
            winner: None,
            handover: None,
            asked: None,
            standing: Standing::Fresh,
            since: 0,
            last: None,
            forced: None,
            taking: None,
            lost: None,
        }
    }
}

impl Group {
    /// Who is chosen at present: whom a handover goes to, else the winner.
    pub(super) fn choice(&self) -> Option<SchemaId> {
        match self.handover {
            Some(handover) => handover.to,
            None => self.winner,
        }
    }

    /// Notes who was chosen before somebody fell out, if that is over: the next record tells of it (R15).
    pub(super) fn lose(&mut self, before: Option<SchemaId>) {
        if self.choice() != before {
            self.lost = before;
        }
    }
}

impl Urgency {
    pub(super) fn new(offered: f64) -> Self {
        // Adding 0 turns the negative zero into the positive one.
        Self(if offered.is_nan() {
            f64::NEG_INFINITY
        } else {
            offered + 0.0
        })
    }

    pub(super) fn get(self) -> f64 {
        self.0
    }
}

impl PartialEq for Urgency {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bits() == other.0.to_bits()
    }
}

impl Eq for Urgency {}

impl Hash for Urgency {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.to_bits().hash(state);
    }
}
