//! The inputs of a schema: imports, modulations and commands. Within a check and the iteration that follows
//! it, each input keeps one value (R8).

#![allow(unsafe_code)]

use core::marker::PhantomData;
use core::ops::Deref;
use core::time::Duration;

use jde_abi::raw;
use jde_types::{Modulated, Value};

use crate::context::{Context, broken};
use crate::error::{NoValue, Result};
use crate::inspect::Inspected;
use crate::slot::Slot;

/// A variable of another schema that this schema reads.
#[derive(Debug)]
pub struct Import<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// An input that the father or an operator may change while the schema runs. It always has a value.
#[derive(Debug)]
pub struct Modulation<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// An input of a driver that reaches an actuator.
#[derive(Debug)]
pub struct Command<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// A value of an input with its time, sequence number and writer. It does not change until the present call
/// returns.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'call, T: ?Sized> {
    value: &'call T,
    time: Duration,
    sequence: u64,
    writer: u32,
    flags: u32,
}

impl<T: Value> Import<T> {
    /// Returns the newest value.
    ///
    /// `None` if no value has been published yet, if the writer has retracted it because it is no longer
    /// valid (a device does not respond), or if the application left an optional import unbound.
    #[must_use]
    pub fn get<'call>(&self, cx: &'call Context<'_>) -> Option<Sample<'call, T>> {
        cx.read(&self.slot).unwrap_or_default()
    }

    /// Returns the newest value.
    ///
    /// # Errors
    /// [`NoValue`] if there is none: an iteration that returns it ends there, without a fault (R19). Another error
    /// that names this import if the application did not bind it.
    pub fn require<'call>(&self, cx: &'call Context<'_>) -> Result<Sample<'call, T>> {
        let name = self.slot.name;
        match cx.read(&self.slot) {
            Ok(Some(sample)) => Ok(sample),
            Ok(None) => Err(NoValue { import: name }.into()),
            Err(_) => {
                Err(format!("import `{name}` is not bound; the application gives it under `imports`").into())
            }
        }
    }

    /// Returns whether the application bound this import.
    #[must_use]
    pub fn is_bound(&self, cx: &Context<'_>) -> bool {
        cx.read::<T>(&self.slot).is_ok()
    }
}

impl<T: Modulated> Modulation<T> {
    /// Returns the value.
    #[must_use]
    pub fn get(&self, cx: &Context<'_>) -> T {
        match T::of(&self.sample(cx)) {
            Some(value) => value,
            None => panic!("`{}` is none of its {} choices", self.slot.name, T::CHOICES.len()),
        }
    }

    /// Returns the value in place, with its stamp; for large values. It has the wire type: a `bool` is a
    /// `Flag`, and a `Choice` is its number.
    #[must_use]
    pub fn sample<'call>(&self, cx: &'call Context<'_>) -> Sample<'call, T::Wire> {
        match cx.read(&self.slot) {
            Ok(Some(sample)) => sample,
            Ok(None) | Err(_) => broken(self.slot.name, "read", raw::NO_VALUE),
        }
    }
}

impl<T> Inspected for Modulation<T> {
    fn number(&self, ports: *const raw::Port) -> u32 {
        self.slot.number(ports)
    }
}

impl<T: Value> Command<T> {
    /// Returns the command in force, or the neutral value if there is none.
    #[must_use]
    pub fn get<'call>(&self, cx: &'call Context<'_>) -> Sample<'call, T> {
        match cx.read(&self.slot) {
            Ok(Some(sample)) => sample,
            Ok(None) | Err(_) => broken(self.slot.name, "read", raw::NO_VALUE),
        }
    }
}

impl<'call, T: ?Sized> Sample<'call, T> {
    pub(crate) fn new(value: &'call T, sample: &raw::Sample) -> Self {
        Self {
            value,
            time: Duration::from_nanos(sample.time_ns),
            sequence: sample.sequence,
            writer: sample.writer,
            flags: sample.flags,
        }
    }

    /// Returns the value. The reference is valid until the present call returns.
    #[must_use]
    pub fn value(&self) -> &'call T {
        self.value
    }

    /// Returns the time of measurement or writing, since the application's start.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.time
    }

    /// Returns the time since [`time`](Self::time).
    #[must_use]
    pub fn age(&self, cx: &Context<'_>) -> Duration {
        cx.now().saturating_sub(self.time)
    }

    /// Returns the sequence number of the value, from 1. It is 0 if the variable was never written.
    #[must_use]
    pub fn sequence(&self) -> u64 {
        self.sequence
    }

    /// Returns the writer: the number of an instance in this application.
    #[must_use]
    pub fn writer(&self) -> u32 {
        self.writer
    }

    /// Returns whether a command is in force. If not, the value is the neutral one.
    #[must_use]
    pub fn in_force(&self) -> bool {
        self.flags & raw::SAMPLE_NEUTRAL == 0
    }

    /// Returns whether this modulation was never written. Its value is then that of the application file, or the default.
    #[must_use]
    pub fn is_default(&self) -> bool {
        self.flags & raw::SAMPLE_DEFAULT != 0
    }
}

impl<T: ?Sized> Deref for Sample<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.value
    }
}

macro_rules! derived {
    ($($port:ident),*) => { $(
        impl<T> $port<T> {
            /// For generated code only.
            ///
            /// # Safety
            /// `ports` are those of one type alone, and port `number` of them has this kind and type.
            #[doc(hidden)]
            #[must_use]
            pub const unsafe fn new(ports: &'static [raw::Port], number: u32, name: &'static str) -> Self {
                Self { slot: Slot::new(ports, number, name), value_type: PhantomData }
            }
        }
    )* };
}
derived!(Import, Modulation, Command);
