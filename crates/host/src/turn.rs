//! What every schema's turns were: when each of its steps was taken, and which value of each input it saw.
//!
//! Enough to have another build of a schema take the same turns again: see `replay`. Keeps nothing itself; whoever wants the
//! turns is told of each, on the thread of the schema that took it.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use jde_core::Nanos;
use jde_types::{Padding, Seq, Value};

/// Ports that a turn itself tells of; those beyond follow from turns of the kind [`Turn::MORE`] just before it.
pub const INPUTS: usize = 32;

/// Where a transaction of the rules is in their order, and when it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Moment")]
pub struct Moment {
    /// Counts the transactions that turns tell of, from 1; 0: there was none.
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
    /// The last transaction before it looked at its last input; 0 and no time: there was no call.
    pub after: u64,
    /// When that was, or if it looked at nothing when it began.
    #[value(unit = "ns")]
    pub time: u64,
    /// What it was first told when it asked for the time, or when it began.
    #[value(unit = "ns")]
    pub clock: u64,
}

/// One turn of a schema, or a transaction that is nobody's turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Turn")]
pub struct Turn {
    /// 1 awoke, 2 slept, 3 checked or iterated, 4 arbitrated; and without a schema's doing 5 start, 6 timer, 7 operator, 8 given
    /// up, 9 end, 10 a father woke a child, put it to sleep or changed a policy, 11 somebody touched its panel, 12 another build of
    /// it took over, 13 more ports of its next turn.
    pub kind: u8,
    /// How it asked leave to iterate: 1 as ever, 2 only to take over. What an operator did: 1 play, 2 stop, 3 force, 4 release,
    /// 5 write a modulation or a period, 6 unload, 7 load, 8 stop everything, 9 release everything, 10 let go at the end of a lease. Of a father: 1 wake, 2 put to
    /// sleep, 3 change the policy. Of a reload: 1 a new build took over, 2 the one before did again. Else 0.
    pub way: u8,
    /// Nothing.
    pub padding: Padding<2>,
    /// Whose, by its place in the application.
    pub schema: u32,
    /// The group it arbitrated; or the modulation that an operator wrote by its place among the ports, 4294967295 for the
    /// period; or the child that a father woke or put to sleep, or the group whose policy it changed; or the number of the gesture,
    /// as events tell it; or the number of the first of more ports.
    pub detail: u64,
    /// The question that it answered by arbitrating: they are counted.
    pub ticket: u64,
    /// The check, or the one call there was.
    pub looked: Call,
    /// The call failed.
    pub failed: Moment,
    /// The rules were told what the check found, or whatever there was to tell.
    pub checked: Moment,
    /// Leave to iterate was asked.
    pub begun: Moment,
    /// The iteration, if there was leave.
    pub acted: Call,
    /// The rules were told of its end.
    pub ended: Moment,
    /// The numbers of the values that its ports showed, in their order; 4294967295 where it did not look, 4294967294 where there
    /// was none. Of ports that it writes, of the last value that it wrote in this turn; 4294967295 where it wrote none, 4294967294
    /// where that was refused (R7) or taken back. Of a value that an operator wrote, its number.
    pub inputs: Seq<u32, INPUTS>,
}

/// A turn, with all its ports.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Told {
    /// The turn.
    pub turn: Turn,
    /// As [`Turn::inputs`] has it, of every port.
    pub ports: Vec<u32>,
}

/// Is told of each turn when it is over; it must return at once.
pub type OnTurn = Arc<dyn Fn(&Turn) + Send + Sync>;

/// Numbers transactions and passes turns on.
pub(crate) struct Journal {
    last: AtomicU64,
    tell: OnTurn,
}

impl Turn {
    /// Kind: it awoke.
    pub const AWOKE: u8 = 1;
    /// Kind: it went to sleep.
    pub const SLEPT: u8 = 2;
    /// Kind: it checked, iterated, or both.
    pub const CYCLED: u8 = 3;
    /// Kind: it arbitrated.
    pub const ARBITRATED: u8 = 4;
    /// Kind: the application started.
    pub const STARTED: u8 = 5;
    /// Kind: timers of the rules were due.
    pub const TICKED: u8 = 6;
    /// Kind: an operator acted.
    pub const OPERATED: u8 = 7;
    /// Kind: a call did not return, and the schema was given up.
    pub const GIVEN_UP: u8 = 8;
    /// Kind: everything was put to sleep.
    pub const ENDED: u8 = 9;
    /// Kind: a father woke a child, put it to sleep or changed the policy of a group, and something came of it.
    pub const LED: u8 = 10;
    /// Kind: somebody did something to its panel.
    pub const TOUCHED: u8 = 11;
    /// Kind: another build of it took over, or the one before did again.
    pub const RELOADED: u8 = 12;
    /// Kind: no turn of its own, but more ports of the next one of that schema.
    pub const MORE: u8 = 13;

