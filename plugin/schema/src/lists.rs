//! Lists of ports: a table of the application file whose entries are imports, exports or commands of any type, each with
//! settings. A type with lists handles values by their descriptions, as bytes.
//!
//! ```
//! use jde_schema::bench::{Bench, Entry};
//! use jde_schema::prelude::*;
//!
//! /// How a value is counted.
//! #[derive(Clone, Copy, Default, Value)]
//! #[repr(C)]
//! #[value(name = "my_msgs/msg/Weight")]
//! struct Weight {
//!     /// What a new value counts.
//!     weight: f64,
//! }
//!
//! /// Counts new values of any variables: `count."the laser" = { from = "robot.laser", weight = 2 }`.
//! #[derive(Describe)]
//! #[schema(perceptive, period = "10ms")]
//! struct Counter {
//!     /// The variables to count.
//!     #[imports(default = Weight { weight: 1.0 })]
//!     count: Imports<Weight>,
//!     /// The sum.
//!     #[export]
//!     sum: Export<f64>,
//! }
//!
//! impl Schema for Counter {
//!     fn iterate(&mut self, cx: &Context) -> Result {
//!         let sum = self.count.iter().filter(|import| import.get(cx).is_some()).map(|import| import.settings().weight).sum();
//!         self.sum.write(cx, sum);
//!         Ok(())
//!     }
//! }
//!
//! let laser = Entry::new::<LaserScan>("count", "the laser").settings(&Weight { weight: 2.0 });
//! let mut bench = Bench::<Counter>::with_lists(&[laser, Entry::new::<f64>("count", "speed")]);
//! let ranges = Seq::from_slice(&[1.0]).unwrap();
//! bench.import("the laser", &LaserScan { range_max: 8.0, ranges, ..LaserScan::default() });
//! bench.import("speed", &0.0);
//! bench.iterate().unwrap();
//! assert_eq!(bench.exported::<f64>("sum"), Some(3.0));
//! ```

#![allow(unsafe_code)]

use core::ffi::{CStr, c_char};
use core::fmt;
use core::ops::{Deref, DerefMut};
use core::time::Duration;
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_abi::{raw, read};
use jde_types::Value;

use crate::context::{Context, broken};
use crate::input::Sample;
use crate::inspect::Inspected;
use crate::slot::Slot;

/// A list of imports, whose entries the application states.
#[derive(Debug)]
pub struct Imports<S>(Vec<ListedImport<S>>);

/// A list of exports, whose entries the application states.
#[derive(Debug)]
pub struct Exports<S>(Vec<ListedExport<S>>);

/// A list of a driver's commands, whose entries the application states.
#[derive(Debug)]
pub struct Commands<S>(Vec<ListedCommand<S>>);

/// An import of a list.
#[derive(Debug)]
pub struct ListedImport<S>(Listed<S>);

/// An export of a list.
#[derive(Debug)]
pub struct ListedExport<S>(Listed<S>);

/// A command of a list. Its neutral value is all zeros, and a new command lets the driver iterate at once (R12).
#[derive(Debug)]
pub struct ListedCommand<S>(Listed<S>);

struct Listed<S> {
    slot: Slot,
    value_type: Arc<Type>,
    settings: S,
}

impl<S> ListedImport<S> {
    /// Returns the newest value, in the form of its type. `None` as for [`crate::Import::get`].
    #[must_use]
    pub fn get<'call>(&self, cx: &'call Context<'_>) -> Option<Sample<'call, [u8]>> {
        cx.read_bytes(&self.0.slot, self.0.value_type.bytes)
            .unwrap_or_default()
    }
}

impl<S> ListedCommand<S> {
    /// Returns the command in force, in the form of its type; `None` if there is none.
    #[must_use]
    pub fn get<'call>(&self, cx: &'call Context<'_>) -> Option<Sample<'call, [u8]>> {
        let newest = cx.read_bytes(&self.0.slot, self.0.value_type.bytes);
        newest.unwrap_or_default().filter(Sample::in_force)
    }
}

