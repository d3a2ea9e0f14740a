//! What ports know of the guards of commands (R18): which ones judge a command, and the newest state of each, which
//! all who judge by it share. No lock is held and no port is in use while a guard judges.

#![allow(unsafe_code)]

use std::sync::Arc;

use jde_board::{Reader, Variable};
use jde_core::{Nanos, SchemaId};
use jde_loader::{AlignedBytes, Judge, Judgement};
use parking_lot::Mutex;

/// The periods of a guard for which a state counts without a newer one. One late or skipped turn is usual on
/// a machine without real-time scheduling; two in a row are not.
const VALIDITY_PERIODS: Nanos = 3;

/// A guard of the commands of one port.
#[derive(Clone)]
pub(crate) struct PortGuard {
    pub(crate) guard: SchemaId,
    pub(crate) state: Arc<GuardState>,
    /// The schemas whose commands it judges.
    commanders: Arc<[u32]>,
}

/// The state by which a guard judges, for everybody.
pub(crate) struct GuardState {
    /// How long it counts, by the period that the application states: nobody lengthens it.
    validity: Nanos,
    newest: Mutex<NewestState>,
}

struct NewestState {
    reader: Reader,
    /// Until when the newest state counts.
    valid_until: Nanos,
    copy: Option<Arc<StateCopy>>,
}

/// A copy of a state. It stays as it is for as long as somebody judges by it.
pub(crate) struct StateCopy {
    bytes: AlignedBytes,
    /// The time of the oldest value that it was made of.
    time: Nanos,
    pub(crate) sequence: u64,
}

/// A command that guards judge, as a copy.
pub(crate) struct UnjudgedCommand {
    pub(crate) guards: Arc<[PortGuard]>,
    pub(crate) bytes: AlignedBytes,
}

/// A command that is in force.
pub(crate) struct CommandInForce {
    pub(crate) variable: Arc<Variable>,
    pub(crate) sequence: u64,
    /// The schema that gave it.
    pub(crate) commander: SchemaId,
}

/// The newest state of a guard and the commands in force that it has not judged by that state, as copies.
pub(crate) struct UnjudgedInForce {
    pub(crate) state: Result<Arc<StateCopy>, String>,
    pub(crate) commands: Vec<(CommandInForce, AlignedBytes)>,
}

/// What a guard judges beside what is commanded: the commands in force. Only a guard has it, with its ports.
pub(crate) struct Guarding {
    /// The port that exports its state.
    pub(crate) port: usize,
    pub(crate) state: Arc<GuardState>,
    /// The commands of drivers, and the schemas whose commands to them it judges.
    pub(crate) commands: Vec<(Reader, Arc<[u32]>)>,
    /// The number of the state by which they were last judged; 0 for none.
    pub(crate) judged_by: u64,
}

/// Why a command does not take effect.
pub(crate) struct Refusal {
    /// The schema that gave it.
    pub(crate) commander: SchemaId,
    /// The guard.
    pub(crate) guard: SchemaId,
    /// The reason of the guard, in words.
    pub(crate) reason: String,
    /// The command and its number, if it was in force.
    pub(crate) in_force: Option<(Arc<Variable>, u64)>,
}

impl PortGuard {
    pub(crate) fn new(guard: SchemaId, state: &Arc<GuardState>, commanders: Vec<u32>) -> Self {
        Self {
            guard,
            state: Arc::clone(state),
            commanders: commanders.into(),
        }
    }

    /// Whether it judges commands of that schema.
    pub(super) fn judges(&self, commander: u32) -> bool {
        self.commanders.contains(&commander)
    }
}

impl GuardState {
    /// The state of a guard of that period, by the application.
    pub(crate) fn new(reader: Reader, period: Nanos) -> Arc<Self> {
        Arc::new(Self {
            validity: period.saturating_mul(VALIDITY_PERIODS),
            newest: Mutex::new(NewestState {
                reader,
                valid_until: 0,
                copy: None,
            }),
        })
    }

    /// Records that the guard published a state, made of values that are valid until `until`.
    pub(super) fn record_published(&self, now: Nanos, until: Nanos) {
        self.newest.lock().valid_until = now.saturating_add(self.validity).min(until);
    }

    /// Returns the state by which commands are judged now.
    ///
    /// # Errors
    /// Why none is, in words.
    pub(crate) fn newest(&self, now: Nanos) -> Result<Arc<StateCopy>, String> {
        let NewestState {
            reader,
            valid_until,
            copy,
        } = &mut *self.newest.lock();
        let newest = reader.latch_newest(now).filter(|state| state.stamp.sequence > 0);
        let Some(state) = newest else {
            *copy = None;
            return Err(String::from("the guard has no state"));
        };
        let (time, sequence) = (state.stamp.time, state.stamp.sequence);
        if now > *valid_until {
            let age = now.saturating_sub(time) as f64 / 1e6;
            return Err(format!("the state of the guard is {age:.0} ms old"));
        }
        if let Some(copy) = copy
            && copy.sequence == sequence
        {
            return Ok(Arc::clone(copy));
        }
        Ok(Arc::clone(copy.insert(Arc::new(StateCopy {
            bytes: AlignedBytes::new(state.bytes),
            time,
            sequence,
        }))))
    }
}

impl StateCopy {
    /// Judges a command by this state. It calls the plugin, which may not return.
    pub(crate) fn judge(&self, judge: &Judge, now: Nanos, command: &AlignedBytes) -> Judgement {
        let age = now.saturating_sub(self.time);
        // SAFETY: the application was refused unless the guard states the types of its export and of the
        // command. Both values are on 16-byte boundaries.
        unsafe { judge.judge(self.bytes.bytes(), age, command.bytes()) }
    }
}
