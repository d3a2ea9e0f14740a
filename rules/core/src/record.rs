//! The record of a selection (R15): the snapshot, the decider and the reason.
//!
//! It refuses to store history: the hierarchy emits each record once and keeps none.

use std::borrow::Cow;
use std::sync::Arc;

use crate::hierarchy::Timer;
use crate::policy::Policy;
use crate::spec::{GroupId, Nanos, SchemaId};
use crate::state::State;

/// One selection: the snapshot that it used, the choice, and the reason.
#[derive(Clone, PartialEq, Debug)]
pub struct Record {
    /// Counts the selections of the whole hierarchy, from 1.
    pub number: u64,
    /// When the selection was made.
    pub time: Nanos,
    /// When the situation that led to the selection began; never after `time`.
    pub cause_time: Nanos,
    /// The group.
    pub group: GroupId,
    /// The situation.
    pub case: Case,
    /// The awake members, in the father's order, as they were before the selection. Consecutive records of a
    /// group that did not change share this list.
    pub candidates: Arc<[Candidate]>,
    /// The choice before: the winner, or the target of a handover under way. It is also given if
    /// that member left the group before this selection.
    pub before: Option<SchemaId>,
    /// The choice now.
    pub choice: Option<SchemaId>,
    /// The decider.
    pub decider: Decider,
    /// The reason, as text.
    pub reason: Cow<'static, str>,
    /// The cause of the selection.
    pub cause: Cause,
    /// Whether the choice differs from the one before.
    pub changed: bool,
}

/// The situation of a group (R3).
#[derive(Copy, Clone, Default, PartialEq, Eq, Hash, Debug)]
pub enum Case {
    /// Exactly one member is READY.
    #[default]
    Alone,
    /// Two or more members are READY.
    Collision,
    /// No member is READY.
    Absence,
    /// An operator forces a member (R14).
    Forced,
}

impl Case {
    /// All cases.
    pub const ALL: [Self; 4] = [Self::Alone, Self::Collision, Self::Absence, Self::Forced];

    /// Returns the name that records use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Alone => "alone",
            Self::Collision => "collision",
            Self::Absence => "absence",
            Self::Forced => "forced",
        }
    }

    /// Returns the case of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|case| case.name() == name)
    }
}

impl core::fmt::Display for Case {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
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
    /// The urgency that it offered; a NaN is replaced by minus infinity.
    pub urgency: f64,
}

/// The decider of a selection.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Decider {
    /// There was nothing to decide.
    Nobody,
    /// A ready-made policy.
    Policy(Policy),
    /// The father's own arbitration.
    Father,
    /// The father's own arbitration failed, or the father sleeps while an operator plays the members. The
    /// priority order decided a collision, the absence policy every other case.
    ArbitrationFailed,
    /// The absence policy of the group.
    AbsencePolicy,
    /// An operator.
    Operator,
}

impl Decider {
    /// Returns the name that records use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Nobody => "nobody",
            Self::Policy(policy) => policy.name(),
            Self::Father => "father",
            Self::ArbitrationFailed => "arbitration-failed",
            Self::AbsencePolicy => "absence-policy",
            Self::Operator => "operator",
        }
    }
}

/// The cause of a selection (R2).
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Cause {
    /// The application started.
    Start,
    /// The readiness of this schema changed, or became known.
    Readiness(SchemaId),
    /// This schema was woken.
    Woken(SchemaId),
    /// This schema was put to sleep.
    Slept(SchemaId),
    /// This schema faulted.
    Faulted(SchemaId),
    /// This schema ended an iteration.
    Iterated(SchemaId),
    /// A guard refused a command of this schema (R18).
    Refused(SchemaId),
    /// The father changed the policy of the group.
    PolicyChanged,
    /// An operator played, stopped, forced or released this schema. If an operator stopped all schemas, it
    /// is the choice before, or else the first member of the group.
    Operator(SchemaId),
    /// A timer fired.
    Timer(Timer),
}
