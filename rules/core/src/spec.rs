//! The specification that an application states before it starts: schemas, groups and their policies.
//!
//! Plain data with dense identifiers. It refuses to hold anything that the rules change (states, winners).

use std::time::Duration;

use crate::policy::Policy;
use crate::table::{Id, Table};

/// Nanoseconds since the application's start.
pub type Nanos = u64;

/// Returns a duration in nanoseconds; the greatest number for one that is too long.
pub(crate) const fn nanos(time: Duration) -> Nanos {
    let nanos = time.as_nanos();
    if nanos > u64::MAX as u128 {
        u64::MAX
    } else {
        nanos as u64
    }
}

/// The patience of a group that states none: 5 ms, a twentieth of the usual period of 100 ms. A loser nearly
/// always ends its iteration in that time, and a hung one costs less than a tenth of a period.
pub const DEFAULT_PATIENCE: Nanos = 5_000_000;

/// The arbitration budget of a group that states none: 5 ms, for the same reason.
pub const DEFAULT_BUDGET: Nanos = 5_000_000;

/// How long a refused schema of a group that states no time is not READY: 500 ms, five usual periods. The next
/// candidate acts meanwhile, and a person waits no longer for the robot once the way is free.
pub const DEFAULT_RETRY: Nanos = 500_000_000;

/// Identifies a schema by its index in [`Spec::schemas`].
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct SchemaId(
    /// The index.
    pub u32,
);

/// Identifies a group by its index in [`Spec::groups`].
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct GroupId(
    /// The index.
    pub u32,
);

impl Id for SchemaId {
    fn new(index: usize) -> Self {
        Self(index as u32)
    }

    #[inline]
    fn index(self) -> usize {
        self.0 as usize
    }
}

impl Id for GroupId {
    fn new(index: usize) -> Self {
        Self(index as u32)
    }

    #[inline]
    fn index(self) -> usize {
        self.0 as usize
    }
}

/// Describes all schemas of an application and the groups in which its motor schemas compete.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Spec {
    /// The schemas.
    pub schemas: Table<SchemaId, SchemaSpec>,
    /// The groups.
    pub groups: Table<GroupId, GroupSpec>,
}

/// Describes one schema.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SchemaSpec {
    /// Its name in the application; unique.
    pub name: String,
    /// Whether it competes.
    pub kind: Kind,
    /// The perceptive schemas and drivers that it imports from or commands. They are awake while it is awake
    /// (R6).
    pub needs: Vec<SchemaId>,
    /// Those of `needs` that it only commands. An operator who stops it needs all others still.
    pub only_commands: Vec<SchemaId>,
    /// What happens after a fault.
    pub restart: Restart,
    /// Time from one iteration to the next, in nanoseconds; not 0.
    pub period: Nanos,
    /// The longest time that one iteration is declared to take. It enters the contract (R17).
    pub budget: Nanos,
    /// Whether a publication re-evaluates its precondition without waiting for its period (R12).
    pub triggered: bool,
    /// Whether it has a panel. It draws the panel in its own turn and within its budget, while a viewer shows
    /// it.
    pub panel: bool,
}

/// Whether a schema competes for WINNER.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Kind {
    /// Turns data into better data, or drives hardware. It is WINNER whenever it is awake.
    Perceptive,
    /// Has a precondition, competes in a group, and commands actuators or wakes children.
    Motor,
}

/// What happens after a fault of a schema.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Restart {
    /// The schema stays SLEPT.
    Never,
    /// The schema may wake again after a back-off, which doubles with every restart that still counts.
    OnFault {
        /// The first back-off.
        backoff: Nanos,
        /// The number of restarts that are allowed within `within`.
        limit: u32,
        /// The time over which restarts count. After one more fault the schema stays SLEPT until an operator
        /// clears the fault.
        within: Nanos,
    },
}

/// Describes one competition among motor children of one father.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct GroupSpec {
    /// Its name; unique among the groups.
    pub name: String,
    /// The father; `None` for a level of the application's roots (R13).
    pub father: Option<SchemaId>,
    /// The members in the father's order, which is the priority order.
    pub members: Vec<SchemaId>,
    /// How a collision is decided.
    pub policy: Policy,
    /// What happens when no member wins (R9).
    pub absence: Absence,
    /// How long a loser may delay the handover before its authority is withdrawn (R1).
    pub patience: Nanos,
    /// How long the father's own arbitration may take (R4).
    pub budget: Nanos,
    /// How long a member is not READY after a guard has refused a command of it (R18).
    pub retry: Nanos,
}

/// What happens when no member of a group wins (R9).
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Absence {
    /// The neutral value is sent to every actuator that was last commanded from this group or below it.
    Brake,
    /// The last command stays in force for a time, then the group brakes.
    Hold {
        /// How long the last command stays in force.
        for_: Nanos,
    },
    /// This member wins although its precondition is false. If it sleeps, or an abandoned iteration of it
    /// still runs, the group brakes.
    Fallback(SchemaId),
}

impl SchemaSpec {
    /// Returns a schema without needs, without restarts and without triggers.
    #[must_use]
    pub fn new(name: impl Into<String>, kind: Kind, period: Nanos) -> Self {
        Self {
            name: name.into(),
            kind,
            needs: Vec::new(),
            only_commands: Vec::new(),
            restart: Restart::Never,
            period,
            budget: 0,
            triggered: false,
            panel: false,
        }
    }
}

impl GroupSpec {
    /// Returns a group with the policy priority, which brakes on absence, with the default patience,
    /// budget and retry.
    #[must_use]
    pub fn new(name: impl Into<String>, father: Option<SchemaId>, members: Vec<SchemaId>) -> Self {
        Self {
            name: name.into(),
            father,
            members,
            policy: Policy::PRIORITY,
            absence: Absence::Brake,
            patience: DEFAULT_PATIENCE,
            budget: DEFAULT_BUDGET,
            retry: DEFAULT_RETRY,
        }
    }
}
