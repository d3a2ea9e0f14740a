//! One schema at run time: its state, its health, its requesters and its restarts, with every transition.
//!
//! It knows no other schema, and refuses to decide when a transition happens.

use super::holds::Holds;
use super::last_check::{CheckChange, LastCheck, Urgency};
use crate::record::Candidate;
use crate::spec::SchemaId;
use crate::state::{Health, Hold, HoldAction, Requester, State};

/// The changing facts of one schema.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Node {
    state: State,
    health: Health,
    run: RunState,
    authority: Authority,
    check: LastCheck,
    /// Sorted, each once.
    requesters: Vec<Requester>,
    /// The perceptive schemas that it woke as a father.
    woken: Vec<SchemaId>,
    /// What operators hold it to, without forces.
    holds: Holds,
    /// A guard refused a command of it, and its retry has not ended (R18). It survives a sleep.
    refused: bool,
    /// A debugger holds a call of it.
    debugged: bool,
}

/// Whether it and all its fathers are WINNER and its authority is not withdrawn (R7), and how far it has
/// taken over earlier commands.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
enum Authority {
    Absent,
    /// It has not begun an iteration.
    New,
    /// It is in its first iteration.
    First,
    /// It has ended an iteration.
    Settled,
}

/// The relation of a schema to its iteration.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
enum RunState {
    Between,
    Iterating,
    /// It still iterates, but was replaced or put to sleep during the iteration.
    Abandoned,
}

/// What the end of an iteration changed.
pub(super) struct IterationEnd {
    /// Whether an iteration ran, abandoned or not.
    pub(super) ran: bool,
    /// Whether it was the first with authority.
    pub(super) lapsed: bool,
}

impl Node {
    /// A healthy schema that sleeps; also what an unknown identifier reads as.
    pub(super) const ASLEEP: Self = Self {
        state: State::Slept,
        health: Health::Ok,
        run: RunState::Between,
        authority: Authority::Absent,
        check: LastCheck::NONE,
        requesters: Vec::new(),
        woken: Vec::new(),
        holds: Holds::NONE,
        refused: false,
        debugged: false,
    };

    pub(super) fn state(&self) -> State {
        self.state
    }

    pub(super) fn health(&self) -> &Health {
        &self.health
    }

    pub(super) fn requesters(&self) -> &[Requester] {
        &self.requesters
    }

    pub(super) fn is_awake(&self) -> bool {
        self.state != State::Slept
    }

    pub(super) fn is_faulted(&self) -> bool {
        matches!(self.health, Health::Faulted(_))
    }

    pub(super) fn holds(&self) -> &Holds {
        &self.holds
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.holds.is_stopped()
    }

    /// Whether its precondition holds and no guard has refused its command (R18).
    pub(super) fn is_ready(&self) -> bool {
        self.check.is_ready() && !self.refused
    }

    pub(super) fn is_refused(&self) -> bool {
        self.refused
    }

    pub(super) fn is_checked(&self) -> bool {
        self.check.is_checked()
    }

    pub(super) fn is_running(&self) -> bool {
        self.run != RunState::Between
    }

    pub(super) fn is_iterating(&self) -> bool {
        self.run == RunState::Iterating
    }

    pub(super) fn is_abandoned(&self) -> bool {
        self.run == RunState::Abandoned
    }

    pub(super) fn has_authority(&self) -> bool {
        self.authority != Authority::Absent
    }

    /// Whether winners below it have authority: it has, and no debugger holds it.
    pub(super) fn delegates(&self) -> bool {
        self.has_authority() && !self.debugged
    }

    /// Whether it has ended an iteration since it gained authority.
    pub(super) fn has_taken_over(&self) -> bool {
        self.authority == Authority::Settled
    }

    /// Whether it should be awake: it has a requester, and neither an operator nor a fault keeps it asleep.
    pub(super) fn should_be_awake(&self) -> bool {
        !self.requesters.is_empty() && !self.is_stopped() && !self.is_faulted()
    }

    /// Whether it competes: it is awake and should stay so.
    fn competes(&self) -> bool {
        self.is_awake() && self.should_be_awake()
    }

    /// Whether it can be chosen although it is not READY.
    pub(super) fn can_be_chosen(&self) -> bool {
        self.competes() && !self.is_abandoned()
    }

    /// Whether it can win as the fallback of its group.
    pub(super) fn can_fall_back(&self) -> bool {
        self.can_be_chosen() && !self.refused
    }

    /// Whether it may begin an iteration, as far as it depends on this schema alone.
    pub(super) fn can_begin(&self) -> bool {
        self.state == State::Winner && !self.is_running() && self.should_be_awake()
    }

