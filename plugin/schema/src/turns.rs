//! Turns in addition to the periodic ones: a schema whose own thread has received something need not wait for its period.

#![allow(unsafe_code)]

use core::ffi::{CStr, c_void};
use core::fmt;
use core::ptr::NonNull;

use jde_abi::raw;

use crate::context::Context;

/// The id of the extension as a C text.
const ID: &CStr = c"jde.turns";

/// Requests turns of an instance from any thread (R12). Dropping it frees the host's handle.
pub struct TurnRequester {
    turns: &'static raw::Turns,
    handle: NonNull<c_void>,
}

// SAFETY: the host's functions may be called from any thread.
unsafe impl Send for TurnRequester {}
// SAFETY: as above, and `request` takes the handle as constant.
unsafe impl Sync for TurnRequester {}

impl Context<'_> {
    /// Returns what requests turns of this instance from its own threads. `None` in lockstep, at another speed than real
    /// time, in a replay, in a process of its own, and in a bench: there the instance has only its period.
    #[must_use]
    pub fn turn_requester(&self) -> Option<TurnRequester> {
        // SAFETY: the context is that of the present call, and the id ends with a NUL. A table of that id is a `Turns` that
        // lives until the process ends.
        let turns = unsafe {
            let table = (self.host.extension)(self.raw.as_ptr(), ID.as_ptr());
            table.cast::<raw::Turns>().as_ref()?
        };
        if (turns.size as usize) < size_of::<raw::Turns>() {
            return None;
        }
        // SAFETY: the context is that of the present call.
        let handle = unsafe { (turns.open)(self.raw.as_ptr()) };
        NonNull::new(handle).map(|handle| TurnRequester { turns, handle })
    }
}

impl TurnRequester {
    /// Requests a turn without waiting for the period, if the instance is awake: it checks, and iterates if it may. Several
    /// requests before that turn are one. Does not block. Has no effect after the end of the application; after that of the
    /// instance, its successor takes the turn.
    pub fn request(&self) {
        // SAFETY: the handle is open.
        unsafe { (self.turns.request)(self.handle.as_ptr()) }
    }
}

impl Drop for TurnRequester {
    fn drop(&mut self) {
        // SAFETY: the handle is open, and this closes it once.
        unsafe { (self.turns.close)(self.handle.as_ptr()) }
    }
}

impl fmt::Debug for TurnRequester {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TurnRequester").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_id_is_that_of_the_extension() {
        assert_eq!(super::ID.to_bytes(), jde_abi::raw::EXTENSION_TURNS.as_bytes());
    }
}
