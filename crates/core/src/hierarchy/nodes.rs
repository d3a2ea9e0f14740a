//! The changing facts of schemas and groups.
//!
//! Data only; it refuses to decide a rule.

use std::hash::{Hash, Hasher};

use super::handover::Handover;
use super::selection::TimedCause;
use crate::spec::{Nanos, SchemaId};
use crate::state::{ActuationState, Health, Requester, State};

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
    pub(super) run: RunState,
    /// R7: it and all its fathers are WINNER, and its authority is not withdrawn.
    pub(super) authority: bool,
    pub(super) takeover_phase: TakeoverPhase,
    /// Whether its precondition was true at its last check; false while it sleeps or its iteration is
    /// abandoned.
    pub(super) ready: bool,
    /// Whether it has checked since it woke.
    pub(super) checked: bool,
    pub(super) urgency: Urgency,
    /// Sorted, each once.
    pub(super) requesters: Vec<Requester>,
    /// The perceptive schemas that it woke as a father.
    pub(super) woken: Vec<SchemaId>,
    /// An operator stopped this schema alone.
    pub(super) stopped: bool,
    /// An operator stopped all schemas, including this one.
    pub(super) stopped_with_all: bool,
    /// The times of its restarts, in order: those that still count under its restart policy, and possibly
    /// older ones.
    pub(super) restarts: Vec<Nanos>,
}

/// The progress of a schema with authority in the takeover of earlier commands.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) enum TakeoverPhase {
    /// It has not begun an iteration.
    New,
    /// It is in its first iteration.
    First,
    /// It has ended an iteration, or has no authority.
    Settled,
}

/// The relation of a schema to its iteration.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) enum RunState {
    Between,
    Iterating,
    /// It still iterates, but was replaced or put to sleep during the iteration.
    Abandoned,
}

/// The changing facts of one group.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Group {
    /// The member whose state is WINNER.
    pub(super) winner: Option<SchemaId>,
    /// The handover away from the winner; `None` without a winner.
    pub(super) handover: Option<Handover>,
    pub(super) pending: Option<PendingArbitration>,
    pub(super) actuation: ActuationState,
    /// When the current choice was made.
    pub(super) since: Nanos,
    /// The last member that was chosen, for round robin.
    pub(super) last: Option<SchemaId>,
    pub(super) forced: Option<SchemaId>,
    /// The selection that promoted the winner, until the winner begins an iteration.
    pub(super) takeover: Option<Origin>,
    /// The choice that an event has ended since the last record.
    pub(super) lost: Option<SchemaId>,
}

/// The selection that a promotion carries out.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Origin {
    pub(super) record: u64,
    pub(super) cause_time: Nanos,
}

/// An open arbitration request to the father.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct PendingArbitration {
    pub(super) ticket: u64,
    pub(super) case: crate::record::Case,
    /// The members that the father may choose.
    pub(super) candidates: Vec<SchemaId>,
    pub(super) trigger: TimedCause,
    /// The first trigger after the request.
    pub(super) retrigger: Option<TimedCause>,
    /// Whether the machine and not the father causes a missing reply.
    pub(super) excused: bool,
}

/// A number without NaN and without negative zero, so it can be compared and hashed to the bit.
#[derive(Copy, Clone, Debug)]
pub(super) struct Urgency(f64);

impl Node {
    /// Whether it should be awake: it has a requester, and neither an operator nor a fault keeps it asleep.
    pub(super) fn should_be_awake(&self) -> bool {
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
            run: RunState::Between,
            authority: false,
            takeover_phase: TakeoverPhase::Settled,
            ready: false,
            checked: false,
            urgency: Urgency::new(0.0),
            requesters: Vec::new(),
            woken: Vec::new(),
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
            pending: None,
            actuation: ActuationState::Fresh,
            since: 0,
            last: None,
            forced: None,
            takeover: None,
            lost: None,
        }
    }
}

impl Group {
    /// Returns the current choice: the target of a handover, else the winner.
    pub(super) fn choice(&self) -> Option<SchemaId> {
        match self.handover {
            Some(handover) => handover.to,
            None => self.winner,
        }
    }

    /// Records the choice `before` an event if the event ended it, for the next record (R15).
    pub(super) fn lose(&mut self, before: Option<SchemaId>) {
        if self.choice() != before {
            self.lost = before;
        }
    }
}

impl Urgency {
    pub(super) fn new(value: f64) -> Self {
        // Adding 0 turns negative zero into positive zero.
        Self(if value.is_nan() {
            f64::NEG_INFINITY
        } else {
            value + 0.0
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
