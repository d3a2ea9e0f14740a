//! What every row is told: how much effort to make, and where the product is. Decides nothing.

use std::path::PathBuf;
use std::time::Duration;

use jde_measure::pairs::Effort;

/// What a row is told.
#[derive(Clone, Debug)]
pub(crate) struct Scope {
    /// A look rather than a measurement: a tenth of the time.
    pub(crate) quick: bool,
    /// The product's source.
    pub(crate) root: PathBuf,
    /// Where the product is built: its executable and its plugins.
    pub(crate) built: PathBuf,
    /// A Python that has what jde is compared with there, if there is one.
    pub(crate) python: Option<PathBuf>,
}

impl Scope {
    /// For what takes nanoseconds or microseconds.
    pub(crate) fn effort(&self) -> Effort {
        Effort {
            rounds: if self.quick { 11 } else { 61 },
            batch: Duration::from_millis(if self.quick { 1 } else { 4 }),
        }
    }

    /// One of these, by the effort.
    pub(crate) fn either<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }
}
