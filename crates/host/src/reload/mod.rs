//! Replacement of a running schema's build by another one, between two iterations (R10), and the return to
//! the build before.
//!
//! Whether a build fits is checked before anything changes ([`crate::OperatorHandle::replace`]). The runner
//! carries out the exchange, in a turn of the schema. The hierarchy is not involved: the schema keeps its
//! state, its authority and its variables.

mod reloader;

use std::fmt;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use jde_core::Nanos;
use serde::{Deserialize, Serialize};

use crate::build::{self, BuildName};
pub use reloader::{ReloadError, ReloadOutcome, ReloadReport, Reloader};

/// The default trial time of a new build, ns. Most mistakes show within seconds; a later failure is an
/// ordinary fault.
pub const PROBATION: Nanos = 3_000_000_000;
/// The fewest turns that a trial lasts, so that slow schemas have had a chance to fail.
pub(crate) const MIN_TRIAL_TURNS: u32 = 10;

/// How a build takes over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReloadOptions {
    /// How long the build is on trial, ns of application time, but at least ten turns. A fault during the
    /// trial returns to the build before, which stays asleep until then. 0 for no trial.
    pub probation: Nanos,
    /// Starts without the memory of the build before.
    pub fresh: bool,
}

/// How a build took over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Replacement {
    /// The build.
    pub build: BuildName,
    /// The memory taken over from the build before; `None` if the build started without it.
    pub carried: Option<CarriedMemory>,
    /// From the end of the last turn of the build before to the first check of this one, ns of application
    /// time: the schema could not react meanwhile. `None` if it sleeps.
    pub gap: Option<Nanos>,
    /// How long the exchange took, ns of machine time.
    pub took: Nanos,
    /// How long the build is on trial, ns of application time.
    pub probation: Nanos,
    /// Parts of the build that take effect only when the application is restarted.
    pub notes: Vec<String>,
}

/// The memory that one build took over from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CarriedMemory {
    /// The version of its format.
    pub version: u32,
    /// Its size in bytes.
    pub bytes: usize,
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
    pub(crate) fn new(order: &Arc<Completion>) -> Self {
        Self {
            completion: Arc::clone(order),
        }
    }

    /// Returns the outcome, once it is known: the build took over and completed its first turn, or the reason
    /// why the build before continues.
    #[must_use]
    pub fn outcome(&self) -> Option<Result<Replacement, String>> {
        self.completion.lock().clone()
    }

    /// Waits for the outcome, at most for `within`. In lockstep, do not call this on the thread that runs the
    /// application.
    #[must_use]
    pub fn wait(&self, within: Duration) -> Option<Result<Replacement, String>> {
        let outcome = self.completion.lock();
        let (outcome, _) = self
            .completion
            .completed
            .wait_timeout_while(outcome, within, |outcome| outcome.is_none())
            .unwrap_or_else(PoisonError::into_inner);
        outcome.clone()
    }
}

impl Replacement {
    /// Returns the takeover in words: "runs 0.2.0 from libvff.so; 12 bytes of memory carried over (version
    /// 1); gap 31.2 ms".
    #[must_use]
    pub fn summary(&self) -> String {
        let carried = self
            .carried
            .map_or_else(|| "begins anew".to_owned(), |carried| carried.to_string());
        let gap = self
            .gap
            .map_or_else(String::new, |gap| format!("; gap {:.1} ms", gap as f64 / 1e6));
        format!("runs {}; {carried}{gap}", self.build)
    }
}

/// "12 bytes of memory carried over (version 1)".
impl fmt::Display for CarriedMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { version, bytes } = self;
        let unit = if *bytes == 1 { "byte" } else { "bytes" };
        write!(f, "{bytes} {unit} of memory carried over (version {version})")
    }
}

impl Completion {
    /// Sets the outcome; only the first call has an effect.
    pub(crate) fn complete(&self, outcome: Result<Replacement, String>) {
        self.lock().get_or_insert(outcome);
        self.completed.notify_all();
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Result<Replacement, String>>> {
        self.outcome.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl fmt::Debug for Swap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Swap")
            .field("build", &self.build.name)
            .finish_non_exhaustive()
    }
}