impl<S> ListedExport<S> {
    /// Publishes the value that `fill` writes, as measured at `time`, or now. `fill` gets the bytes of a value, which
    /// are those of an older one or zeros; if it fails, nothing is published.
    ///
    /// # Errors
    /// The error of `fill`.
    pub fn write_with<E>(
        &mut self,
        cx: &Context<'_>,
        time: Option<Duration>,
        fill: impl FnOnce(&mut [u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let Listed { slot, value_type, .. } = &self.0;
        let Some(mut room) = cx.loan_bytes(slot, value_type.bytes) else {
            broken(slot.name, "loan", raw::UNBOUND)
        };
        // SAFETY: room for a value of the type, to which no other reference exists until it is published.
        fill(unsafe { room.as_mut() })?;
        let _ = cx.publish(slot, time);
        Ok(())
    }

    /// Retracts the newest value, as [`crate::Export::retract`] does.
    pub fn retract(&mut self, cx: &Context<'_>) {
        cx.retract(&self.0.slot);
    }
}

impl<S: Value> Listed<S> {
    /// # Safety
    /// `ports` are those of the type, and `port` is one of its lists, whose settings are an `S`.
    unsafe fn of(ports: &'static [raw::Port], port: &raw::ListedPort) -> Self {
        // SAFETY: the host's tables, and what they point to, follow the rules of `raw` and live for ever.
        unsafe {
            let value_type = match read::value_type(port.value_type) {
                Ok(value_type) => Arc::new(value_type),
                Err(refusal) => panic!("the host gave a list a port that cannot be read: {refusal}"),
            };
            Self {
                slot: Slot::listed(ports, port.port, label(port.label)),
                value_type,
                settings: port.settings.cast::<S>().read(),
            }
        }
    }
}

/// # Safety
/// The text is null, or ends with a NUL and lives for ever.
unsafe fn label(text: *const c_char) -> &'static str {
    if text.is_null() {
        return "";
    }
    // SAFETY: the caller's.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap_or_default()
}

impl<S> fmt::Debug for Listed<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.slot, self.value_type.name)
    }
}

macro_rules! lists {
    ($($list:ident of $port:ident: $kind:ident;)*) => { $(
        impl<S> $port<S> {
            /// Returns the key of the entry in the application file.
            #[must_use]
            pub fn label(&self) -> &'static str {
                self.0.slot.name
            }

            /// Returns the type of its value.
            #[must_use]
            pub fn value_type(&self) -> &Arc<Type> {
                &self.0.value_type
            }

            /// Returns its settings.
            #[must_use]
            pub fn settings(&self) -> &S {
                &self.0.settings
            }
        }

        impl<S> Inspected for $port<S> {
            fn number(&self, ports: *const raw::Port) -> u32 {
                self.0.slot.number(ports)
            }
        }

        impl<S: Value> $list<S> {
            /// For generated code only: the kind of the ports.
            #[doc(hidden)]
            pub const KIND: u32 = raw::$kind;
            /// For generated code only: the type of the settings.
            #[doc(hidden)]
            pub const SETTINGS: *const raw::Type = S::TYPE;

            /// For generated code only.
            #[doc(hidden)]
            #[must_use]
            pub const fn new() -> Self {
                Self(Vec::new())
            }

            /// For generated code only.
            ///
            /// # Safety
            /// `ports` are those of the type, and the host gave `port` for this list.
            #[doc(hidden)]
            pub unsafe fn add(&mut self, ports: &'static [raw::Port], port: &raw::ListedPort) {
                // SAFETY: the caller's.
                self.0.push($port(unsafe { Listed::of(ports, port) }));
            }
        }

        impl<S> Deref for $list<S> {
            type Target = [$port<S>];

            fn deref(&self) -> &[$port<S>] {
                &self.0
            }
        }

        impl<S> DerefMut for $list<S> {
            fn deref_mut(&mut self) -> &mut [$port<S>] {
                &mut self.0
            }
        }
    )* };
}
lists! {
    Imports of ListedImport: IMPORT;
    Exports of ListedExport: EXPORT;
    Commands of ListedCommand: COMMAND;
}
