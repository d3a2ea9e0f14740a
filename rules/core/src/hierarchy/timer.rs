//! The timers of a hierarchy, which cause transactions without a report of the executor.
//!
//! It refuses to wait: an executor queries the next due time and reports when it has been reached.

use std::collections::BTreeMap;

use super::Hierarchy;
use super::transaction::Transaction;
use crate::spec::{GroupId, Nanos, SchemaId};

/// An event at a time that is known in advance. Each timer exists at most once.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Timer {
    /// The patience with the loser of this group ends (R1).
    Patience(GroupId),
    /// The father of this group has used up its arbitration budget (R4).
    Arbitration(GroupId),
    /// A dwell time or a turn in this group ends, which can change the choice.
    Turn(GroupId),
    /// The hold of the last command from this group ends (R9).
    Hold(GroupId),
    /// The back-off of this faulted schema ends.
    Restart(SchemaId),
    /// This schema, whose command a guard refused, may be READY again (R18).
    Retry(SchemaId),
}

/// The armed timers and when they are due.
#[derive(Clone, Default, PartialEq, Eq, Hash, Debug)]
pub(super) struct Timers(BTreeMap<Timer, Nanos>);

impl Timers {
    pub(super) fn arm(&mut self, timer: Timer, due: Nanos) {
        self.0.insert(timer, due);
    }

    pub(super) fn disarm(&mut self, timer: Timer) {
        if !self.0.is_empty() {
            self.0.remove(&timer);
        }
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}

impl Hierarchy {
    /// Returns the time of the next timer.
    #[must_use]
    pub fn next_timer(&self) -> Option<Nanos> {
        self.timers.0.values().min().copied()
    }

    /// Returns all armed timers with their due times, in the order of [`Timer`].
    pub fn timers(&self) -> impl Iterator<Item = (Nanos, Timer)> {
        self.timers.0.iter().map(|(&timer, &due)| (due, timer))
    }
}

impl Transaction<'_> {
    /// Fires every timer that is due, the earliest first.
    pub fn tick(&mut self) {
        while let Some((due, timer)) = self.timers().min()
            && due <= self.now
        {
            self.fire(timer);
        }
    }

    /// Fires one timer as if its time had been reached. Has no effect if it is not armed. If its time is later than
    /// this transaction, it fires at its time.
    pub fn fire(&mut self, timer: Timer) {
        let Some(due) = self.timers.0.remove(&timer) else {
            return;
        };
        let now = self.now;
        self.now = now.max(due);
        match timer {
            Timer::Patience(group) => self.expire(group),
            Timer::Arbitration(group) => self.arbitration_late(group),
            Timer::Turn(group) => self.end_turn(group),
            Timer::Hold(group) => self.brake(group),
            Timer::Restart(id) => self.restart(id),
            Timer::Retry(id) => self.retry(id),
        }
        self.settle();
        self.now = now;
    }
}
