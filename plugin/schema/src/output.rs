//! The outputs of a schema: exports, actuators and modulations of its children.

#![allow(unsafe_code)]

use core::marker::PhantomData;
use core::ops::{Deref, DerefMut};
use core::ptr::NonNull;
use core::time::Duration;

use jde_abi::raw;
use jde_types::{Modulated, Value, wire};

use crate::context::{Context, broken};
use crate::inspect::Inspected;
use crate::slot::Slot;

/// A variable that this schema writes and any other may read.
#[derive(Debug)]
pub struct Export<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// A port through which this motor schema commands a driver.
#[derive(Debug)]
pub struct Actuator<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// A port through which this schema writes a modulation of a child.
#[derive(Debug)]
pub struct Modulates<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// The result of a request to the host. No outcome is a fault: the host counts and shows what it refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The request was granted.
    Accepted,
    /// The schema has no authority at this instant (R7), or an operator holds the child.
    Refused,
    /// The value holds a NaN or an infinity where a finite number is required.
    NotFinite,
    /// The number is outside the limits of the child's modulation.
    OutOfRange,
    /// The application left this optional port or child unbound.
    Unbound,
}

/// A buffer for the next value of an export, to be written in place. Dropping it publishes nothing.
///
/// It contains the bytes of an older value, or none: write all of it.
pub struct Loan<'call, T: Value> {
    value: NonNull<T>,
    cx: &'call Context<'call>,
    slot: Slot,
    export: PhantomData<&'call mut T>,
}

impl<T> Inspected for Export<T> {
    fn number(&self, ports: *const raw::Port) -> u32 {
        self.slot.number(ports)
    }
}

impl<T: Value> Export<T> {
    /// Publishes a value as measured now.
    pub fn write(&mut self, cx: &Context<'_>, value: T) {
        self.loan(cx).put(value).publish();
    }

    /// Publishes a value as measured at `time` since the application's start.
    pub fn write_at(&mut self, cx: &Context<'_>, value: T, time: Duration) {
        self.loan(cx).put(value).publish_at(time);
    }

    /// Retracts the newest value because it is no longer valid: a sensor does not respond, a position was
    /// lost. Until the next value is published, readers get none. Schemas with a trigger on it check again
    /// (R12).
    pub fn retract(&mut self, cx: &Context<'_>) {
        cx.retract(&self.slot);
    }

    /// Returns a buffer to write the next value in place; for large values.
    #[must_use]
    pub fn loan<'call>(&'call mut self, cx: &'call Context<'_>) -> Loan<'call, T> {
        // SAFETY: the port's type is `T`, by the contract of `new`.
        match unsafe { cx.loan::<T>(&self.slot) } {
            Some(room) => Loan {
                value: room,
                cx,
                slot: self.slot,
                export: PhantomData,
            },
            None => broken(self.slot.name, "loan", raw::UNBOUND),
        }
    }
}

impl<T: Value> Actuator<T> {
    /// Commands the bound driver. The command is in force until its validity ends or the next command
    /// arrives.
    pub fn command(&self, cx: &Context<'_>, value: T) -> Outcome {
        // SAFETY: the port's type is `T`, by the contract of `new`.
        unsafe { cx.write(&self.slot, value) }
    }
}

impl<T: Modulated> Modulates<T> {
    /// Writes the child's modulation. It takes effect at the child's next check or iteration.
    pub fn set(&self, cx: &Context<'_>, value: T) -> Outcome {
        // SAFETY: the port's type is that of what stands for a `T`, by the contract of `new`.
        unsafe { cx.write(&self.slot, wire(value)) }
    }
}

impl<T: Value> Loan<'_, T> {
    /// Publishes the value as measured now.
    pub fn publish(self) {
        self.finish(None);
    }

    /// Publishes the value as measured at `time` since the application's start.
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
        // SAFETY: room for a `T`, of which every pattern of bytes is valid. No other reference to it exists
        // while the loan lives, because the loan borrows its export.
        unsafe { self.value.as_ref() }
    }
}

impl<T: Value> DerefMut for Loan<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        // SAFETY: as above.
        unsafe { self.value.as_mut() }
    }
}

impl Outcome {
    /// Returns whether the request was granted.
    #[must_use]
    pub fn accepted(self) -> bool {
        self == Self::Accepted
    }

    /// Converts the host's code. `None` for a code that breaks the contract of the ABI.
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
            /// For generated code only.
            ///
            /// # Safety
            /// `ports` are those of one type alone, port `number` of them has this kind and type, and no
            /// other port value has that number.
            #[doc(hidden)]
            #[must_use]
            pub const unsafe fn new(ports: &'static [raw::Port], number: u32, name: &'static str) -> Self {
                Self { slot: Slot::new(ports, number, name), value_type: PhantomData }
            }
        }
    )* };
}
derived!(Export, Actuator, Modulates);
