//! What a schema writes: exports, actuators, modulations of its children.

#![allow(unsafe_code)]

use core::marker::PhantomData;
use core::ops::{Deref, DerefMut};
use core::ptr::NonNull;
use core::time::Duration;

use jde_abi::raw;
use jde_types::{Modulated, Value, wire};

use crate::context::{Context, broken};
use crate::slot::Slot;

/// A variable that this schema writes and any may read.
#[derive(Debug)]
pub struct Export<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// A driver's command that this motor schema writes.
#[derive(Debug)]
pub struct Actuator<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// A modulation of a child that this schema writes.
#[derive(Debug)]
pub struct Modulates<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// What became of something a schema asked for. None of these is a fault: the host counts and shows what it refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It was done.
    Accepted,
    /// The schema has no authority at this instant (R7), or an operator holds the child.
    Refused,
    /// The value holds a NaN or an infinity where a finite number is required.
    NotFinite,
    /// The number is outside of what the child's modulation takes.
    OutOfRange,
    /// The application left this optional port or child unbound.
    Unbound,
}

/// Room for the next value of an export, to be written in place; dropped without publishing, nobody sees it.
///
/// It holds the bytes of some older value, or of none: write all of it.
pub struct Loan<'call, T: Value> {
    room: NonNull<T>,
    cx: &'call Context<'call>,
    slot: Slot,
    export: PhantomData<&'call mut T>,
}

impl<T: Value> Export<T> {
    /// Publishes a value measured now.
    pub fn write(&mut self, cx: &Context<'_>, value: T) {
        self.loan(cx).put(value).publish();
    }

    /// Publishes a value measured at `time` since the application's start.
    pub fn write_at(&mut self, cx: &Context<'_>, value: T, time: Duration) {
        self.loan(cx).put(value).publish_at(time);
    }

    /// Takes back the newest value, because it no longer tells how things are: a sensor is not heard any more, a place was lost.
    /// Until the next is published, whoever reads it gets none, and who is triggered by it looks again (R12).
    pub fn retract(&mut self, cx: &Context<'_>) {
        cx.retract(&self.slot);
    }

    /// Room to write the next value in place; for large ones.
    #[must_use]
    pub fn loan<'call>(&'call mut self, cx: &'call Context<'_>) -> Loan<'call, T> {
        // SAFETY: the port's type is `T`, by the contract of `new`.
        match unsafe { cx.loan::<T>(&self.slot) } {
            Some(room) => Loan {
                room,
                cx,
                slot: self.slot,
                export: PhantomData,
            },
            None => broken(self.slot.name, "loan", raw::UNBOUND),
        }
    }
}

impl<T: Value> Actuator<T> {
    /// Commands the driver bound here, until the command's validity ends or the next one comes.
    pub fn command(&self, cx: &Context<'_>, value: T) -> Outcome {
        // SAFETY: the port's type is `T`, by the contract of `new`.
        unsafe { cx.write(&self.slot, value) }
    }
}

impl<T: Modulated> Modulates<T> {
    /// Writes the child's modulation; it counts from the child's next check or iteration.
    pub fn set(&self, cx: &Context<'_>, value: T) -> Outcome {
        // SAFETY: the port's type is that of what stands for a `T`, by the contract of `new`.
        unsafe { cx.write(&self.slot, wire(value)) }
    }
}

impl<T: Value> Loan<'_, T> {
    /// Publishes it as measured now.
    pub fn publish(self) {
        self.finish(None);
    }

    /// Publishes it as measured at `time` since the application's start.
    pub fn publish_at(self, time: Duration) {
        self.finish(Some(time));
    }

    fn put(mut self, value: T) -> Self {
        *self = value;
        self
    }

    fn finish(self, time: Option<Duration>) {
        match self.cx.publish(&self.slot, time) {
            Outcome::Accepted => {}
            Outcome::Refused => broken(self.slot.name, "publish", raw::REFUSED),
            Outcome::NotFinite => broken(self.slot.name, "publish", raw::NOT_FINITE),
            Outcome::OutOfRange => broken(self.slot.name, "publish", raw::OUT_OF_RANGE),
            Outcome::Unbound => broken(self.slot.name, "publish", raw::UNBOUND),
        }
    }
}

impl<T: Value> Deref for Loan<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        // SAFETY: room for a `T`, of which every pattern of bytes is valid; nobody else's while the loan lives, because it
        // borrows its export.
        unsafe { self.room.as_ref() }
    }
}

impl<T: Value> DerefMut for Loan<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        // SAFETY: as above.
        unsafe { self.room.as_mut() }
    }
}

impl Outcome {
    /// Whether it was done.
    #[must_use]
    pub fn accepted(self) -> bool {
        self == Self::Accepted
    }

    /// What the host's code means; `None` for one that breaks the contract of the ABI.
    pub(crate) fn of(code: i32) -> Option<Self> {
        match code {
            raw::OK => Some(Self::Accepted),
            raw::REFUSED => Some(Self::Refused),
            raw::NOT_FINITE => Some(Self::NotFinite),
            raw::OUT_OF_RANGE => Some(Self::OutOfRange),
            raw::UNBOUND => Some(Self::Unbound),
            _ => None,
        }
    }
}

macro_rules! derived {
    ($($port:ident),*) => { $(
        impl<T> $port<T> {
            /// For derived code alone.
            ///
            /// # Safety
            /// Of these ports, which are those of one type alone, that of this number is of this kind and type, and no other port value has the number.
            #[doc(hidden)]
            #[must_use]
            pub const unsafe fn new(ports: &'static [raw::Port], number: u32, name: &'static str) -> Self {
                Self { slot: Slot::new(ports, number, name), value_type: PhantomData }
            }
        }
    )* };
}
derived!(Export, Actuator, Modulates);
