//! The interface of an inspector of plugin files outside of this process.

use std::fmt;
use std::path::{Path, PathBuf};

use jde_abi::describe;
use jde_abi::inspect::Problem;
use jde_app::Inspection;

use super::LoadError;

/// Inspects plugin files in another process: a damaged library may end the process that maps it. Usable from
/// any thread.
pub trait Inspect: fmt::Debug + Send + Sync {
    /// Describes the plugin in `copy`; `path` is the file that the user knows.
    ///
    /// # Errors
    /// Why it cannot be loaded, for example [`LoadError::InspectionFailed`].
    fn describe(&self, copy: &Path, path: &Path) -> Result<describe::Plugin, LoadError>;

    /// Returns the problems that a type of the plugin in the file `path` finds in the resources that its
    /// modulations name.
    ///
    /// # Errors
    /// Why there is no reply, or no valid one.
    fn inspect(&self, path: &Path, inspection: &Inspection<'_>) -> Result<Vec<Problem>, String>;

    /// Returns the names and files of the plugins that distributions of Python state as entry points; none if Python
    /// cannot be asked.
    fn entry_points(&self) -> Vec<(String, PathBuf)> {
        Vec::new()
    }

    /// Frees the resources of the inspector; the next request obtains them again.
    fn stop(&self);
}
