//! The data that the oscilloscope shows in a frame, and its requests. The types do not depend on a session.

use jde_link::message::{Action, Schemas};
use jde_records::snapshot::Snapshot;
use jde_timeline::Timeline;

/// The data to show.
pub(super) struct Input<'a> {
    /// The states of all schemas and groups.
    pub(super) snapshot: &'a Snapshot,
    /// The declarations of the schemas and groups.
    pub(super) schemas: &'a Schemas,
    /// What happened until then; in a recording whose file is read, from its beginning to its end.
    pub(super) timeline: &'a Timeline,
    /// The time until which the timeline goes, s.
    pub(super) end_s: f64,
    /// From when until when nothing was recorded, s.
    pub(super) gaps: &'a [(f64, f64)],
    /// Whether it is a recording, which can go on from any time.
    pub(super) is_recording: bool,
    /// Whether the application accepts requests.
    pub(super) accepts_requests: bool,
}

/// A request of the user.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Request {
    /// An operator's action.
    Act(Action),
    /// The panel of a schema.
    Panel(String),
    /// A recording goes on from a switch at this time, s.
    Seek(f64),
}

impl Input<'_> {
    /// The time of the snapshot, in s since the application's start.
    pub(super) fn now(&self) -> f64 {
        self.snapshot.time as f64 / 1e9
    }
}
