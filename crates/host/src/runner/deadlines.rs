//! The deadline of a schema's next turn, and whether the schema keeps its deadlines (R11). It never waits.

use std::sync::atomic::Ordering::Relaxed;

use jde_core::Nanos;
use jde_records::event::Event;

use super::{InstanceState, Runner};

impl Runner {
    /// Applies a new period: the next iteration is due one new period after the last.
    pub(super) fn retime(&mut self) {
        let Some(period) = self
            .engine
            .period_of(self.number)
            .filter(|period| *period != self.period)
        else {
            return;
        };
        if let InstanceState::Awake { due, .. } = self.state {
            // A deadline that the new period puts in the past is due now, and not late.
            let next = due.saturating_sub(self.period).saturating_add(period);
            self.set_due(next.max(self.engine.clock.now()));
        }
        self.period = period;
        self.engine.set_period(self.number, period);
    }

    /// Puts the deadlines of an instance that was woken at `woken` on its grid: whole periods after that
    /// time, and in real time a little earlier. So instances that were woken together are due in their order
    /// and not all at the same instant.
    pub(super) fn begin_grid(&mut self, woken: Nanos) {
        let early = self.engine.stagger(self.number) % self.period;
        self.anchor = woken.saturating_add(self.period - early);
    }

    /// Moves the deadlines to another grid, with the next one at `next`.
    pub(super) fn set_due(&mut self, next: Nanos) {
        self.anchor = next;
        if let InstanceState::Awake { due, .. } = &mut self.state {
            *due = next;
        }
    }

    /// Ends a turn that was due at `due`, and sets the next deadline. Returns whether deadlines between the
    /// two were missed.
    pub(super) fn schedule_next(&mut self, due: Nanos, now: Nanos) -> bool {
        let (next, missed) = next_due(self.anchor, due, self.period, now);
        if next < due.saturating_add(self.period) {
            // The time until the grid is shorter than a period and is not measured as a cycle.
            self.engine.metrics[self.number].pause();
        }
        if let InstanceState::Awake { due, .. } = &mut self.state {
            *due = next;
        }
        missed
    }

    pub(super) fn record_cycle_time(&mut self, took: Nanos, missed: bool) {
        self.record_lateness(Work::Cycle, took, missed || took > self.budget());
    }

    /// Records the duration of a drawing. Returns whether it kept to the budget, on which the contract relies
    /// (R17).
    pub(super) fn record_drawing_time(&mut self, took: Nanos) -> bool {
        let late = took > self.budget();
        self.record_lateness(Work::Drawing, took, late);
        !late
    }

    /// Records that nothing is drawn, which is never late.
    pub(super) fn record_no_drawing(&mut self) {
        self.record_lateness(Work::Drawing, 0, false);
    }

    pub(super) fn budget(&self) -> Nanos {
        self.engine.application.instances[self.number].budget_ns
    }

    /// Counts late work, and reports the first of consecutive late ones. A schema is late if either kind of
    /// work is.
    fn record_lateness(&mut self, work: Work, took: Nanos, late: bool) {
        if !late && !self.late[work as usize] {
            // The usual case.
            return;
        }
        if late {
            self.engine.metrics[self.number].overruns.fetch_add(1, Relaxed);
        }
        let before = self.late;
        self.late[work as usize] = late;
        let healthy = |late: [bool; 2]| !late.contains(&true);
        if healthy(before) != healthy(self.late) {
            self.engine.rules.report_deadline(self.number, healthy(self.late));
        }
        if late && !before[work as usize] {
            self.engine.rules.report(&Event::Overrun {
                time: self.engine.clock.now(),
                schema: self.number,
                took,
                budget: self.budget(),
            });
        }
    }
}

/// The kinds of work with a deadline.
#[derive(Clone, Copy)]
enum Work {
    Cycle,
    Drawing,
}

/// Returns the first deadline on the grid through `anchor` after a turn that was due at `due` and ended at
/// `now`, and whether other deadlines were missed before it (R11).
fn next_due(anchor: Nanos, due: Nanos, period: Nanos, now: Nanos) -> (Nanos, bool) {
    let missed = due.saturating_add(period) <= now;
    let next = match now.checked_sub(anchor) {
        Some(since) => anchor.saturating_add((since / period + 1).saturating_mul(period)),
        None => anchor,
    };
    (next, missed)
}

#[cfg(test)]
mod tests {
    use super::next_due;

    #[test]
    fn r11_deadlines_are_absolute() {
        assert_eq!(next_due(100, 100, 75, 130), (175, false));
        assert_eq!(next_due(100, 175, 75, 249), (250, false));
    }

    #[test]
    fn r11_a_late_schema_skips_and_stays_on_its_grid() {
        assert_eq!(next_due(100, 100, 75, 175), (250, true));
        assert_eq!(next_due(100, 100, 75, 500), (550, true));
    }

    #[test]
    fn r11_a_first_turn_that_ends_after_the_first_grid_point_misses_no_deadline() {
        assert_eq!(next_due(110, 100, 75, 105), (110, false));
        assert_eq!(next_due(110, 100, 75, 174), (185, false));
        assert_eq!(next_due(110, 100, 75, 175), (185, true));
    }
}
