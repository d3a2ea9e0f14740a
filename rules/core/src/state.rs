//! The visible facts of a schema and a group: state, health, requesters, operators' holds and standing.
//!
//! Values only; the transitions are in the hierarchy.

use crate::spec::SchemaId;

/// The activation state of a schema.
#[derive(Copy, Clone, Default, PartialEq, Eq, Hash, Debug)]
pub enum State {
    /// Uses no processor time and keeps its memory.
    #[default]
    Slept,
    /// Awake. Its precondition is false, or not checked yet, or a guard has refused its command (R18).
    Checking,
    /// Awake. Its precondition is true, and it was not chosen.
    Ready,
    /// Iterates. A motor schema may command and wake children if all its fathers are WINNER too.
    Winner,
}

impl State {
    /// All states.
    pub const ALL: [Self; 4] = [Self::Slept, Self::Checking, Self::Ready, Self::Winner];

    /// Returns the name, as in the paper.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Slept => "SLEPT",
            Self::Checking => "CHECKING",
            Self::Ready => "READY",
            Self::Winner => "WINNER",
        }
    }
}

/// The condition of a schema, independent of its state.
#[derive(Clone, Default, PartialEq, Eq, Hash, Debug)]
pub enum Health {
    /// Nothing to report.
    #[default]
    Ok,
    /// The schema missed its deadline.
    Overrun,
    /// Its own arbitration failed, with the reason: it panicked, returned an error, chose a schema that it
    /// was not offered, or exceeded its budget. The schema stays awake. Its next valid reply clears this.
    ArbitrationFailed(String),
    /// The schema panicked, returned an error, hung, or its process died, with the reason. It is SLEPT until
    /// its restart.
    Faulted(String),
}

/// The origin of a request to be awake. Each counts once (R6).
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Requester {
    /// The application, for its roots.
    Application,
    /// A father that woke the schema.
    Father(SchemaId),
    /// An awake schema that imports from the schema or commands it.
    Need(SchemaId),
    /// An operator that plays the schema.
    Operator,
    /// An operator that stopped this schema, which needed it or has schemas below that did.
    Stopped(SchemaId),
}

/// Who holds: an operator until somebody ends it, or one lease.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Holder {
    /// The operator, as the caller numbers them, from 1.
    pub operator: u32,
    /// Whether under a lease. An operator has at most one lease on a schema.
    pub leased: bool,
}

impl Holder {
    /// The holder of all actions in a recording that does not name them. Its stops keep nothing awake.
    pub const UNKNOWN: Self = Self::lasting(0);

    /// An operator without a lease.
    #[must_use]
    pub const fn lasting(operator: u32) -> Self {
        Self {
            operator,
            leased: false,
        }
    }

    /// A lease of an operator.
    #[must_use]
    pub const fn leased(operator: u32) -> Self {
        Self {
            operator,
            leased: true,
        }
    }
}

/// One action of an operator that is in force on a schema (R14).
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct Hold {
    /// Who holds.
    pub by: Holder,
    /// What is held.
    pub action: HoldAction,
}

/// What an operator holds a schema to.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum HoldAction {
    /// Asleep and without an instance.
    Unloaded,
    /// Asleep, together with all others.
    StoppedWithAll,
    /// Asleep.
    Stopped,
    /// The winner of its group while it is awake.
    Forced,
    /// Awake.
    Played,
}

impl HoldAction {
    /// Whether it keeps the schema asleep.
    #[must_use]
    pub fn stops(self) -> bool {
        match self {
            Self::Unloaded | Self::StoppedWithAll | Self::Stopped => true,
            Self::Forced | Self::Played => false,
        }
    }
}

/// What the actuators do on behalf of a group.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum ActuationState {
    /// No member has won since the father woke the first member.
    Fresh,
    /// A member is WINNER.
    Commanding,
    /// No member is WINNER; the last commands stay in force.
    Holding,
    /// No member is WINNER; the group has braked.
    Braked,
}
