//! What may accompany a run, such as the link for tools, or a recording.

use std::sync::Arc;

use jde_app::Application;
use jde_host::{StartHook, StartHookError};
use jde_loader::Plugins;
use jde_records::event::Observer;
use jde_records::turn::OnTurn;

use super::recording_summary::RecordingSummary;

/// What is known of a run before it starts.
pub struct RunContext<'a> {
    /// The application.
    pub application: &'a Application,
    /// Whether it runs in virtual time.
    pub lockstep: bool,
    /// Seconds of application time per second of the machine.
    pub speed: f64,
}

/// Something that the user wants in addition to a run.
pub trait Extension {
    /// Prepares it. Returns `None` if this run has none.
    ///
    /// # Errors
    /// The run must not start.
    fn prepare(&self, context: &RunContext<'_>)
    -> Result<Option<Box<dyn PreparedExtension>>, StartHookError>;
}

/// An extension of one run.
pub trait PreparedExtension {
    /// Returns an observer of all events.
    fn observer(&self) -> Box<dyn Observer>;

    /// Returns the function to call with every turn, if it needs them.
    fn on_turn(&self) -> Option<OnTurn> {
        None
    }

    /// Whether time may stand still.
    fn may_stand_still(&self) -> bool {
        false
    }

    /// Returns the hook to call before any schema writes a variable.
    fn before_start(&self, plugins: &Arc<Plugins>) -> StartHook;

    /// Ends it. Returns the result of a recording.
    fn finish(&self) -> Option<RecordingSummary>;
}
