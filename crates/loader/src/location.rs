//! The location of a plugin for another process.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The location of a plugin for another process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum PluginLocation {
    /// In the file that this process has mapped: the same bytes, whatever was built since.
    File(#[serde(with = "as_bytes")] PathBuf),
    /// A file of Python.
    Python {
        /// The copy that only its user reads: the same bytes, whatever was written since.
        #[serde(with = "as_bytes")]
        copy: PathBuf,
        /// The file that the user knows.
        #[serde(with = "as_bytes")]
        path: PathBuf,
    },
    /// Linked into the program.
    LinkedIn(String),
}

/// Serializes paths as bytes: they need not be valid text.
pub mod as_bytes {
    use std::ffi::OsString;
    use std::os::unix::ffi::{OsStrExt, OsStringExt};
    use std::path::{Path, PathBuf};

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// Writes a path as bytes.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
        path.as_os_str().as_bytes().serialize(serializer)
    }

    /// Reads a path from bytes.
    ///
    /// # Errors
    /// Those of the deserializer.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<PathBuf, D::Error> {
        Ok(OsString::from_vec(Vec::deserialize(deserializer)?).into())
    }
}
