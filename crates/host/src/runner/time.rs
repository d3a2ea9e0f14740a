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
        if let Life::Awake { due, .. } = self.life {
            // What would be over by the new period is due now, and not late.
            let next = due.saturating_sub(self.period).saturating_add(period);
            self.be_due(next.max(self.engine.clock.now()));
        }
        self.period = period;
        self.engine.retimed(self.number, period);
    }

    /// Puts the deadlines of an instance on their grid, which was woken then: whole periods after that, and in real time a little
    /// less, so that those who were woken at once are due in their order and not all at the same instant.
    pub(super) fn begin_grid(&mut self, woken: Nanos) {
        let early = self.engine.early(self.number) % self.period;
        self.anchor = woken.saturating_add(self.period - early);
    }

    /// Puts them on another, on which the next one is.
    pub(super) fn be_due(&mut self, then: Nanos) {
        self.anchor = then;
        if let Life::Awake { due, .. } = &mut self.life {
            *due = then;
        }
    }

    /// A turn that was due then is over: notes when the next is due; answers whether deadlines between the two were missed.
    pub(super) fn goes_on(&mut self, due: Nanos, now: Nanos) -> bool {
        let (next, missed) = next_due(self.anchor, due, self.period, now);
        if next < due.saturating_add(self.period) {
            // Onto the grid: what lies between the two is no cycle.
            self.engine.meters[self.number].pause();
        }
        if let Life::Awake { due, .. } = &mut self.life {
            *due = next;
        }
        missed
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
        if !late && !self.late[work as usize] {
            // As ever.
            return;
        }
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

/// The first deadline on the grid through `anchor` after a turn that was due then and is over now, and whether others were missed
/// before it (R11).
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
    fn r11_a_first_turn_that_takes_longer_than_until_the_grid_missed_nothing() {
        assert_eq!(next_due(110, 100, 75, 105), (110, false));
        assert_eq!(next_due(110, 100, 75, 174), (185, false));
        assert_eq!(next_due(110, 100, 75, 175), (185, true));
    }
}
