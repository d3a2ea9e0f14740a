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
mod wake;
mod winner;

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use crate::effect::Effect;
use crate::policy::Policy;
use crate::record::Cause;
use crate::refused::Refused;
use crate::spec::{GroupId, Kind, Nanos, SchemaId, Spec};
use crate::spec_error::SpecError;
use crate::state::{Requester, State};
use crate::validate::policy_fault;

pub use arbitration::ArbitrationReply;

pub use iteration::Check;
pub use operator::Operator;
pub use timer::Timer;
pub use winner::Handover;

use group::{Group, TimedCause};
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
    /// One entry for each schema.
    restarts: Vec<Restarts>,
    groups: Vec<Group>,
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
            nodes: Nodes::new(spec.schemas.len(), spec.groups.len()),
            restarts: vec![Restarts::default(); spec.schemas.len()],
            groups: vec![Group::FRESH; spec.groups.len()],
            plan: Arc::new(SpecIndex::new(spec)),
            phase: Phase::Fresh,
            timers: Timers::default(),
            records: 0,
            tickets: 0,
            unneeded: Vec::new(),
        })
    }

    /// Wakes the roots (R13). A second call has no effect.
    pub fn start(&mut self, now: Nanos, out: &mut Vec<Effect>) {
        if self.phase != Phase::Fresh {
            return;
        }
        self.phase = Phase::Running;
        let plan = Arc::clone(&self.plan);
        for &group in plan.root_groups() {
            for &root in plan.members(group) {
                self.request(root, Requester::Application, out);
            }
            self.select(now, group, TimedCause::new(Cause::Start, now), out);
        }
    }

    /// Ends the application: authority is withdrawn, every group brakes, and all schemas go to sleep,
    /// children before fathers and perceptive schemas last. No schema wakes afterwards.
    pub fn shutdown(&mut self, _now: Nanos, out: &mut Vec<Effect>) {
        if self.phase != Phase::Running {
            self.phase = Phase::Over;
            return;
        }
        self.phase = Phase::Over;
        let plan = Arc::clone(&self.plan);
        for &group in plan.root_groups() {
            if let Some(winner) = self.group(group).winner() {
                self.withdraw(winner, out);
            }
        }
        out.extend(plan.group_ids().map(|group| Effect::Brake { group }));
        for &group in plan.root_groups() {
            self.sleep_group(group, sleep::SleepMode::AtOnce, out);
        }
        for id in plan.ids_of(Kind::Perceptive) {
            for requester in self.requesters(id).to_vec() {
                match requester {
                    Requester::Application | Requester::Operator | Requester::Stopped(_) => {
                        self.release(id, requester);
                    }
                    // It ends when the schema that requests it sleeps.
                    Requester::Father(_) | Requester::Need(_) => {}
                }
            }
        }
        self.settle(out);
        self.timers.clear();
    }

    /// Changes the policy of a group on behalf of its father. The group selects at once (R2). An open
    /// request to the father is dropped. An unknown group has no effect.
    ///
    /// # Errors
    /// A policy that this group cannot have; nothing changes then.
    pub fn set_policy(
        &mut self,
        now: Nanos,
        group: GroupId,
        policy: Policy,
        out: &mut Vec<Effect>,
    ) -> Result<(), SpecError> {
        let Some(spec) = self.plan.spec.groups.get(group.index()) else {
            return Ok(());
        };
        if let Some(fault) = policy_fault(spec, policy) {
            return Err(fault);
        }
        if spec.policy != policy {
            Arc::make_mut(&mut self.plan).spec.groups[group.index()].policy = policy;
            self.cancel_arbitration(group);
            if self.is_live(group) {
                self.select(now, group, TimedCause::new(Cause::PolicyChanged, now), out);
            }
            self.settle(out);
        }
        Ok(())
    }

    /// Changes the declared period of a schema, in nanoseconds, for the contract. A period of 0 is ignored.
    pub fn set_period(&mut self, id: SchemaId, period: Nanos) {
        if self.plan.contains(id) && period > 0 {
            Arc::make_mut(&mut self.plan).spec.schemas[id.index()].period = period;
        }
    }

    /// Changes whether a schema has a panel, for the contract. Returns whether the value changed.
    pub fn set_panel(&mut self, id: SchemaId, panel: bool) -> bool {
        let is_changed = self.plan.contains(id) && self.plan.spec.schemas[id.index()].panel != panel;
        if is_changed {
            Arc::make_mut(&mut self.plan).spec.schemas[id.index()].panel = panel;
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
        self.groups.get(id.index()).unwrap_or(&UNKNOWN_GROUP)
    }

    fn group_mut(&mut self, id: GroupId) -> &mut Group {
        &mut self.groups[id.index()]
    }

    fn is_live(&self, group: GroupId) -> bool {
        self.plan.members(group).iter().any(|&m| self.is_awake(m))
    }

    fn name(&self, id: SchemaId) -> String {
        self.plan.spec.schemas[id.index()].name.clone()
    }

    fn change(&mut self, id: SchemaId, to: State, out: &mut Vec<Effect>) {
        let from = self.node_mut(id).set_state(to);
        if from != to {
            out.push(Effect::Changed { id, from, to });
        }
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
