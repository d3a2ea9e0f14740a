//! The turns of schemas: when each step of a turn was taken, and which value of each input it used.
//!
//! This is enough for another build of a schema to take the same turns again: see `replay`. Nothing is stored
//! here: each turn is passed to an [`OnTurn`] function, on the thread of the schema that took it.

use std::ops::Deref;
use std::sync::Arc;

use jde_core::{Nanos, SchemaId};
use jde_types::{Padding, Seq, Value};

pub use crate::turn_kind::{Exchange, FatherOperation, Operation, Permission, TurnKind, WrittenPort};

/// Ports that one [`Turn`] holds. Further ports precede it in turns of kind [`TurnKind::MorePorts`].
pub const INPUTS: usize = 32;

/// The position of a transaction in the order of the rules' transactions, and its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Moment")]
pub struct Moment {
    /// Counts the transactions that turns refer to, from 1; 0: there was none.
    pub order: u64,
    /// Since the application's start.
    #[value(unit = "ns")]
    pub time: u64,
}

/// A call into a schema.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Call")]
pub struct Call {
    /// The last transaction before the call read its last input; 0 with all other fields 0: there was no
    /// call.
    pub after: u64,
    /// When the call read its last input; if it read none, when it began.
    #[value(unit = "ns")]
    pub time: u64,
    /// The first time that the call obtained from the clock; if it obtained none, when it began.
    #[value(unit = "ns")]
    pub clock: u64,
}

/// One turn of a schema, or a transaction that belongs to no schema's turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Turn")]
pub struct Turn {
    /// 1 awoke; 2 slept; 3 checked or iterated; 4 arbitrated. Others: 5 start; 6 timer; 7 operator; 8 given
    /// up; 9 end; 10 a father woke a child, put it to sleep or changed a policy; 11 a gesture on its panel;
    /// 12 another build took over; 13 more ports of its next turn; 14 a guard refused its command.
    kind: u8,
    /// How it requested permission to iterate: 1 in general; 2 only to take over. What an operator did: 1
    /// play; 2 stop; 3 force; 4 release; 5 write a modulation or a period; 6 unload; 7 load; 8 stop
    /// everything; 9 release everything; 10 undo at the end of a lease; 11 let an export fail; 12 repair it;
    /// 13 a debugger holds a call; 14 it goes on. A father: 1 wake; 2 put to sleep; 3
    /// change the policy. A reload: 1 a new build took over; 2 the build before took over again. Otherwise 0.
    way: u8,
    /// Unused.
    pub padding: Padding<2>,
    /// The schema, by its place in the application.
    pub schema: u32,
    /// The group that it arbitrated; or the port whose value an operator wrote, or that an operator let fail or
    /// repaired, by its place among the ports, 4294967295 for the period; or the child that a father woke or put to sleep, or the group whose policy
    /// it changed; or the number of the gesture, as in events; or the number of the first of more ports. For what
    /// else an operator did: the number of the operator, doubled, plus 1 under a lease; 0 in older recordings.
    detail: u64,
    /// The number of the request that this arbitration answers; requests are counted.
    pub ticket: u64,
    /// The check, or the only call of the turn.
    pub looked: Call,
    /// The call failed.
    pub failed: Moment,
    /// The rules received the result of the check, or whatever else the turn reported to them.
    pub checked: Moment,
    /// The schema requested permission to iterate.
    pub begun: Moment,
    /// The iteration, if it was permitted.
    pub acted: Call,
    /// The rules received the end of the iteration.
    pub ended: Moment,
    /// The sequence numbers of the values that its ports showed, in port order; 4294967295 if a port was not
    /// read, 4294967294 if it had no value. For ports that it writes: the number of the last value written in
    /// this turn; 4294967295 if it wrote none, 4294967294 if the write was refused (R7, R18) or retracted. For a
    /// value that an operator wrote: its number. For an export that an operator let fail: the failure, in words
    /// of 32 bits.
    pub inputs: Seq<u32, INPUTS>,
}

/// A turn with all its ports.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedTurn {
    /// The turn.
    pub turn: Turn,
    /// As in [`Turn::inputs`], for every port.
    pub ports: Vec<u32>,
}

/// Called with each turn when it is over. It must return at once.
pub type OnTurn = Arc<dyn Fn(&Turn) + Send + Sync>;

impl Turn {
    /// Returns what the turn was.
    #[must_use]
    pub fn kind(&self) -> TurnKind {
        TurnKind::of_numbers((self.kind, self.way, self.detail))
    }

    /// Sets what the turn was.
    pub fn set_kind(&mut self, kind: TurnKind) {
        (self.kind, self.way, self.detail) = kind.numbers();
    }

    /// Whether the iteration began before the check, which was part of the same call.
    #[must_use]
    pub fn began_early(&self) -> bool {
        self.begun.order > 0 && self.begun.order <= self.looked.after
    }

    /// Port: it was neither read nor written.
    pub const UNUSED: u32 = u32::MAX;
    /// Port: it was read and had no value; or a write to it was refused for lack of authority, or was
    /// retracted.
    pub const NO_VALUE: u32 = u32::MAX - 1;

    /// Returns a turn that has not begun.
    #[must_use]
    pub fn new(kind: TurnKind, schema: SchemaId) -> Self {
        let mut turn = Self {
            schema: schema.0,
            ..Self::default()
        };
        turn.set_kind(kind);
        turn
    }

    /// Returns the time of the latest step of the turn.
    #[must_use]
    pub fn time(&self) -> Nanos {
        let moments = [self.failed, self.checked, self.begun, self.ended];
        let calls = [self.looked, self.acted];
        let moments = moments.into_iter().map(|moment| moment.time);
        let calls = calls.into_iter().map(|call| call.time);
        moments.chain(calls).max().unwrap_or(0)
    }

    /// Whether no step of the turn was taken.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let moments = [self.failed, self.checked, self.begun, self.ended];
        moments.iter().all(|moment| moment.order == 0)
            && !self.looked.has_occurred()
            && !self.acted.has_occurred()
    }
}

impl RecordedTurn {
    /// Returns the number of the value that a port showed, or that was written to it.
    #[must_use]
    pub fn port(&self, port: usize) -> u32 {
        self.ports.get(port).copied().unwrap_or(Turn::UNUSED)
    }
}

impl Deref for RecordedTurn {
    type Target = Turn;

    fn deref(&self) -> &Turn {
        &self.turn
    }
}

impl Call {
    /// Whether there was a call.
    #[must_use]
    pub fn has_occurred(&self) -> bool {
        *self != Self::default()
    }
}
