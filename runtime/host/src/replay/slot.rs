//! The state of one schema that takes its turns again: its completed steps, and the pending actions for which
//! the recording has not supplied a step yet.

use std::collections::VecDeque;
use std::sync::Arc;

use jde_core::{ArbitrationReply, GroupId, Level, Nanos};
use jde_records::turn::RecordedTurn;

use super::recorded_run::StepKind;
use crate::engine::{Engine, FatherAction};
use crate::instance::{self, Iterated, ShownValue};
use crate::runner::Runner;

/// A schema that takes its turns again.
pub(super) struct ReplaySlot {
    pub(super) runner: Runner,
    /// It takes the recorded turns; otherwise it takes turns by its own period.
    pub(super) follows_recording: bool,
    /// It was awake in the recorded run.
    pub(super) was_awake: bool,
    /// Pending transitions, each to awake (true) or asleep, and since when; they wait for their recorded
    /// step.
    pub(super) transitions: VecDeque<(bool, Nanos)>,
    /// Pending arbitrations.
    pub(super) arbitrations: Vec<PendingArbitration>,
    /// When its next turn is due by its own period.
    pub(super) due: Option<Nanos>,
    /// The result of the check of its current turn.
    pub(super) check_result: Option<Result<instance::CheckResult, String>>,
    /// The turn whose iteration is permitted and not taken yet.
    pub(super) permitted_turn: Option<Arc<RecordedTurn>>,
    /// A recorded turn has begun, and its last step is still to be taken.
    pub(super) in_turn: bool,
    /// Actions on its children that the iteration requested and that are not carried out yet.
    pub(super) father_actions: Vec<FatherAction>,
    /// The result of the iteration.
    pub(super) iteration_result: Option<Result<Iterated, String>>,
    /// The result of an arbitration that the rules have not received yet.
    pub(super) arbitration_result: Option<(GroupId, u64, ArbitrationReply)>,
    /// The error of a gesture that the rules have not received yet.
    pub(super) gesture_error: Option<String>,
    /// What it read at its last check.
    pub(super) last_inputs: Vec<ShownValue>,
}

/// An arbitration requested of a father.
pub(super) struct PendingArbitration {
    pub(super) since: Nanos,
    pub(super) group: GroupId,
    pub(super) ticket: u64,
    pub(super) level: Level,
}

impl ReplaySlot {
    pub(super) fn new(runner: Runner) -> Self {
        Self {
            runner,
            follows_recording: false,
            was_awake: false,
            transitions: VecDeque::new(),
            arbitrations: Vec::new(),
            due: None,
            check_result: None,
            permitted_turn: None,
            in_turn: false,
            father_actions: Vec::new(),
            iteration_result: None,
            arbitration_result: None,
            gesture_error: None,
            last_inputs: Vec::new(),
        }
    }

    /// Returns since when the oldest pending action waits for its recorded step.
    pub(super) fn waiting_since(&self) -> Option<Nanos> {
        let transition = self.transitions.front().map(|(_, since)| *since);
        let requests = self.arbitrations.iter().map(|request| request.since);
        transition.into_iter().chain(requests).min()
    }

    /// Carries out a transition.
    pub(super) fn apply_transition(&mut self, awake: bool, now: Nanos) {
        if awake {
            self.runner.awake_now();
            self.follows_recording = self.was_awake;
            self.start_own_turns(now);
        } else {
            self.runner.fall_asleep();
            self.due = None;
        }
    }

    /// Lets it take turns by its own period, if the recording contains none of them.
    pub(super) fn start_own_turns(&mut self, now: Nanos) {
        self.due = None;
        if !self.follows_recording && self.runner.is_awake() {
            self.runner.start_own_turns(now);
            self.due = Some(now);
        }
    }

    /// Takes the pending arbitration to which a recorded turn replied, or a newer one of the same group,
    /// since the request may have been repeated before that turn. Older ones of the group are void.
    pub(super) fn take_arbitration(&mut self, group: u64, ticket: u64) -> Option<PendingArbitration> {
        let same_group = |request: &PendingArbitration| u64::from(request.group.0) == group;
        let same_ticket = |request: &PendingArbitration| same_group(request) && request.ticket == ticket;
        let place = self
            .arbitrations
            .iter()
            .position(same_ticket)
            .or_else(|| self.arbitrations.iter().rposition(same_group))?;
        let taken = self.arbitrations.remove(place);
        self.arbitrations
            .retain(|request| !same_group(request) || request.ticket > taken.ticket);
        Some(taken)
    }

    /// Carries out every pending arbitration at once.
    pub(super) fn arbitrate_all(&mut self) {
        for PendingArbitration {
            group, ticket, level, ..
        } in std::mem::take(&mut self.arbitrations)
        {
            self.runner.arbitrate(group, ticket, &level);
        }
    }

    /// Reports the error of a gesture to the rules, if there is one.
    pub(super) fn report_gesture_error(&mut self) {
        if let Some(reason) = self.gesture_error.take() {
            self.runner.fault(reason);
        }
    }

    /// Ends the current turn.
    pub(super) fn end_turn(&mut self) {
        (self.check_result, self.iteration_result, self.permitted_turn) = (None, None, None);
        self.runner.end_recorded_turn();
    }

    /// Takes one step of a period.
    pub(super) fn apply_cycle_step(&mut self, engine: &Engine, kind: StepKind, turn: &Arc<RecordedTurn>) {
        if !self.runner.is_awake() {
            return;
        }
        match kind {
            StepKind::CheckCall => {
                self.runner.show_recorded(Some(turn));
                self.check_result = self.runner.repeat_check();
                self.last_inputs = self.runner.shown_inputs();
            }
            StepKind::Checked | StepKind::Failed => {
                if let Some(result) = self.check_result.take() {
                    self.runner.report_check(result);
                }
            }
            StepKind::Begun => {
                let is_permitted = self.runner.repeat_begin(turn);
                if is_permitted && !turn.acted.has_occurred() && !turn.began_early() {
                    // The iteration was not permitted in the recorded run, so there is no step for it.
                    let result = self.runner.iterate();
                    self.runner.finish_iteration(result);
                } else if is_permitted {
                    self.permitted_turn = Some(Arc::clone(turn));
                }
            }
            StepKind::IterationCall => self.run_iteration(engine),
            StepKind::Ended => {
                self.run_iteration(engine);
                self.apply_father_actions(engine);
                if let Some(result) = self.iteration_result.take() {
                    self.runner.finish_iteration(result);
                }
            }
        }
    }

    /// Takes the permitted iteration. Its actions on children are put off until their recorded steps.
    pub(super) fn run_iteration(&mut self, engine: &Engine) {
        if let Some(turn) = self.permitted_turn.take() {
            if !turn.acted.has_occurred() {
                // It ended where its check found the precondition false, or failed.
                self.iteration_result = Some(Ok(Iterated::Done));
                return;
            }
            self.runner.show_recorded(Some(&turn));
            engine.defer_actions();
            self.iteration_result = Some(self.runner.iterate());
            self.father_actions = engine.take_deferred_actions();
        }
    }

    /// Carries out the requested actions for which the recording has no step.
    pub(super) fn apply_father_actions(&mut self, engine: &Engine) {
        for action in std::mem::take(&mut self.father_actions) {
            engine.apply_father_action(action);
        }
    }
}
