//! The record that every selection leaves behind (R15): what was seen, who decided, and why.
//!
//! It refuses to be the memory of the past: the hierarchy hands each record out once and keeps none.

use std::borrow::Cow;
use std::sync::Arc;

use crate::hierarchy::Timer;
use crate::spec::{GroupId, Nanos, Policy, SchemaId};
use crate::state::State;

/// One selection: the snapshot it was made over, the choice, and the reason.
#[derive(Clone, PartialEq, Debug)]
pub struct Record {
    /// Counts the selections of the whole hierarchy, from 1.
    pub number: u64,
    /// When it was made.
    pub time: Nanos,
    /// When the situation that led to it came to be; never after `time`.
    pub cause_time: Nanos,
    /// The group.
    pub group: GroupId,
    /// The situation.
    pub case: Case,
    /// The awake members, in the father's order, as they were before the selection. Records of a group that did not change between
    /// them share it.
    pub candidates: Arc<[Candidate]>,
    /// Who was chosen before: the winner, or the one a handover under way goes to.
    pub before: Option<SchemaId>,
    /// Who is chosen now.
    pub choice: Option<SchemaId>,
    /// Who decided.
    pub decider: Decider,
    /// Why, in words.
    pub reason: Cow<'static, str>,
    /// What led to the selection.
    pub cause: Cause,
    /// Whether the choice differs from the one before.
    pub changed: bool,
}

/// The situation of a group (R3).
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Case {
    /// Exactly one is ready.
    Alone,
    /// Two or more are ready.
    Collision,
    /// Nobody is ready.
    Absence,
    /// An operator forces one (R14).
    Forced,
}

/// One awake member of a group in a snapshot.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Candidate {
    /// The member.
    pub id: SchemaId,
    /// Its state before the selection.
    pub state: State,
    /// Whether its precondition held at its last check.
    pub ready: bool,
    /// The urgency it offered; a NaN was turned into minus infinity.
    pub urgency: f64,
}

/// Who decided a selection.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Decider {
    /// There was nothing to decide.
    Nobody,
    /// A ready-made policy.
    Policy(Policy),
    /// The father's own arbitration.
    Father,
    /// The father's arbitration failed: the priority order decided for a collision, the absence policy otherwise.
    ArbitrationFailed,
    /// The absence policy of the group.
    AbsencePolicy,
    /// An operator.
    Operator,
}

/// What led to a selection (R2).
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Cause {
    /// The application started.
    Start,
    /// The readiness of this one changed, or became known.
    Readiness(SchemaId),
    /// This one was woken.
    Woken(SchemaId),
    /// This one was put to sleep.
    Slept(SchemaId),
    /// This one faulted.
    Faulted(SchemaId),
    /// This one ended an iteration.
    Iterated(SchemaId),
    /// The father changed the policy of the group.
    PolicyChanged,
    /// An operator played, stopped, forced or released this one.
    Operator(SchemaId),
    /// A timer fired.
    Timer(Timer),
}
