//! An instance whose call was given up and has returned after all: nobody is waiting for it any more.

use std::any::Any;
use std::panic::resume_unwind;
use std::sync::Arc;

use jde_core::Nanos;

use super::Desk;
use super::body::Body;

/// What is left of an instance when a call returns that was given up. To be ended on the thread of that call.
pub(crate) struct Left {
    pub(crate) number: usize,
    /// Since when the call ran.
    pub(crate) since: Nanos,
    body: Option<Body>,
    /// What the call looked at and wrote to stays until the instance is gone.
    _desk: Arc<Desk>,
}

impl Left {
    pub(super) fn new(number: usize, since: Nanos, body: Option<Body>, desk: &Arc<Desk>) -> Self {
        Self {
            number,
            since,
            body,
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
        drop(self.body);
    }
}
