//! The timing of a schema: its iterations, the times between them, and its busy time, from its turns. For a
//! driver, whose turns are not recorded, the times of its exports are used.

use jde_core::Nanos;
use jde_records::turn::{Permission, Turn, TurnKind};

use super::columns::Columns;
use super::durations::Durations;
use super::trace::Trace;

/// The timing of a schema.
#[derive(Clone, Debug)]
pub(crate) struct SchemaTiming {
    /// Turns in which the schema iterated.
    pub(crate) iterations: u64,
    /// Turns in which the schema checked its precondition or iterated.
    pub(crate) cycles: u64,
    /// Times between iterations at successive deadlines, without pauses.
    pub(crate) periods: Durations,
    /// The same over time, s.
    pub(crate) over_time: Trace,
    /// Durations of the turns.
    pub(crate) busy: Durations,
    last: Option<Nanos>,
}

impl SchemaTiming {
    pub(crate) fn new(columns: Columns) -> Self {
        Self {
            iterations: 0,
            cycles: 0,
            periods: Durations::default(),
            over_time: Trace::new(columns),
            busy: Durations::default(),
            last: None,
        }
    }

    /// Records a turn.
    pub(crate) fn add_turn(&mut self, columns: Columns, turn: &Turn) {
        let permission = match turn.kind() {
            TurnKind::Cycled(permission) => permission,
            TurnKind::Awoke | TurnKind::Slept => return self.pause(columns),
            // A father arbitrates between two of its iterations, and gestures on a panel are delivered there.
            _ => return,
        };
        self.cycles += 1;
        let begun = if turn.looked.has_occurred() {
            turn.looked.clock
        } else {
            turn.acted.clock
        };
        self.busy.add(turn.time().saturating_sub(begun));
        let acted = turn.acted.has_occurred();
        self.iterations += u64::from(acted);
        match (permission, acted) {
            // The first iteration after a takeover occurs at once, between two deadlines.
            (Some(Permission::First), true) => self.pause(columns),
            (_, true) => self.add_start(columns, begun),
            // The deadline came, and the schema was not WINNER.
            (Some(Permission::Any), false) => self.pause(columns),
            // A new value triggered a check before the deadline (R12).
            (_, false) => {}
        }
    }

    /// Records the beginning of a periodic iteration.
    pub(crate) fn add_start(&mut self, columns: Columns, time: Nanos) {
        if let Some(period) = self.last.and_then(|last| time.checked_sub(last)) {
            self.periods.add(period);
            self.over_time.add(columns, time, Some(period as f64 / 1e9));
        }
        self.last = Some(time);
    }

    /// Ends a sequence of periods.
    fn pause(&mut self, columns: Columns) {
        if let Some(last) = self.last.take() {
            self.over_time.add(columns, last, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use jde_core::SchemaId;
    use jde_records::turn::{Call, Exchange};

    use super::*;

    fn call(ms: u64) -> Call {
        Call {
            after: 1,
            time: ms * 1_000_000,
            clock: ms * 1_000_000,
        }
    }

    fn turn(ms: u64, permission: Permission, acts: bool) -> Turn {
        let mut turn = Turn::new(TurnKind::Cycled(Some(permission)), SchemaId(0));
        turn.looked = call(ms);
        if acts {
            turn.acted = call(ms + 1);
            turn.ended.time = (ms + 3) * 1_000_000;
        }
        turn
    }

    #[test]
    fn a_period_is_the_time_between_two_iterations_without_a_pause() {
        let columns = Columns::new(0, 1_000_000_000, 10);
        let mut work = SchemaTiming::new(columns);
        for (ms, acts) in [
            (0, true),
            (100, true),
            (210, true),
            (300, false),
            (400, true),
            (500, true),
        ] {
            work.add_turn(columns, &turn(ms, Permission::Any, acts));
        }
        assert_eq!((work.cycles, work.iterations), (6, 5));
        assert_eq!((work.periods.count(), work.periods.worst()), (3, Some(110e6)));
        assert_eq!(work.busy.worst(), Some(3e6));
        assert_eq!(work.over_time.range(), Some((0.1, 0.11)));
    }

    #[test]
    fn r12_a_check_triggered_by_a_value_is_not_a_pause() {
        let columns = Columns::new(0, 1_000_000_000, 10);
        let mut work = SchemaTiming::new(columns);
        let (any, first) = (Permission::Any, Permission::First);
        let turns = [
            // A takeover between two deadlines; no period yet.
            (60, first, true),
            (75, any, true),
            (100, first, false),
            (125, first, false),
            (150, any, true),
            (175, first, false),
            (225, any, true),
            // The schema loses and wins again.
            (250, first, false),
            (275, first, true),
            (300, any, true),
            (375, any, true),
        ];
        for (ms, permission, acts) in turns {
            work.add_turn(columns, &turn(ms, permission, acts));
        }
        assert_eq!((work.cycles, work.iterations), (11, 7));
        assert_eq!(work.periods.count(), 3);
        assert_eq!(work.periods.mean(), Some(75e6));
        assert_eq!(work.periods.worst(), Some(75e6));
    }

    #[test]
    fn r4_a_father_that_arbitrates_keeps_its_period() {
        let columns = Columns::new(0, 1_000_000_000, 10);
        let mut work = SchemaTiming::new(columns);
        let other = |kind| {
            let mut turn = turn(130, Permission::Any, false);
            turn.set_kind(kind);
            turn
        };
        work.add_turn(columns, &turn(100, Permission::Any, true));
        for kind in [
            TurnKind::Arbitrated { group: 0 },
            TurnKind::Touched { number: 1 },
            TurnKind::Reloaded(Exchange::New),
        ] {
            work.add_turn(columns, &other(kind));
        }
        work.add_turn(columns, &turn(200, Permission::Any, true));
        assert_eq!(work.periods.worst(), Some(100e6));
        work.add_turn(columns, &other(TurnKind::Slept));
        work.add_turn(columns, &turn(300, Permission::Any, true));
        assert_eq!((work.periods.count(), work.iterations), (1, 3));
    }
}
