//! What an application says before it starts: schemas, groups and their policies.
//!
//! Plain data with dense identifiers; it refuses to hold anything that changes by the rules (states, winners).

/// Nanoseconds since the application's start.
pub type Nanos = u64;

/// The patience of a group that states none: 5 ms, a twentieth of the usual 100 ms period, so that a
/// loser nearly always ends its iteration by itself and a hung one costs less than a tenth of a period.
pub const DEFAULT_PATIENCE: Nanos = 5_000_000;

/// The time a father has to arbitrate when it states none: 5 ms, for the same reason.
pub const DEFAULT_BUDGET: Nanos = 5_000_000;

/// Names a schema by its index in [`Spec::schemas`].
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct SchemaId(
    /// The index.
    pub u32,
);

/// Names a group by its index in [`Spec::groups`].
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct GroupId(
    /// The index.
    pub u32,
);

impl SchemaId {
    /// The index as a `usize`.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl GroupId {
    /// The index as a `usize`.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// Describes all schemas of an application and the groups in which its motor schemas compete.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Spec {
    /// The schemas; a [`SchemaId`] is an index into this list.
    pub schemas: Vec<SchemaSpec>,
    /// The groups; a [`GroupId`] is an index into this list.
    pub groups: Vec<GroupSpec>,
}

/// Describes one schema.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SchemaSpec {
    /// Its name in the application; unique.
    pub name: String,
    /// Whether it competes.
    pub kind: Kind,
    /// The perceptive schemas and drivers whose exports it imports or which it commands: awake while it is awake (R6).
    pub needs: Vec<SchemaId>,
    /// What follows a fault.
    pub restart: Restart,
    /// Time from one iteration to the next; not 0.
    pub period: Nanos,
    /// The longest iteration it declares; enters the contract (R17).
    pub budget: Nanos,
    /// Whether a publication re-evaluates its precondition, without waiting for its period (R12).
    pub triggered: bool,
    /// Whether it has a panel, which it draws on its own turn while somebody looks, within its budget.
    pub panel: bool,
}

/// Whether a schema competes for WINNER.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Kind {
    /// Turns data into better data, or drives hardware; WINNER whenever awake.
    Perceptive,
    /// Has a precondition, competes in a group, commands actuators or wakes children.
    Motor,
}

/// What follows a fault of a schema.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Restart {
    /// It stays SLEPT.
    Never,
    /// It may wake again after a back-off that doubles with every restart that counts still.
    OnFault {
        /// The first back-off.
        backoff: Nanos,
        /// How many restarts it gets
        limit: u32,
        /// in so long; one more fault and it stays down until an operator clears that.
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
    /// Who decides a collision.
    pub policy: Policy,
    /// What follows when nobody wins (R9).
    pub absence: Absence,
    /// How long a loser may take to step down before its authority is withdrawn (R1).
    pub patience: Nanos,
    /// How long the father's own arbitration may take (R4).
    pub budget: Nanos,
}

/// How a group settles a collision (R4).
#[derive(Copy, Clone, Debug)]
pub enum Policy {
    /// The first of the ready in the father's order.
    Priority,
    /// The ready one with the highest urgency; who is already chosen wins a tie, then the father's order.
    HighestUrgency,
    /// The chosen one stays until its dwell time is over and a challenger is more urgent by the margin.
    Sticky {
        /// The least time the chosen one stays while it is ready.
        dwell: Nanos,
        /// The urgency by which a challenger must exceed the chosen one; finite, not negative.
        hysteresis: f64,
    },
    /// Each ready one in turn, in the father's order.
    RoundRobin {
        /// The length of a turn; not 0.
        turn: Nanos,
    },
    /// The father's own function; asked on collision and on absence.
    Father,
}

/// What follows when nobody wins a group (R9).
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Absence {
    /// The neutral value goes to every actuator last commanded from this group or below it.
    Brake,
    /// The last command stands for a while, then the group brakes.
    Hold {
        /// How long it stands.
        for_: Nanos,
    },
    /// This member wins although its precondition is false; if it is not awake, the group brakes.
    Fallback(SchemaId),
}

impl SchemaSpec {
    /// A schema that needs nobody, is not restarted and re-checks at its period.
    #[must_use]
    pub fn new(name: impl Into<String>, kind: Kind, period: Nanos) -> Self {
        Self {
            name: name.into(),
            kind,
            needs: Vec::new(),
            restart: Restart::Never,
            period,
            budget: 0,
            triggered: false,
            panel: false,
        }
    }
}

impl GroupSpec {
    /// A group decided by the father's order, which brakes on absence, with the default patience and budget.
    #[must_use]
    pub fn new(name: impl Into<String>, father: Option<SchemaId>, members: Vec<SchemaId>) -> Self {
        Self {
            name: name.into(),
            father,
            members,
            policy: Policy::Priority,
            absence: Absence::Brake,
            patience: DEFAULT_PATIENCE,
            budget: DEFAULT_BUDGET,
        }
    }
}

impl Policy {
    fn key(self) -> (u8, Nanos, u64) {
        match self {
            Self::Priority => (0, 0, 0),
            Self::HighestUrgency => (1, 0, 0),
            Self::Sticky { dwell, hysteresis } => (2, dwell, hysteresis.to_bits()),
            Self::RoundRobin { turn } => (3, turn, 0),
            Self::Father => (4, 0, 0),
        }
    }
}

/// Equal when all numbers are equal to the bit, so that the relation is total.
impl PartialEq for Policy {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Policy {}
