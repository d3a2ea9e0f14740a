//! Replacement of a running schema's build by another one, between two iterations (R10), and the return to
//! the previous build.
//!
//! Whether a build fits is checked before anything changes ([`crate::OperatorHandle::replace`]). The runner
//! carries out the exchange, in a turn of the schema. The hierarchy is not involved: the schema keeps its
//! state, its authority and its variables.

mod registry;
mod reloader;

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use jde_core::Nanos;
use jde_loader::build;
use jde_records::reload::Replacement;
use parking_lot::{Condvar, Mutex};

pub(crate) use registry::BuildRegistry;
pub use reloader::{ReloadError, Reloader};

/// The default trial time of a new build, ns. Most mistakes show within seconds; a later failure is an
/// ordinary fault.
pub const PROBATION: Nanos = 3_000_000_000;
/// The least number of turns that a trial lasts, so that slow schemas can fail in it too.
pub(crate) const MIN_TRIAL_TURNS: u32 = 10;

/// How a build takes over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReloadOptions {
    /// How long the build is on trial, ns of application time, but at least ten turns. A fault during the
    /// trial returns to the previous build, which stays asleep until then. 0 for no trial.
    pub probation: Nanos,
    /// Starts without the memory of the previous build.
    pub fresh: bool,
}

/// A build that takes over at the schema's next turn. Dropping this value changes nothing.
pub struct PendingReload {
    completion: Arc<Completion>,
}

/// The exchange, for the runner.
pub(crate) struct Swap {
    pub(crate) build: build::SharedBuild,
    pub(crate) options: ReloadOptions,
    pub(crate) notes: Vec<String>,
    pub(crate) completion: Arc<Completion>,
}

/// Holds the outcome of a reload.
#[derive(Default)]
pub(crate) struct Completion {
    outcome: Mutex<Option<Result<Replacement, String>>>,
    completed: Condvar,
}

impl Default for ReloadOptions {
    fn default() -> Self {
        Self {
            probation: PROBATION,
            fresh: false,
        }
    }
}

impl PendingReload {
    pub(crate) fn new(completion: &Arc<Completion>) -> Self {
        Self {
            completion: Arc::clone(completion),
        }
    }

    /// Returns the outcome, once it is known: the build took over and completed its first turn, or the reason
    /// why the previous build continues.
    #[must_use]
    pub fn outcome(&self) -> Option<Result<Replacement, String>> {
        self.completion.outcome.lock().clone()
    }

    /// Waits for the outcome, at most for `within`. In lockstep, do not call this on the thread that runs the
    /// application.
    #[must_use]
    pub fn wait(&self, within: Duration) -> Option<Result<Replacement, String>> {
        let mut outcome = self.completion.outcome.lock();
        self.completion
            .completed
            .wait_while_for(&mut outcome, |outcome| outcome.is_none(), within);
        outcome.clone()
    }
}

impl Completion {
    /// Sets the outcome; only the first call has an effect.
    pub(crate) fn complete(&self, outcome: Result<Replacement, String>) {
        self.outcome.lock().get_or_insert(outcome);
        self.completed.notify_all();
    }
}

impl fmt::Debug for Swap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Swap")
            .field("build", &self.build.name)
            .finish_non_exhaustive()
    }
}
