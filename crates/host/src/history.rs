//! The last values of a variable, so that a reader sees the one that it saw when it took its turn first, not the newest.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use jde_board::{Stamp, Variable};

use crate::turn::Turn;

/// Fewest values kept: a thread that was held up between looking and telling is some values late.
const FEWEST: usize = 16;
/// Bytes kept of a variable beyond those.
const ROOM: usize = 1 << 20;

/// The last values of a variable.
pub(crate) struct History {
    inner: Mutex<Inner>,
    most: usize,
}

/// A value that was published.
pub(crate) struct Old {
    pub(crate) stamp: Stamp,
    bytes: Aligned,
}

/// Bytes aligned for any value.
pub(crate) struct Aligned {
    words: Vec<u128>,
    bytes: usize,
}

#[derive(Default)]
struct Inner {
    values: VecDeque<Arc<Old>>,
    retracted: bool,
    missed: u64,
}

impl History {
    /// Of a variable; it begins with the value that is there.
    pub(crate) fn of(variable: &Arc<Variable>) -> Arc<Self> {
        let history = Arc::new(Self {
            inner: Mutex::default(),
            most: FEWEST.max(ROOM / variable.describe().value_type.bytes.max(1)),
        });
        history.take(variable);
        history
    }

    /// Takes over the newest value of the variable.
    pub(crate) fn take(&self, variable: &Arc<Variable>) {
        let mut reader = variable.reader("replay");
        match reader.latch() {
            Some(latched) => self.put(latched.stamp, latched.bytes),
            None => self.retract(),
        }
    }

    /// Adds a value; one that is there already is not added again.
    pub(crate) fn put(&self, stamp: Stamp, bytes: &[u8]) {
        let mut inner = self.lock();
        inner.retracted = false;
        if inner
            .values
            .back()
            .is_some_and(|last| last.stamp.sequence == stamp.sequence)
        {
            return;
        }
        if inner.values.len() == self.most {
            inner.values.pop_front();
        }
        let bytes = Aligned::new(bytes);
        inner.values.push_back(Arc::new(Old { stamp, bytes }));
    }

    /// The newest value no longer stands.
    pub(crate) fn retract(&self) {
        self.lock().retracted = true;
    }

    /// Whether it has come as far as the value of that number, as turns tell numbers.
    pub(crate) fn has(&self, wanted: u32) -> bool {
        let newest = self.lock().values.back().map(|last| last.stamp.sequence);
        newest.is_some_and(|newest| (newest as u32).wrapping_sub(wanted) < u32::MAX / 2)
    }

    /// The value of that number, as turns tell them; the newest if none is told or that one is not there, which is counted.
    pub(crate) fn find(&self, wanted: u32) -> Option<Arc<Old>> {
        let mut inner = self.lock();
        if wanted == Turn::NOTHING {
            return None;
        }
        if wanted != Turn::UNSEEN {
            let mut values = inner.values.iter().rev();
            if let Some(found) = values.find(|old| old.stamp.sequence as u32 == wanted) {
                return Some(Arc::clone(found));
            }
            inner.missed += 1;
        }
        inner.values.back().filter(|_| !inner.retracted).cloned()
    }

    /// How often a value was looked for that was not there.
    pub(crate) fn missed(&self) -> u64 {
        self.lock().missed
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Old {
    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.bytes()
    }
}

impl Aligned {
    pub(crate) fn new(bytes: &[u8]) -> Self {
        let mut words = vec![0_u128; bytes.len().div_ceil(16)];
        for (word, chunk) in words.iter_mut().zip(bytes.chunks(16)) {
            let mut whole = [0; 16];
            whole[..chunk.len()].copy_from_slice(chunk);
            *word = u128::from_ne_bytes(whole);
        }
        Self {
            words,
            bytes: bytes.len(),
        }
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.words)[..self.bytes]
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.words)[..self.bytes]
    }
}
