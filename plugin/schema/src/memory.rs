//! The memory of a schema, which a reload passes from one build of the schema to the next while the
//! application runs.
//!
//! A schema without [`Memory`] starts anew when it is reloaded. Its variables, its modulations and its state
//! in the hierarchy are kept in both cases.
//!
//! ```
//! use jde_schema::bench::Bench;
//! use jde_schema::prelude::*;
//!
//! /// Counts.
//! #[derive(Describe)]
//! #[schema(perceptive, period = "100ms")]
//! struct Counter {
//!     #[export]
//!     count: Export<u32>,
//!     counted: u32,
//! }
//!
//! impl Schema for Counter {
//!     fn iterate(&mut self, cx: &Context) -> Result {
//!         self.counted += 1;
//!         self.count.write(cx, self.counted);
//!         Ok(())
//!     }
//! }
//!
//! impl Memory for Counter {
//!     fn save(&self, _: &Context, saving: &mut Saving) {
//!         saving.put(&self.counted);
//!     }
//!
//!     fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
//!         self.counted = saved.take()?;
//!         Ok(())
//!     }
//! }
//!
//! let mut old = Bench::<Counter>::new();
//! old.iterate().unwrap();
//! let mut new = Bench::<Counter>::new();
//! new.restore(&old.save().unwrap()).unwrap();
//! new.iterate().unwrap();
//! assert_eq!(new.exported::<u32>("count"), Some(2));
//! ```

use jde_types::Value;

use crate::context::Context;
use crate::error::Result;
use crate::schema::Schema;

/// A schema that passes its memory to its next build.
pub trait Memory: Schema {
    /// The version of the format that [`save`](Self::save) writes. Increase it when the format changes.
    const VERSION: u32 = 1;

    /// Saves the memory for the next build, at most 16 MiB. Called between two iterations, or while the
    /// schema sleeps. It must change nothing: the host refuses whatever it writes.
    fn save(&self, cx: &Context, saving: &mut Saving);

    /// Restores what another build saved, in the order of saving. [`Saved::version`] returns the version of
    /// the format. Called after `awake`, if the schema is awake, and before the first check. The host refuses
    /// whatever it writes, as for `save`.
    ///
    /// # Errors
    /// Any reason why the schema cannot continue from that memory. The previous build then continues, and
    /// this one ends.
    fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result;
}

/// The memory that a schema saves for the next build: a series of values, each with its type.
#[derive(Debug)]
pub struct Saving {
    bytes: Vec<u8>,
}

/// The memory that another build saved, to be taken in the order of saving.
#[derive(Debug)]
pub struct Saved<'a> {
    version: u32,
    rest: &'a [u8],
}

/// The type name of a text entry.
const TEXT: &str = "a text";

impl Saving {
    pub(crate) fn new() -> Self {
        Self { bytes: Vec::new() }
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// Appends a value: a number, a standard type, or a type of your own.
    pub fn put<T: Value>(&mut self, value: &T) {
        self.entry(&one::<T>(), value.as_bytes());
    }

    /// Appends a slice of any length of values of one type.
    pub fn put_all<T: Value>(&mut self, values: &[T]) {
        let bytes: Vec<u8> = values.iter().flat_map(T::as_bytes).copied().collect();
        self.entry(&several::<T>(), &bytes);
    }

    /// Appends a text of any length.
    pub fn put_text(&mut self, text: &str) {
        self.entry(TEXT, text.as_bytes());
    }

    fn entry(&mut self, what: &str, bytes: &[u8]) {
        for part in [what.as_bytes(), bytes] {
            self.bytes.extend_from_slice(&(part.len() as u64).to_ne_bytes());
            self.bytes.extend_from_slice(part);
        }
    }
}

impl<'a> Saved<'a> {
    pub(crate) fn new(version: u32, bytes: &'a [u8]) -> Self {
        Self { version, rest: bytes }
    }

    /// Returns the [`Memory::VERSION`] of the build that saved it.
    #[must_use]
    pub fn version(&self) -> u32 {
        self.version
    }

    /// Takes the next value.
    ///
    /// # Errors
    /// If there is none, or its type is another one.
    pub fn take<T: Value>(&mut self) -> Result<T> {
        let expected = one::<T>();
        let bytes = self.entry(&expected)?;
        T::from_bytes(bytes).ok_or_else(|| other_size(&expected))
    }

    /// Takes the next slice of values.
    ///
    /// # Errors
    /// As [`Self::take`].
    pub fn take_all<T: Value>(&mut self) -> Result<Vec<T>> {
        let expected = several::<T>();
        let bytes = self.entry(&expected)?;
        let values = bytes.chunks(size_of::<T>()).map(T::from_bytes);
        values.collect::<Option<_>>().ok_or_else(|| other_size(&expected))
    }

    /// Takes the next text.
    ///
    /// # Errors
    /// As [`Self::take`].
    pub fn take_text(&mut self) -> Result<&'a str> {
        Ok(core::str::from_utf8(self.entry(TEXT)?)?)
    }

    fn entry(&mut self, expected: &str) -> Result<&'a [u8]> {
        let nothing = || format!("{expected} was to come, and nothing more was saved");
        let what = self.part().ok_or_else(nothing)?;
        let bytes = self.part().ok_or_else(nothing)?;
        if what != expected.as_bytes() {
            return Err(format!(
                "{expected} was to come, and {} was saved in version {}",
                String::from_utf8_lossy(what),
                self.version
            )
            .into());
        }
        Ok(bytes)
    }

    fn part(&mut self) -> Option<&'a [u8]> {
        let (length, rest) = self.rest.split_first_chunk()?;
        let length = usize::try_from(u64::from_ne_bytes(*length)).ok()?;
        let (part, rest) = rest.split_at_checked(length)?;
        self.rest = rest;
        Some(part)
    }
}

fn one<T: Value>() -> String {
    format!("a {}", T::describe().name)
}

fn several<T: Value>() -> String {
    format!("a row of {}", T::describe().name)
}

/// The error for a type that kept its name and changed its size.
fn other_size(expected: &str) -> crate::Error {
    format!("{expected} was to come, and one of another size was saved").into()
}
