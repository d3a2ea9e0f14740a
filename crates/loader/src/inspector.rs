//! The interface of what inspects plugin files outside of this process.

use std::fmt;
use std::path::Path;

use jde_abi::describe;
use jde_abi::inspect::Problem;
use jde_app::Inspection;

use super::LoadError;

/// Inspects plugin files elsewhere: a damaged library may end the process that maps it. Usable from any thread.
pub trait Inspect: fmt::Debug + Send + Sync {
    /// Returns the description of the plugin in `copy`; `path` is the file that the user knows.
    ///
    /// # Errors
    /// Why it cannot be loaded, for example [`LoadError::InspectionFailed`].
    fn describe(&self, copy: &Path, path: &Path) -> Result<describe::Plugin, LoadError>;

    /// Returns the problems that a type of the plugin in the file `path` finds in what its modulations name.
    ///
    /// # Errors
    /// Why there is no answer, or no valid one, in words.
    fn inspect(&self, path: &Path, asked: &Inspection<'_>) -> Result<Vec<Problem>, String>;

    /// Frees what the inspector holds; the next request obtains it again.
    fn stop(&self);
}
