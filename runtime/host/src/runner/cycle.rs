//! One turn of an instance that is awake: it checks its precondition, the rules select, and the WINNER
//! iterates.

use std::sync::atomic::Ordering::Relaxed;
use std::time::Instant;

use jde_abi::describe::Kind;
use jde_core::{Check, Nanos};
use jde_records::event::What;
use jde_records::turn::{Moment, Permission, TurnKind};

use super::Runner;
use super::deadlines::{Deadlines, TurnEnd, Work};
use super::phase::{Installed, Phase};
use crate::instance::{self, Iterated};

/// The iterations for which a turn requests permission.
enum IterationRequest {
    Any,
    /// Like `Any`, and in lockstep also a second one at the same instant: its input arrived after the first.
    Repeat,
    /// Only the first iteration since the instance became WINNER.
    First,
}

impl Runner {
    /// One period: check, then iterate if it is WINNER.
    pub(super) fn run_cycle(&mut self, start: Nanos, mut deadlines: Deadlines) {
        let due = deadlines.due().min(start);
        self.check_and_iterate(start, IterationRequest::Any);
        let end = self.engine.clock.now();
        let metrics = &self.engine.metrics[self.number];
        metrics.record_cycle(start, end - start);
        let TurnEnd { missed, is_short } = deadlines.advance(self.period, end);
        if is_short {
            // The time until the grid is not measured as a cycle.
            metrics.pause();
        }
        if let Some(awake) = self.phase.awake() {
            awake.deadlines = deadlines;
        }
        if self.engine.clock.is_real() {
            let took = end - start;
            self.record_lateness(Work::Cycle, due, took, missed || took > self.budget());
        }
    }

    /// Reacts to a value that cannot wait for the period. A motor schema re-evaluates its precondition (R12),
    /// and iterates only if that made it WINNER. A driver carries out the command.
    pub(super) fn react(&mut self, now: Nanos) {
        let request = match self.kind {
            Kind::Motor => IterationRequest::First,
            Kind::Perceptive | Kind::Driver => IterationRequest::Repeat,
        };
        self.check_and_iterate(now, request);
    }

    /// The turn that the instance has requested: as one at its period, and its deadlines stay.
    pub(super) fn run_requested(&mut self, now: Nanos) {
        self.check_and_iterate(now, IterationRequest::Any);
    }

    /// Takes a turn. Where it takes no time of the application, its time by the machine's clock is measured: it shows
    /// what would be late in real time, and nothing depends on it.
    fn check_and_iterate(&mut self, now: Nanos, request: IterationRequest) {
        let clock = &self.engine.clock;
        let begun = (!clock.is_real() && !clock.is_replayed()).then(Instant::now);
        self.take_permitted_turn(now, request);
        let metrics = &self.engine.metrics[self.number];
        if let Some(begun) = begun
            && !metrics.take_held()
        {
            metrics.record_machine_time(begun.elapsed().as_nanos() as Nanos, self.budget());
        }
    }

    /// Evaluates the precondition of a motor schema, and iterates if the rules permit.
    fn take_permitted_turn(&mut self, now: Nanos, request: IterationRequest) {
        let Phase::Awake(Installed { instance, .. }, _) = &mut self.phase else {
            return;
        };
        let has_iterated_now = self.last_iteration == now + 1 && !self.engine.clock.is_real();
        if self.kind == Kind::Motor
            && matches!(request, IterationRequest::Any)
            && !has_iterated_now
            && instance.has_combined_call()
            && let Some(begun) = self.engine.rules.request_iteration_early(self.number)
        {
            self.check_within_iteration(now, begun);
            return;
        }
        let checked = if self.kind == Kind::Motor {
            let result = instance.check();
            self.record.add_look(instance);
            let Some(check) = self.handle_check_result(now, result) else {
                return;
            };
            Some(check)
        } else {
            None
        };
        let requests_iteration = matches!(request, IterationRequest::Repeat) || !has_iterated_now;
        let first = matches!(request, IterationRequest::First);
        let (is_permitted, begun) = match checked {
            Some(check) if requests_iteration => {
                let (checked, begun) = self
                    .engine
                    .rules
                    .report_check_and_request(self.number, check, first);
                self.record.turn.checked = checked;
                begun
            }
            Some(check) => {
                self.record.turn.checked = self.engine.rules.report_check(self.number, check);
                return;
            }
            None if requests_iteration => self.engine.rules.request_iteration(self.number),
            None => return,
        };
        self.record.turn.begun = begun;
        let permission = match request {
            IterationRequest::Any | IterationRequest::Repeat => Permission::Any,
            IterationRequest::First => Permission::First,
        };
        self.record.turn.set_kind(TurnKind::Cycled(Some(permission)));
        if is_permitted {
            self.last_iteration = now + 1;
            let result = self.iterate();
            self.finish_iteration(result);
            if self.is_guard {
                self.judge_in_force();
            }
        }
    }

