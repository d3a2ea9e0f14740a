//! The last values of a variable. In a replay of decisions, a reader receives the value that it used in the
//! original turn, not the newest.

use std::collections::VecDeque;
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_board::{Stamp, Variable};
use parking_lot::Mutex;

use jde_loader::AlignedBytes;
use jde_records::turn::Turn;

/// The least number of values kept: several values may be published between the reading of a value and the
/// report of the turn.
const MIN_VALUES: usize = 16;
/// The most bytes kept per variable, unless [`MIN_VALUES`] values need more.
const MAX_BYTES: usize = 1 << 20;

/// The last values of a variable.
pub(crate) struct History {
    inner: Mutex<Inner>,
    value_type: Arc<Type>,
    capacity: usize,
}

/// A value that was published.
pub(crate) struct HistoricValue {
    pub(crate) stamp: Stamp,
    bytes: AlignedBytes,
}

#[derive(Default)]
struct Inner {
    values: VecDeque<Arc<HistoricValue>>,
    retracted: bool,
    missed: u64,
}

impl History {
    /// Returns the history of a variable, which begins with the current value.
    pub(crate) fn of(variable: &Arc<Variable>) -> Arc<Self> {
        let history = Arc::new(Self {
            inner: Mutex::default(),
            value_type: Arc::clone(&variable.describe().value_type),
            capacity: MIN_VALUES.max(MAX_BYTES / variable.describe().value_type.bytes.max(1)),
        });
        history.record_newest(variable);
        history
    }

    /// Adds the newest value of the variable. Its validity does not matter: turns name the values that they used.
    pub(crate) fn record_newest(&self, variable: &Arc<Variable>) {
        let mut reader = variable.reader("replay");
        match reader.latch(0) {
            Some(latched) => self.push(latched.stamp, latched.bytes),
            None => self.retract(),
        }
    }

    /// Adds a value, unless it is the newest one already.
    pub(crate) fn push(&self, stamp: Stamp, bytes: &[u8]) {
        let mut inner = self.inner.lock();
        inner.retracted = false;
        if inner
            .values
            .back()
            .is_some_and(|last| last.stamp.sequence == stamp.sequence)
        {
            return;
        }
        if inner.values.len() == self.capacity {
            inner.values.pop_front();
        }
        let mut copy = AlignedBytes::zeros(bytes.len());
        self.value_type.copy_into(bytes, copy.bytes_mut());
        inner
            .values
            .push_back(Arc::new(HistoricValue { stamp, bytes: copy }));
    }

    /// Marks the newest value as retracted.
    pub(crate) fn retract(&self) {
        self.inner.lock().retracted = true;
    }

    /// Whether the value of that number, or a later one, has arrived. Numbers are as in turns.
    pub(crate) fn has_reached(&self, number: u32) -> bool {
        let newest = self.inner.lock().values.back().map(|last| last.stamp.sequence);
        newest.is_some_and(|newest| (newest as u32).wrapping_sub(number) < u32::MAX / 2)
    }

    /// Returns the value of that number, numbered as in turns. If no number is given, or that value is
    /// missing (which is counted), returns the newest.
    pub(crate) fn find(&self, number: u32) -> Option<Arc<HistoricValue>> {
        let mut inner = self.inner.lock();
        if number == Turn::NO_VALUE {
            return None;
        }
        if number != Turn::UNUSED {
            let mut values = inner.values.iter().rev();
            if let Some(found) = values.find(|value| value.stamp.sequence as u32 == number) {
                return Some(Arc::clone(found));
            }
            inner.missed += 1;
        }
        inner.values.back().filter(|_| !inner.retracted).cloned()
    }

    /// Returns how often a requested value was missing.
    pub(crate) fn missed(&self) -> u64 {
        self.inner.lock().missed
    }
}

impl HistoricValue {
    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.bytes()
    }
}
