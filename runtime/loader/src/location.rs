//! The location of a plugin for another process.

use std::fs::{self, File};
use std::os::fd::{IntoRawFd as _, OwnedFd};
use std::os::unix::fs::MetadataExt as _;
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

impl PluginLocation {
    /// Returns it with `held`, the open file of its copy, in place of a path at which that is no longer: a folder of
    /// temporary files is cleaned up while applications run. The file then stays open as long as this process lives.
    #[must_use]
    pub fn or_open(mut self, held: Option<OwnedFd>) -> Self {
        let (Self::File(copy) | Self::Python { copy, .. }, Some(held)) = (&mut self, held.map(File::from))
        else {
            return self;
        };
        let identity = |file: fs::Metadata| (file.dev(), file.ino());
        let is_there = fs::metadata(&*copy).map(identity).ok() == held.metadata().map(identity).ok();
        if !is_there {
            *copy = format!("/proc/self/fd/{}", held.into_raw_fd()).into();
        }
        self
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_whose_name_is_gone_or_another_file_s_is_read_through_its_open_file() {
        let folder = tempfile::tempdir().unwrap();
        let copy = folder.path().join("jde-1-libx-abc.so");
        fs::write(&copy, "the copy").unwrap();
        let held = || Some(OwnedFd::from(File::open(&copy).unwrap()));
        let location = || PluginLocation::File(copy.clone());
        let path = |location: PluginLocation| match location {
            PluginLocation::File(path) => path,
            other => panic!("{other:?}"),
        };
        assert_eq!(path(location().or_open(None)), copy);
        assert_eq!(path(location().or_open(held())), copy);
        let gone = held();
        fs::remove_file(&copy).unwrap();
        let opened = path(location().or_open(gone.as_ref().map(|file| file.try_clone().unwrap())));
        assert_eq!(fs::read_to_string(opened).unwrap(), "the copy");
        fs::write(&copy, "somebody else's").unwrap();
        let opened = path(location().or_open(gone));
        assert_eq!(fs::read_to_string(opened).unwrap(), "the copy");
    }
}
