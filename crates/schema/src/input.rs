//! What a schema reads: imports, modulations, commands. Within a check and the iteration that follows it each keeps one value.

#![allow(unsafe_code)]

use core::marker::PhantomData;
use core::ops::Deref;
use core::time::Duration;

use jde_abi::raw;
use jde_types::{Modulated, Value};

use crate::context::{Context, broken};
use crate::error::Result;
use crate::slot::Slot;

/// A variable of another schema, read by this one.
#[derive(Debug)]
pub struct Import<T> {
    slot: Slot,
    value_type: PhantomData<fn() -> T>,
}

/// An input that the father or an operator writes while the schema runs; it always has a value.
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

/// A value as a port shows it, with its time, number and writer; it stays as it is until the present call returns.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'call, T> {
    value: &'call T,
    time: Duration,
    sequence: u64,
    writer: u32,
    flags: u32,
}

impl<T: Value> Import<T> {
    /// The newest value; `None` if none has been published yet, if its writer has taken it back since because it no longer tells
    /// how things are (a device is not heard), or if the application left an optional import unbound.
    #[must_use]
    pub fn get<'call>(&self, cx: &'call Context<'_>) -> Option<Sample<'call, T>> {
        cx.read(&self.slot).unwrap_or_default()
    }

    /// The newest value.
    ///
    /// # Errors
    /// If there is none, in words that name this import.
    pub fn require<'call>(&self, cx: &'call Context<'_>) -> Result<Sample<'call, T>> {
        let name = self.slot.name;
        match cx.read(&self.slot) {
            Ok(Some(sample)) => Ok(sample),
            Ok(None) => Err(format!("import `{name}` has no value").into()),
            Err(_) => {
                Err(format!("import `{name}` is not bound; the application gives it under `imports`").into())
            }
        }
    }

    /// Whether the application bound it.
    #[must_use]
    pub fn is_bound(&self, cx: &Context<'_>) -> bool {
        cx.read::<T>(&self.slot).is_ok()
    }
}

impl<T: Modulated> Modulation<T> {
    /// Its value.
    #[must_use]
    pub fn get(&self, cx: &Context<'_>) -> T {
        match T::of(&self.sample(cx)) {
            Some(value) => value,
            None => panic!("`{}` is none of its {} choices", self.slot.name, T::CHOICES.len()),
        }
    }

    /// Its value in place, with its stamp; for large values. A `bool` is a `Flag` there, and one of several its number.
    #[must_use]
    pub fn sample<'call>(&self, cx: &'call Context<'_>) -> Sample<'call, T::Wire> {
        match cx.read(&self.slot) {
            Ok(Some(sample)) => sample,
            Ok(None) | Err(_) => broken(self.slot.name, "read", raw::NO_VALUE),
        }
    }
}

impl<T> Modulation<T> {
    /// Its number in a call of the type whose ports begin there.
    pub(crate) fn number(&self, ports: *const raw::Port) -> u32 {
        self.slot.number(ports)
    }
}

impl<T: Value> Command<T> {
    /// The command in force; the neutral value when there is none.
    #[must_use]
    pub fn get<'call>(&self, cx: &'call Context<'_>) -> Sample<'call, T> {
        match cx.read(&self.slot) {
            Ok(Some(sample)) => sample,
            Ok(None) | Err(_) => broken(self.slot.name, "read", raw::NO_VALUE),
        }
    }
}

impl<'call, T> Sample<'call, T> {
    pub(crate) fn new(value: &'call T, sample: &raw::Sample) -> Self {
        Self {
            value,
            time: Duration::from_nanos(sample.time_ns),
            sequence: sample.sequence,
            writer: sample.writer,
            flags: sample.flags,
        }
    }

    /// The value, for as long as the present call.
    #[must_use]
    pub fn value(&self) -> &'call T {
        self.value
    }

    /// When it was measured or written, since the application's start.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.time
    }

    /// How long ago that was.
    #[must_use]
    pub fn age(&self, cx: &Context<'_>) -> Duration {
        cx.now().saturating_sub(self.time)
    }

    /// Counts the values of this variable from 1; 0 for one that nobody has written.
    #[must_use]
    pub fn sequence(&self) -> u64 {
        self.sequence
    }

    /// Who wrote it: the number of an instance in this application.
    #[must_use]
    pub fn writer(&self) -> u32 {
        self.writer
    }

    /// Whether a command is in force; else the value is the neutral one.
    #[must_use]
    pub fn in_force(&self) -> bool {
        self.flags & raw::SAMPLE_NEUTRAL == 0
    }

    /// Whether nobody has written this modulation; the value is its default.
    #[must_use]
    pub fn is_default(&self) -> bool {
        self.flags & raw::SAMPLE_DEFAULT != 0
    }
}

impl<T> Deref for Sample<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.value
    }
}

macro_rules! derived {
    ($($port:ident),*) => { $(
        impl<T> $port<T> {
            /// For derived code alone.
            ///
            /// # Safety
            /// Of these ports, which are those of one type alone, that of this number is of this kind and type.
            #[doc(hidden)]
            #[must_use]
            pub const unsafe fn new(ports: &'static [raw::Port], number: u32, name: &'static str) -> Self {
                Self { slot: Slot::new(ports, number, name), value_type: PhantomData }
            }
        }
    )* };
}
derived!(Import, Modulation, Command);