    /// Returns it as a candidate, if it competes.
    pub(super) fn candidate(&self, id: SchemaId) -> Option<Candidate> {
        self.competes().then(|| Candidate {
            id,
            state: self.state,
            ready: self.is_ready(),
            urgency: self.check.urgency(),
        })
    }

    /// Returns the state of a motor schema that is awake and does not win.
    pub(super) fn state_of_loser(&self) -> State {
        if self.is_ready() {
            State::Ready
        } else {
            State::Checking
        }
    }

    /// Sets the state and returns the previous one.
    pub(super) fn set_state(&mut self, to: State) -> State {
        std::mem::replace(&mut self.state, to)
    }

    pub(super) fn set_health(&mut self, health: Health) {
        self.health = health;
    }

    /// Takes in a check. Has no effect while it sleeps or is inside an abandoned iteration.
    #[inline]
    pub(super) fn check(&mut self, ready: bool, urgency: Urgency) -> CheckChange {
        if self.is_awake() && !self.is_abandoned() {
            self.check.update(ready, urgency)
        } else {
            CheckChange::Nothing
        }
    }

    pub(super) fn begin(&mut self) {
        self.run = RunState::Iterating;
        if self.authority == Authority::New {
            self.authority = Authority::First;
        }
    }

    pub(super) fn end(&mut self) -> IterationEnd {
        let lapsed = self.authority == Authority::First;
        if lapsed {
            self.authority = Authority::Settled;
        }
        let ran = std::mem::replace(&mut self.run, RunState::Between) != RunState::Between;
        IterationEnd { ran, lapsed }
    }

    /// It is not READY until its next check; returns whether it was.
    pub(super) fn end_readiness(&mut self) -> bool {
        self.check.end_readiness()
    }

    /// Abandons an iteration that runs. It cannot check during the iteration, so it is no longer READY.
    /// Returns whether that changed.
    pub(super) fn abandon(&mut self) -> bool {
        if !self.is_iterating() {
            return false;
        }
        self.run = RunState::Abandoned;
        self.check.end_readiness()
    }

    /// Forgets its check and abandons an iteration that runs, before it goes to sleep. Returns the perceptive
    /// schemas that it woke.
    pub(super) fn prepare_sleep(&mut self) -> Vec<SchemaId> {
        self.abandon();
        self.check.forget();
        self.debugged = false;
        std::mem::take(&mut self.woken)
    }

    pub(super) fn grant(&mut self) {
        self.authority = Authority::New;
    }

    pub(super) fn withdraw(&mut self) {
        self.authority = Authority::Absent;
    }

    /// Records that a guard refused a command of it. It has decided about what it took over, so that does not
    /// lapse.
    pub(super) fn refuse(&mut self) {
        self.refused = true;
        self.authority = Authority::Settled;
    }

    /// Ends its refusal.
    pub(super) fn retry(&mut self) {
        self.refused = false;
    }

    pub(super) fn is_requested_by(&self, requester: Requester) -> bool {
        self.requesters.binary_search(&requester).is_ok()
    }

    pub(super) fn request(&mut self, requester: Requester) {
        if let Err(position) = self.requesters.binary_search(&requester) {
            self.requesters.insert(position, requester);
        }
    }

    /// Removes one requester; returns whether it was present.
    pub(super) fn release(&mut self, requester: Requester) -> bool {
        let position = self.requesters.binary_search(&requester);
        if let Ok(position) = position {
            self.requesters.remove(position);
        }
        position.is_ok()
    }

    /// Removes all requesters, and with them the plays of operators.
    pub(super) fn release_by_all(&mut self) {
        self.requesters.clear();
        self.holds.end(|hold| hold.action == HoldAction::Played);
    }

    /// Records that it woke a perceptive schema as a father.
    pub(super) fn add_woken(&mut self, id: SchemaId) {
        self.woken.push(id);
    }

    pub(super) fn remove_woken(&mut self, id: SchemaId) {
        self.woken.retain(|&woken| woken != id);
    }

    /// Returns the perceptive schemas that it woke as a father.
    pub(super) fn woken(&self) -> &[SchemaId] {
        &self.woken
    }

    pub(super) fn hold(&mut self, hold: Hold) {
        self.holds.add(hold);
    }

    /// Ends holds; returns whether there were any.
    pub(super) fn end_holds(&mut self, which: impl Fn(Hold) -> bool) -> bool {
        self.holds.end(which)
    }

    /// Records whether a debugger holds a call of it; returns whether that changed.
    pub(super) fn set_debugged(&mut self, debugged: bool) -> bool {
        std::mem::replace(&mut self.debugged, debugged) != debugged
    }
}
