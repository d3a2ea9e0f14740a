//! What the oscilloscope looks at in a frame, and what it asks for. Nothing here knows where either comes from or goes to.

use jde_host::snapshot::Snapshot;
use jde_link::message::{Action, Schemas};

use crate::session::History;

/// What is looked at.
pub(super) struct Input<'a> {
    /// What every schema and group is doing.
    pub(super) snapshot: &'a Snapshot,
    /// What they were declared to be.
    pub(super) schemas: &'a Schemas,
    /// What happened before.
    pub(super) past: &'a History,
    /// Somebody is there to be asked for something.
    pub(super) answers: bool,
}

/// What a person wants.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Request {
    /// Something of the application, as its operator.
    Act(Action),
    /// The panel of a schema.
    Panel(String),
}

impl Input<'_> {
    /// s since the application's start.
    pub(super) fn now(&self) -> f64 {
        self.snapshot.time as f64 / 1e9
    }
}
