//! An instance whose call was given up and has returned later. Nothing waits for it any more.

use std::any::Any;
use std::panic::resume_unwind;
use std::sync::Arc;

use jde_core::{Nanos, SchemaId};

use super::PortAccess;
use super::body::Body;

/// The rest of an instance whose call was given up and has returned. It must be ended on the thread of that
/// call.
pub(crate) struct AbandonedInstance {
    /// The schema that answers for the call: its own, or a guard.
    pub(crate) number: SchemaId,
    /// Since when the call ran.
    pub(crate) since: Nanos,
    body: Option<Body>,
    /// The values that the call read and the memory that it wrote to stay until the instance is gone.
    _port_access: Arc<PortAccess>,
}

impl AbandonedInstance {
    pub(super) fn new(
        number: SchemaId,
        since: Nanos,
        body: Option<Body>,
        port_access: &Arc<PortAccess>,
    ) -> Self {
        Self {
            number: port_access.answering_guard().unwrap_or(number),
            since,
            body,
            _port_access: Arc::clone(port_access),
        }
    }

    /// Unwinds this thread to its start. With an unwind no caller can forget to check whether the call was
    /// given up, and report to the rules for an instance that is gone: the report would end its successor's
    /// iteration.
    pub(super) fn unwind(self) -> ! {
        resume_unwind(Box::new(self))
    }

    /// Extracts it from the payload of an unwind.
    ///
    /// # Errors
    /// Returns the payload if the unwind had another cause.
    pub(crate) fn from_payload(payload: Box<dyn Any + Send>) -> Result<Self, Box<dyn Any + Send>> {
        payload.downcast().map(|instance| *instance)
    }

    /// Ends the instance.
    pub(crate) fn end(self) {
        drop(self.body);
    }
}
