//! Functions that read one table, array or text, and report its place if it is invalid.

use core::ffi::{CStr, c_char};
use std::collections::HashSet;

use super::Refusal;
use crate::table::{self, Table};

/// The largest number of types, ports, children or fields in one array: far above any real plugin, far below
/// a random number.
const MOST_ENTRIES: u32 = 4096;

/// A place in the tables, for messages.
pub(super) struct Place(String);

impl Place {
    pub(super) fn new(place: impl Into<String>) -> Self {
        Self(place.into())
    }

    pub(super) fn inner(&self, what: &str, name: &str) -> Self {
        Self(format!("{}, {what} `{name}`", self.0))
    }

    pub(super) fn wrong<T>(&self, wrong: impl Into<String>) -> Result<T, Refusal> {
        Err(Refusal::Table {
            place: self.0.clone(),
            wrong: wrong.into(),
        })
    }

    /// Reads a table that begins with its size, in the layout of this ABI.
    pub(super) unsafe fn table<T: Table>(&self, table: *const T) -> Result<T, Refusal> {
        // SAFETY: the caller's.
        unsafe { table::read(table) }.or_else(|unreadable| self.wrong(unreadable.to_string()))
    }

    /// Reads an array of tables that begin with their size, which is also their stride, in the layout of this
    /// ABI.
    pub(super) unsafe fn array<T: Table>(
        &self,
        what: &str,
        first: *const T,
        count: u32,
    ) -> Result<Vec<T>, Refusal> {
        if count == 0 {
            return Ok(Vec::new());
        }
        if count > MOST_ENTRIES {
            return self.wrong(format!("{count} {what}; at most {MOST_ENTRIES} are believed"));
        }
        if first.is_null() || !first.is_aligned() {
            return self.wrong(format!("the pointer to its {what} is null or not aligned"));
        }
        // SAFETY: `first` points to `count` tables that begin with their size.
        unsafe {
            let stride = first.cast::<u32>().read() as usize;
            if stride >= T::LEAST && !stride.is_multiple_of(align_of::<T>()) {
                return self.wrong(format!(
                    "{what} say they have {stride} bytes each, which breaks their alignment"
                ));
            }
            (0..count as usize)
                .map(|index| self.table(first.byte_add(index * stride)))
                .collect()
        }
    }

    pub(super) unsafe fn text(&self, what: &str, text: *const c_char) -> Result<String, Refusal> {
        if text.is_null() {
            return Ok(String::new());
        }
        // SAFETY: texts end with a NUL.
        let Ok(text) = unsafe { CStr::from_ptr(text) }.to_str() else {
            return self.wrong(format!("{what} is not UTF-8"));
        };
        Ok(text.to_owned())
    }

    pub(super) unsafe fn name(&self, what: &str, text: *const c_char) -> Result<String, Refusal> {
        // SAFETY: the caller's.
        let name = unsafe { self.text(what, text)? };
        let legal = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || !name.chars().all(legal) || name.len() > 64 {
            return self.wrong(format!(
                "{what} is `{name}`; use 1 to 64 letters, digits, `_` and `-`"
            ));
        }
        Ok(name)
    }

    pub(super) fn distinct(&self, what: &str, names: impl Iterator<Item = String>) -> Result<(), Refusal> {
        let mut seen = HashSet::new();
        for name in names {
            if seen.contains(&name) {
                return self.wrong(format!("two {what} are called `{name}`"));
            }
            seen.insert(name);
        }
        Ok(())
    }
}
