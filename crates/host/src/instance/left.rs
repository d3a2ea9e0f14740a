//! An instance whose call was given up and has returned after all: nobody is waiting for it any more.

use std::any::Any;
use std::ffi::c_void;
use std::panic::resume_unwind;
use std::sync::Arc;

use jde_core::Nanos;

use super::Desk;
use crate::build;

/// What is left of an instance when a call returns that was given up. To be ended on the thread of that call.
pub(crate) struct Left {
    pub(crate) number: usize,
    /// Since when the call ran.
    pub(crate) since: Nanos,
    build: build::Shared,
    this: *mut c_void,
    /// What the call looked at and wrote to stays until the instance is gone.
    _desk: Arc<Desk>,
}

// SAFETY: as for `Instance`, whose part it was; it is used once, by its owner.
unsafe impl Send for Left {}

impl Left {
    pub(super) fn new(
        number: usize,
        since: Nanos,
        build: &build::Shared,
        this: *mut c_void,
        desk: &Arc<Desk>,
    ) -> Self {
        Self {
            number,
            since,
            build: Arc::clone(build),
            this,
            _desk: Arc::clone(desk),
        }
    }

    /// Unwinds this thread to where it began. By unwinding, so that no caller can forget to ask whether it was given up and
    /// tell the rules of what is no longer there: its successor's iteration would end with its own.
    pub(super) fn leave(self) -> ! {
        resume_unwind(Box::new(self))
    }

    /// Out of what a thread was unwound with, if that is why.
    ///
    /// # Errors
    /// It is something else.
    pub(crate) fn of(payload: Box<dyn Any + Send>) -> Result<Self, Box<dyn Any + Send>> {
        payload.downcast().map(|left| *left)
    }

    /// Ends the instance.
    pub(crate) fn end(self) {
        if let (false, Some(destroy)) = (self.this.is_null(), self.build.table.destroy) {
            // SAFETY: `this` came from the create of this build's table and is given back once, since this owns it and goes with it.
            unsafe { destroy(self.this) };
        }
    }
}
