//! The deadlines of a schema's turns, and whether the schema keeps them (R11). Nothing here waits, reads a
//! clock or reports.

use jde_core::Nanos;

/// The deadlines of an instance that is awake, on a grid of whole periods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Deadlines {
    /// One instant of the grid.
    anchor: Nanos,
    due: Nanos,
}

/// How a turn ended against its deadlines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TurnEnd {
    /// Deadlines between its own and the next were missed.
    pub(super) missed: bool,
    /// The time until the next is shorter than a period.
    pub(super) is_short: bool,
}

impl Deadlines {
    /// A grid with its first deadline at `next`.
    pub(super) fn starting_at(next: Nanos) -> Self {
        Self {
            anchor: next,
            due: next,
        }
    }

    /// The deadlines of an instance that the rules woke at `woken` and that awakes at `now`: at once, then
    /// whole periods after `woken`, each `early` before. So instances that were woken together are due in
    /// their order and not all at the same instant.
    pub(super) fn of_awakening(woken: Nanos, early: Nanos, period: Nanos, now: Nanos) -> Self {
        Self {
            anchor: woken.saturating_add(period - early % period),
            due: now,
        }
    }

    pub(super) fn due(&self) -> Nanos {
        self.due
    }

    /// Adds a turn at `now`. The grid stays.
    pub(super) fn add(&mut self, now: Nanos) {
        self.due = now;
    }

    /// Changes the period: the next turn is due one new period after the last. A deadline that the new period
    /// puts in the past is due now, and not late.
    pub(super) fn retime(&mut self, from: Nanos, to: Nanos, now: Nanos) {
        let next = self.due.saturating_sub(from).saturating_add(to);
        *self = Self::starting_at(next.max(now));
    }

    /// Ends the turn that was due: the next is due at the first instant of the grid after `now`.
    pub(super) fn advance(&mut self, period: Nanos, now: Nanos) -> TurnEnd {
        let full = self.due.saturating_add(period);
        self.due = match now.checked_sub(self.anchor) {
            // A division takes longer than the rest of this function.
            Some(since) if since < period => self.anchor.saturating_add(period),
            Some(since) => self
                .anchor
                .saturating_add((since / period + 1).saturating_mul(period)),
            None => self.anchor,
        };
        self.anchor = self.due;
        TurnEnd {
            missed: full <= now,
            is_short: self.due < full,
        }
    }
}

/// The kinds of work with a deadline.
#[derive(Clone, Copy)]
pub(super) enum Work {
    Cycle,
    Drawing,
}

/// Which kinds of work were late the last time. A schema is late if either is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lateness([bool; 2]);

/// What changed with one work.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct LatenessChange {
    /// The schema keeps its deadlines from now on, or does not any more.
    pub(super) healthy: Option<bool>,
    /// It is the first of consecutive late ones.
    pub(super) is_first: bool,
}

impl Lateness {
    pub(super) fn record(&mut self, work: Work, late: bool) -> LatenessChange {
        let (was_healthy, was_late) = (self.is_healthy(), self.0[work as usize]);
        self.0[work as usize] = late;
        let healthy = self.is_healthy();
        LatenessChange {
            healthy: (healthy != was_healthy).then_some(healthy),
            is_first: late && !was_late,
        }
    }

    /// Whether work of this kind was late the last time.
    pub(super) fn is_late(self, work: Work) -> bool {
        self.0[work as usize]
    }

    fn is_healthy(self) -> bool {
        !self.0.contains(&true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn next(anchor: Nanos, due: Nanos, now: Nanos) -> (Nanos, bool, bool) {
        let mut deadlines = Deadlines { anchor, due };
        let end = deadlines.advance(75, now);
        assert_eq!(deadlines.anchor % 75, anchor % 75, "it stays on its grid");
        (deadlines.due(), end.missed, end.is_short)
    }

    #[test]
    fn r11_deadlines_are_absolute() {
        assert_eq!(next(100, 100, 130), (175, false, false));
        assert_eq!(next(100, 175, 249), (250, false, false));
    }

    #[test]
    fn r11_a_late_schema_skips_and_stays_on_its_grid() {
        assert_eq!(next(100, 100, 175), (250, true, false));
        assert_eq!(next(100, 100, 500), (550, true, false));
    }

    #[test]
    fn r11_a_first_turn_that_ends_after_the_first_grid_point_misses_no_deadline() {
        assert_eq!(next(110, 100, 105), (110, false, true));
        assert_eq!(next(110, 100, 174), (185, false, false));
        assert_eq!(next(110, 100, 175), (185, true, false));
    }

    #[test]
    fn an_awakened_schema_is_due_at_once_and_then_a_little_before_each_period() {
        let mut deadlines = Deadlines::of_awakening(100, 80, 75, 110);
        assert_eq!(deadlines.due(), 110);
        deadlines.advance(75, 120);
        assert_eq!(deadlines.due(), 170);
    }

    #[test]
    fn r11_a_new_period_counts_from_the_last_turn_and_never_makes_one_late() {
        let mut deadlines = Deadlines::starting_at(175);
        deadlines.retime(75, 100, 130);
        assert_eq!(deadlines, Deadlines::starting_at(200));
        deadlines.retime(100, 10, 150);
        assert_eq!(deadlines, Deadlines::starting_at(150));
    }

    #[test]
    fn an_added_turn_leaves_the_grid_as_it_is() {
        let mut deadlines = Deadlines::starting_at(100);
        deadlines.add(130);
        deadlines.advance(75, 140);
        assert_eq!(deadlines.due(), 175);
    }

    #[test]
    fn r11_a_schema_is_late_while_either_kind_of_work_is() {
        let mut lateness = Lateness::default();
        let change = |healthy, is_first| LatenessChange { healthy, is_first };
        assert_eq!(lateness.record(Work::Cycle, false), change(None, false));
        assert_eq!(lateness.record(Work::Cycle, true), change(Some(false), true));
        assert_eq!(lateness.record(Work::Cycle, true), change(None, false));
        assert_eq!(lateness.record(Work::Drawing, true), change(None, true));
        assert_eq!(lateness.record(Work::Cycle, false), change(None, false));
        assert_eq!(lateness.record(Work::Drawing, false), change(Some(true), false));
    }
}
