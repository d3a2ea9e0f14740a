//! The running hierarchy: which schemas are awake, compete, win and hold authority at this instant.
//!
//! One value, driven by one caller at a time; every method is one transaction (R2). It refuses to act: it
//! returns effects. The facts of schemas and groups, their timers and their evaluation are types of their own
//! ([`Nodes`], [`Group`], [`Timers`], `Snapshot`), which do not know the hierarchy; the hierarchy composes
//! them along the tree ([`SpecIndex`]).
//!
//! These invariants hold between any two calls:
//!
//! - at most one member of a group is WINNER, and it is the group's `winner` (R1);
//! - authority is held by exactly those WINNERs whose fathers all hold it, without being held by a debugger,
//!   or whose group is one of roots (R7);
//! - a schema sleeps exactly if it has no requester, an operator stopped it, or it is faulted (R6), except
//!   for a WINNER that should no longer be awake, which sleeps when its iteration has ended;
//! - a motor schema inside an abandoned iteration is neither READY nor WINNER.

mod arbitration;
mod authority;
mod candidates;
mod group;
mod handover;
mod holds;
mod iteration;
mod last_check;
mod node;
mod nodes;
mod operator;
mod promotion;
mod query;
mod refusal;
mod restart;
mod restarts;
mod selection;
mod sleep;
mod snapshot;
mod spec_index;
mod timer;
mod transaction;
mod wake;
mod winner;

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use crate::refused::Refused;
use crate::spec::{GroupId, Nanos, SchemaId, Spec};
use crate::spec_error::SpecError;
use crate::table::Table;

pub use arbitration::ArbitrationReply;

pub use iteration::Check;
pub use operator::Operator;
pub use timer::Timer;
pub use transaction::Transaction;
pub use winner::Handover;

use group::Group;
use node::Node;
use nodes::Nodes;
use restarts::Restarts;
use spec_index::SpecIndex;
use timer::Timers;

static UNKNOWN_GROUP: Group = Group::FRESH;

#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
enum Phase {
    Fresh,
    Running,
    Over,
}

/// The pure state machine of an application; see the crate's documentation.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Hierarchy {
    plan: Arc<SpecIndex>,
    phase: Phase,
    nodes: Nodes,
    restarts: Table<SchemaId, Restarts>,
    groups: Table<GroupId, Group>,
    timers: Timers,
    records: u64,
    tickets: u64,
    /// Perceptive schemas that lost a requester in this transaction and should no longer be awake; empty
    /// between transactions.
    unneeded: Vec<SchemaId>,
}

impl Hierarchy {
    /// Returns a hierarchy in which every schema sleeps.
    ///
    /// # Errors
    /// All faults of the specification at once.
    pub fn new(spec: Spec) -> Result<Self, Vec<SpecError>> {
        spec.validate()?;
        Ok(Self {
            nodes: Nodes::new(&spec),
            restarts: spec.schemas.map_ids(|_| Restarts::default()),
            groups: spec.groups.map_ids(|_| Group::FRESH),
            plan: Arc::new(SpecIndex::new(spec)),
            phase: Phase::Fresh,
            timers: Timers::default(),
            records: 0,
            tickets: 0,
            unneeded: Vec::new(),
        })
    }

    /// Changes the declared period of a schema, in nanoseconds, for the contract. A period of 0 is ignored.
    pub fn set_period(&mut self, id: SchemaId, period: Nanos) {
        if self.plan.contains(id) && period > 0 {
            Arc::make_mut(&mut self.plan).spec.schemas[id].period = period;
        }
    }

    /// Changes whether a schema has a panel, for the contract. Returns whether the value changed.
    pub fn set_panel(&mut self, id: SchemaId, panel: bool) -> bool {
        let is_changed = self.plan.contains(id) && self.plan.spec.schemas[id].panel != panel;
        if is_changed {
            Arc::make_mut(&mut self.plan).spec.schemas[id].panel = panel;
        }
        is_changed
    }

    fn node(&self, id: SchemaId) -> &Node {
        self.nodes.get(id)
    }

    fn node_mut(&mut self, id: SchemaId) -> &mut Node {
        self.nodes.get_mut(&self.plan, id)
    }

    fn group(&self, id: GroupId) -> &Group {
        self.groups.get(id).unwrap_or(&UNKNOWN_GROUP)
    }

    fn group_mut(&mut self, id: GroupId) -> &mut Group {
        &mut self.groups[id]
    }

    fn is_live(&self, group: GroupId) -> bool {
        self.plan.members(group).iter().any(|&m| self.is_awake(m))
    }

    fn name(&self, id: SchemaId) -> String {
        self.plan.spec.schemas[id].name.clone()
    }

    fn running_and_known(&self, id: SchemaId) -> Result<(), Refused> {
        if self.phase != Phase::Running {
            return Err(Refused::NotRunning);
        }
        if self.plan.contains(id) {
            Ok(())
        } else {
            Err(Refused::Unknown { index: id.0 })
        }
    }
}

/// Hashes what changes at run time. Equal hierarchies have equal hashes. The specification is not hashed,
/// for speed.
impl Hash for Hierarchy {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.phase.hash(state);
        self.nodes.hash(state);
        self.restarts.hash(state);
        self.groups.hash(state);
        self.timers.hash(state);
        self.records.hash(state);
        self.tickets.hash(state);
    }
}