    /// Way: it asked leave as ever.
    pub const ANY: u8 = 1;
    /// Way: it asked leave only for its first iteration as WINNER.
    pub const FIRST: u8 = 2;

    /// Way of a father: it woke a child.
    pub const WOKE: u8 = 1;
    /// Way of a father: it put a child to sleep.
    pub const LAID_DOWN: u8 = 2;
    /// Way of a father: it changed the policy of a group.
    pub const CHANGED_POLICY: u8 = 3;

    /// Way of an operator.
    pub const PLAYED: u8 = 1;
    /// Way of an operator.
    pub const STOPPED: u8 = 2;
    /// Way of an operator.
    pub const FORCED: u8 = 3;
    /// Way of an operator.
    pub const RELEASED: u8 = 4;
    /// Way of an operator: a modulation or a period.
    pub const WROTE: u8 = 5;
    /// Way of an operator.
    pub const UNLOADED: u8 = 6;
    /// Way of an operator: it was unloaded or had faulted, and has a fresh start.
    pub const LOADED: u8 = 7;
    /// Way of an operator: all roots.
    pub const ALL_STOPPED: u8 = 8;
    /// Way of an operator: all roots.
    pub const ALL_RELEASED: u8 = 9;
    /// Way of an operator: what it did to one schema.
    pub const LET_GO: u8 = 10;
    /// Way of a reload: a new build took over.
    pub const TOOK_OVER: u8 = 1;
    /// Way of a reload: the build before took over again.
    pub const WENT_BACK: u8 = 2;
    /// The place of the period among the ports.
    pub const PERIOD: u64 = u32::MAX as u64;

    /// Port: it did not look; nor write.
    pub const UNSEEN: u32 = u32::MAX;
    /// Port: it looked, and there was no value; or it wrote, and was refused for want of authority, or took its value back.
    pub const NOTHING: u32 = u32::MAX - 1;

    /// One that has yet to begin.
    pub(crate) fn of(kind: u8, schema: usize) -> Self {
        Self {
            kind,
            schema: schema as u32,
            ..Self::default()
        }
    }

    /// When the last of it was.
    #[must_use]
    pub fn time(&self) -> Nanos {
        let moments = [self.failed, self.checked, self.begun, self.ended];
        let calls = [self.looked, self.acted];
        let moments = moments.into_iter().map(|moment| moment.time);
        let calls = calls.into_iter().map(|call| call.time);
        moments.chain(calls).max().unwrap_or(0)
    }

    /// Whether nothing of it happened.
    pub(crate) fn is_empty(&self) -> bool {
        let moments = [self.failed, self.checked, self.begun, self.ended];
        moments.iter().all(|moment| moment.order == 0) && !self.looked.happened() && !self.acted.happened()
    }
}

impl Told {
    /// Which value a port showed, or which it wrote.
    #[must_use]
    pub fn port(&self, port: usize) -> u32 {
        self.ports.get(port).copied().unwrap_or(Turn::UNSEEN)
    }
}

impl Deref for Told {
    type Target = Turn;

    fn deref(&self) -> &Turn {
        &self.turn
    }
}

impl Call {
    /// Whether there was one.
    #[must_use]
    pub fn happened(&self) -> bool {
        *self != Self::default()
    }
}

impl Journal {
    pub(crate) fn new(tell: OnTurn) -> Self {
        Self {
            last: AtomicU64::new(0),
            tell,
        }
    }

    /// The number of the next transaction; under the rules' lock.
    pub(crate) fn next(&self) -> u64 {
        self.last.fetch_add(1, Ordering::AcqRel) + 1
    }

    /// The number of the last transaction.
    pub(crate) fn last(&self) -> u64 {
        self.last.load(Ordering::Acquire)
    }

    pub(crate) fn tell(&self, turn: &Turn) {
        (self.tell)(turn);
    }

    /// A turn of a schema with so many ports that not all of them are in it.
    pub(crate) fn tell_all(&self, turn: &Turn, more: &[u32]) {
        for (place, ports) in more.chunks(INPUTS).enumerate() {
            let mut next = Turn {
                kind: Turn::MORE,
                schema: turn.schema,
                detail: (INPUTS * (place + 1)) as u64,
                // It is no step of its own, but messages have a time.
                checked: Moment {
                    order: 0,
                    time: turn.time(),
                },
                ..Turn::default()
            };
            next.inputs.resize(ports.len()).copy_from_slice(ports);
            self.tell(&next);
        }
        self.tell(turn);
    }
}