    /// A guard that has another state judges the commands in force by it, and what it refuses ends at once (R18).
    fn judge_in_force(&mut self) {
        if let Phase::Awake(Installed { instance, .. }, _) = &mut self.phase {
            let judged = instance.judge_in_force();
            self.engine.apply_in_force(self.number, judged);
        }
    }

    /// Takes the check and the iteration of a WINNER that stays READY in one call, which is its iteration for the
    /// rules. If the precondition is false or the check fails, the iteration ends there.
    fn check_within_iteration(&mut self, now: Nanos, begun: Moment) {
        let Phase::Awake(Installed { instance, .. }, _) = &mut self.phase else {
            return;
        };
        let (iterated, result) = instance.check_and_iterate();
        self.record.add_combined(instance, begun, iterated);
        let mut outcome = result.map(|(check, outcome)| {
            if let Some(check) = self.handle_check_result(now, Ok(check)) {
                self.record.turn.checked = self.engine.rules.report_check(self.number, check);
            }
            outcome
        });
        if iterated {
            let took = self.engine.clock.now().saturating_sub(now);
            self.engine.metrics[self.number].record_iteration(took);
        } else if outcome.is_err() {
            return self.finish_iteration(outcome);
        } else if self.engine.rules.should_go_on(self.number) {
            outcome = self.iterate();
        } else {
            self.record.turn.ended = self.engine.rules.report_iteration_end(self.number);
            return;
        }
        self.last_iteration = now + 1;
        self.finish_iteration(outcome);
    }

    /// Converts the result of a check for the rules. Returns `None` after a failure, which it reports.
    pub(super) fn handle_check_result(
        &mut self,
        now: Nanos,
        result: Result<instance::CheckResult, String>,
    ) -> Option<Check> {
        match result {
            Ok(result) => {
                // The newest value read caused the situation, but not before the last check, which read the
                // earlier values.
                let last_check = std::mem::replace(&mut self.phase.awake()?.last_check, now);
                let cause = result.newest.clamp(last_check.min(now), now);
                Some(Check {
                    ready: result.ready,
                    urgency: result.urgency,
                    cause,
                })
            }
            Err(reason) => {
                self.fault(reason);
                None
            }
        }
    }

    /// Takes an iteration.
    pub(crate) fn iterate(&mut self) -> Result<Iterated, String> {
        let Phase::Awake(Installed { instance, .. }, _) = &mut self.phase else {
            return Ok(Iterated::Done);
        };
        let start = self.engine.clock.now();
        let result = instance.iterate();
        self.record.add_iteration(instance);
        let took = self.engine.clock.now().saturating_sub(start);
        self.engine.metrics[self.number].record_iteration(took);
        result
    }

    /// Reports the end of an iteration to the rules.
    pub(crate) fn finish_iteration(&mut self, result: Result<Iterated, String>) {
        match result {
            Ok(Iterated::Done) => {
                self.engine.metrics[self.number].started.store(true, Relaxed);
                self.lacks_value = false;
            }
            Ok(Iterated::WithoutValue(words)) => {
                if !std::mem::replace(&mut self.lacks_value, true) {
                    tracing::info!(schema = self.engine.name(self.number), "it waits: {words}");
                }
                self.record.turn.ended = self.engine.rules.report_iteration_end_unready(self.number);
                return;
            }
            Err(reason) => self.fault(reason),
        }
        self.record.turn.ended = self.engine.rules.report_iteration_end(self.number);
    }

    pub(super) fn budget(&self) -> Nanos {
        self.engine.application.instances[self.number].budget_ns
    }

    /// Counts late work that was due at `due`, and reports the first of consecutive late ones. Work that a debugger held
    /// is not judged, nor work that is late because the host did not run.
    pub(super) fn record_lateness(&mut self, work: Work, due: Nanos, took: Nanos, late: bool) {
        let has_stalled = || self.engine.stalls.within(due, self.engine.clock.now()) > 0;
        if self.engine.metrics[self.number].take_held() || late && has_stalled() {
            return;
        }
        let change = self.lateness.record(work, late);
        if late {
            self.engine.metrics[self.number].overruns.fetch_add(1, Relaxed);
        }
        if let Some(healthy) = change.healthy {
            self.engine.rules.report_deadline(self.number, healthy);
        }
        if change.is_first {
            self.engine.rules.report_now(What::Overrun {
                schema: self.number,
                took,
                budget: self.budget(),
            });
        }
    }
}
