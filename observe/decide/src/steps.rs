//! Puts steps in their order. A turn is recorded at its end, so its steps arrive after those of turns that
//! began later.
//!
//! Transactions have consecutive numbers: a step is next when all transactions before it have occurred. A
//! number that does not arrive in time was lost, and is counted.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_core::Nanos;
use jde_host::replay::ReplayStep;
use jde_records::turn::RecordedTurn;

/// Steps that wait for earlier ones.
pub(super) struct Steps {
    /// By their position: a transaction precedes the calls that follow it, which are in the order of their
    /// times.
    queue: BTreeMap<(u64, bool, Nanos, u64), ReplayStep>,
    count: u64,
    /// The number of the next transaction.
    expected: u64,
    lost: u64,
}

/// Where the recording ends, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RecordingEnd {
    /// There is more. Steps before the given time that have not arrived were lost.
    More(Option<Nanos>),
    /// It ends here.
    Complete,
    /// It ends here because it was cut off. Missing steps were not yet recorded.
    CutOff,
}

/// The result of a request for the next step.
#[derive(Debug)]
pub(super) enum Next {
    /// The next step.
    Step(ReplayStep),
    /// It is unknown until more has been read.
    Wait,
    /// There are no more steps.
    Done,
}

impl Steps {
    pub(super) fn new() -> Self {
        Self {
            queue: BTreeMap::new(),
            count: 0,
            expected: 1,
            lost: 0,
        }
    }

    /// Adds the steps of a turn.
    pub(super) fn put(&mut self, turn: &Arc<RecordedTurn>) {
        for step in ReplayStep::of(turn) {
            self.count += 1;
            let key = (step.order, !step.is_transaction(), step.time, self.count);
            self.queue.insert(key, step);
        }
    }

    /// Returns the next step.
    pub(super) fn next(&mut self, end: RecordingEnd) -> Next {
        let Some((_, first)) = self.queue.first_key_value() else {
            return match end {
                RecordingEnd::More(_) => Next::Wait,
                RecordingEnd::Complete | RecordingEnd::CutOff => Next::Done,
            };
        };
        let (order, is_transaction) = (first.order, first.is_transaction());
        // All transactions before this step must have occurred.
        let needed = if is_transaction { order } else { order + 1 };
        if needed > self.expected {
            match end {
                RecordingEnd::More(late) if late.is_none_or(|late| first.time >= late) => return Next::Wait,
                RecordingEnd::CutOff => return Next::Done,
                RecordingEnd::More(_) | RecordingEnd::Complete => {
                    self.lost += needed - self.expected;
                    self.expected = needed;
                }
            }
        }
        let Some((_, step)) = self.queue.pop_first() else {
            return Next::Done;
        };
        if is_transaction {
            self.expected = self.expected.max(order + 1);
        }
        Next::Step(step)
    }

    /// Returns the number of transactions that never arrived.
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }
}

#[cfg(test)]
mod tests {
    use jde_core::SchemaId;
    use jde_records::turn::{Call, Moment, Turn, TurnKind};

    use super::*;

    fn recorded(turn: Turn) -> Arc<RecordedTurn> {
        let ports = Vec::new();
        Arc::new(RecordedTurn { turn, ports })
    }

    fn tick(order: u64, time: Nanos) -> Arc<RecordedTurn> {
        let mut turn = Turn::new(TurnKind::Ticked, SchemaId(0));
        turn.checked = Moment { order, time };
        recorded(turn)
    }

    /// Returns a turn that reads after transaction `after` and reports to the rules in transaction `checked`.
    fn check(after: u64, checked: u64, time: Nanos) -> Arc<RecordedTurn> {
        let mut turn = Turn::new(TurnKind::Cycled(None), SchemaId(0));
        turn.looked = Call {
            after,
            time,
            clock: time,
        };
        turn.checked = Moment {
            order: checked,
            time: time + 5,
        };
        recorded(turn)
    }

    fn orders(steps: &mut Steps, end: RecordingEnd) -> Vec<(u64, bool)> {
        let next = || match steps.next(end) {
            Next::Step(step) => Some((step.order, step.is_transaction())),
            Next::Wait | Next::Done => None,
        };
        std::iter::from_fn(next).collect()
    }

    #[test]
    fn steps_are_in_the_recorded_order_of_transactions() {
        let mut steps = Steps::new();
        let more = RecordingEnd::More(None);
        // The check was delayed between reading and reporting, and two other transactions occurred between.
        steps.put(&tick(1, 10));
        steps.put(&tick(3, 12));
        assert_eq!(
            orders(&mut steps, more),
            [(1, true)],
            "the second may still arrive"
        );
        steps.put(&tick(2, 11));
        assert_eq!(orders(&mut steps, more), [(2, true), (3, true)]);
        steps.put(&check(2, 4, 11));
        assert_eq!(orders(&mut steps, more), [(2, false), (4, true)]);
    }

    #[test]
    fn missing_transactions_are_counted_and_skipped() {
        let mut steps = Steps::new();
        steps.put(&tick(1, 10));
        steps.put(&tick(4, 100));
        assert_eq!(orders(&mut steps, RecordingEnd::More(Some(100))), [(1, true)]);
        assert_eq!(orders(&mut steps, RecordingEnd::More(Some(101))), [(4, true)]);
        assert_eq!(steps.lost(), 2);
        steps.put(&tick(7, 200));
        assert_eq!(
            orders(&mut steps, RecordingEnd::CutOff),
            [],
            "the turn was not recorded yet"
        );
        assert_eq!(steps.lost(), 2);
        assert_eq!(orders(&mut steps, RecordingEnd::Complete), [(7, true)]);
        assert_eq!(steps.lost(), 4);
    }
}
