//! The bench for schemas that are written in another language, whose values are bytes.

#![allow(unsafe_code)]

use core::time::Duration;

use jde_abi::raw;

use super::{Bench, Failure, Foreign};

impl Bench<Foreign> {
    /// Creates an instance of the type that `table` describes.
    ///
    /// # Errors
    /// If the creation fails.
    ///
    /// # Panics
    /// If the table is invalid.
    ///
    /// # Safety
    /// The table, all it points to, and its functions follow the rules of `raw`.
    pub unsafe fn foreign(table: &'static raw::Schema) -> Result<Self, Failure> {
        // SAFETY: the caller's.
        unsafe { Self::of(table, &[]) }
    }

    /// Publishes a value of an input, by the number of its port.
    ///
    /// # Errors
    /// Why every host refuses it.
    pub fn put_bytes(&mut self, port: usize, value: &[u8]) -> Result<(), String> {
        self.state.check_value(port, value)?;
        self.state.put(port, value);
        Ok(())
    }

    /// Removes the newest value of an input, by the number of its port.
    pub fn remove(&mut self, port: usize) {
        self.state.ports[port].newest = None;
    }

    /// Returns the newest value of an output, by the number of its port, and its time.
    #[must_use]
    pub fn written_bytes(&self, port: usize) -> Option<(Vec<u8>, Duration)> {
        let newest = self.state.ports[port].newest.as_ref();
        newest.map(|(bytes, time)| (bytes.as_slice().to_vec(), *time))
    }
}
