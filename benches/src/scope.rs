//! The parameters of every row: the effort, and the places of the product. Decides nothing.

use std::path::PathBuf;
use std::time::Duration;

use jde_measure::pairs::Effort;

/// The parameters of a row.
#[derive(Clone, Debug)]
pub(crate) struct Scope {
    /// Whether to take a tenth of the time, for less reliable figures.
    pub(crate) quick: bool,
    /// The root of the product's source.
    pub(crate) root: PathBuf,
    /// The folder with the built product: its executable and its plugins.
    pub(crate) built: PathBuf,
    /// A Python interpreter with the package that one row compares with, if any.
    pub(crate) python: Option<PathBuf>,
}

impl Scope {
    /// Returns the effort for operations that take nanoseconds or microseconds.
    pub(crate) fn effort(&self) -> Effort {
        Effort {
            rounds: if self.quick { 11 } else { 61 },
            batch: Duration::from_millis(if self.quick { 1 } else { 4 }),
        }
    }

    /// Returns one of two values, by the effort.
    pub(crate) fn either<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }
}
