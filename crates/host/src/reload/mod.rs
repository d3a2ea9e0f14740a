//! Putting another build of a schema in the place of the one that runs, between two of its iterations (R10), and going back.
//!
//! Whether a build fits is found before anything is touched ([`crate::Operating::replace`]); the exchange itself is the runner's,
//! in a turn of the schema. The hierarchy does not hear of it: the schema keeps its state, its authority and its variables.

mod reloader;

use std::fmt;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use jde_core::Nanos;
use serde::{Deserialize, Serialize};

use crate::build::{self, BuildName};
pub use reloader::{Became, Refused, Reloaded, Reloader};

/// How long a new build is on trial if nobody says otherwise: most mistakes show within seconds, and what shows later is a fault
/// like any other.
pub const PROBATION: Nanos = 3_000_000_000;
/// Turns of the schema that a trial lasts at least: slow schemas have had a chance to fail by then.
pub(crate) const LEAST_TURNS: u32 = 10;

/// How a build takes over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct How {
    /// How long it is on trial, ns of the application's time, and ten turns at least: until then a fault goes back to the build
    /// before, which waits asleep. 0 for no trial.
    pub probation: Nanos,
    /// It begins anew, whatever the build before remembers.
    pub fresh: bool,
}

/// How a build took over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Takeover {
    /// The build.
    pub build: BuildName,
    /// What it took over from the build before; none if it began anew.
    pub carried: Option<Carried>,
    /// From the end of the last turn of the build before to the first look of this one, ns of the application's time: the time in
    /// which nobody could react. None if the schema sleeps.
    pub gap: Option<Nanos>,
    /// How long the exchange took, ns of the machine's time.
    pub took: Nanos,
    /// How long it is on trial, ns of the application's time.
    pub probation: Nanos,
    /// What of it is not in force before the application starts anew.
    pub notes: Vec<String>,
}

/// What one build took over from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Carried {
    /// The version in which it was saved.
    pub version: u32,
    /// Its size.
    pub bytes: usize,
}

/// A build that is to take over at the schema's next turn. Dropping it changes nothing.
pub struct Reload {
    order: Arc<Order>,
}

/// What the runner is told.
pub(crate) struct Swap {
    pub(crate) build: build::Shared,
    pub(crate) how: How,
    pub(crate) notes: Vec<String>,
    pub(crate) order: Arc<Order>,
}

/// Where the outcome of a reload is left.
#[derive(Default)]
pub(crate) struct Order {
    outcome: Mutex<Option<Result<Takeover, String>>>,
    settled: Condvar,
}

impl Default for How {
    fn default() -> Self {
        Self {
            probation: PROBATION,
            fresh: false,
        }
    }
}

impl Reload {
    pub(crate) fn new(order: &Arc<Order>) -> Self {
        Self {
            order: Arc::clone(order),
        }
    }

    /// How it went, once it is known: the build took over and did its first turn, or why it did not and the one before goes on.
    #[must_use]
    pub fn outcome(&self) -> Option<Result<Takeover, String>> {
        self.order.lock().clone()
    }

    /// Waits for the outcome, at most so long. In lockstep only another thread than the one that runs the application may.
    #[must_use]
    pub fn wait(&self, within: Duration) -> Option<Result<Takeover, String>> {
        let outcome = self.order.lock();
        let (outcome, _) = self
            .order
            .settled
            .wait_timeout_while(outcome, within, |outcome| outcome.is_none())
            .unwrap_or_else(PoisonError::into_inner);
        outcome.clone()
    }
}

impl Takeover {
    /// It in words: "runs 0.2.0 from libvff.so; 12 bytes of memory carried over (version 1); gap 31.2 ms".
    #[must_use]
    pub fn words(&self) -> String {
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
impl fmt::Display for Carried {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { version, bytes } = self;
        let unit = if *bytes == 1 { "byte" } else { "bytes" };
        write!(f, "{bytes} {unit} of memory carried over (version {version})")
    }
}

impl Order {
    /// The first outcome counts.
    pub(crate) fn settle(&self, outcome: Result<Takeover, String>) {
        self.lock().get_or_insert(outcome);
        self.settled.notify_all();
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Result<Takeover, String>>> {
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
