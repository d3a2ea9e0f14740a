//! When a schema's next turn is due, and whether it keeps its deadlines (R11). It waits for nothing.

use std::sync::atomic::Ordering::Relaxed;

use jde_core::Nanos;

use super::{Life, Runner};
use crate::event::Event;

impl Runner {
    /// The next iteration comes by the new period, counted from the last.
    pub(super) fn retime(&mut self) {
        let Some(period) = self
            .engine
            .period_of(self.number)
            .filter(|period| *period != self.period)
        else {
            return;
        };
        if let Life::Awake { due, .. } = &mut self.life {
            // What would be over by the new period is due now, and not late.
            let next = due.saturating_sub(self.period).saturating_add(period);
            *due = next.max(self.engine.clock.now());
        }
        self.period = period;
        self.engine.retimed(self.number, period);
    }

    pub(super) fn judge(&mut self, took: Nanos, missed: bool) {
        self.note(Work::Cycle, took, missed || took > self.budget());
    }

    /// Judges a drawing; answers whether it kept to the budget, which the contract counts on (R17).
    pub(super) fn judge_drawing(&mut self, took: Nanos) -> bool {
        let late = took > self.budget();
        self.note(Work::Drawing, took, late);
        !late
    }

    /// Nothing is drawn: it holds up nobody.
    pub(super) fn draws_nothing(&mut self) {
        self.note(Work::Drawing, 0, false);
    }

    pub(super) fn budget(&self) -> Nanos {
        self.engine.application.instances[self.number].budget_ns
    }

    /// Counts what is late, and tells when a row of such begins; who is late in either is late.
    fn note(&mut self, work: Work, took: Nanos, late: bool) {
        if late {
            self.engine.meters[self.number].overruns.fetch_add(1, Relaxed);
        }
        let before = self.late;
        self.late[work as usize] = late;
        let healthy = |late: [bool; 2]| !late.contains(&true);
        if healthy(before) != healthy(self.late) {
            self.engine.deadline(self.number, healthy(self.late));
        }
        if late && !before[work as usize] {
            self.engine.report(&Event::Overrun {
                time: self.engine.clock.now(),
                schema: self.number,
                took,
                budget: self.budget(),
            });
        }
    }
}

/// What has a deadline.
#[derive(Clone, Copy)]
enum Work {
    Cycle,
    Drawing,
}

/// The first deadline after `now` on the grid of `due` and `period` (R11), and whether others were missed before it.
pub(super) fn next_due(due: Nanos, period: Nanos, now: Nanos) -> (Nanos, bool) {
    let next = due.saturating_add(period);
    if next > now {
        return (next, false);
    }
    let skipped = (now - next) / period + 1;
    (next + skipped * period, true)
}

#[cfg(test)]
mod tests {
    use super::next_due;

    #[test]
    fn r11_deadlines_are_absolute() {
        assert_eq!(next_due(100, 75, 130), (175, false));
        assert_eq!(next_due(175, 75, 249), (250, false));
    }

    #[test]
    fn r11_a_late_schema_skips_and_stays_on_its_grid() {
        assert_eq!(next_due(100, 75, 175), (250, true));
        assert_eq!(next_due(100, 75, 500), (550, true));
    }
}
