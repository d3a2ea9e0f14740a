//! Creates files, and checks whether a folder accepts files.

use std::fs::{self, File};
use std::path::Path;

use super::syncer::{Disk, disk};
use crate::writer::Output;
use crate::{Error, writer};

/// Creates a file and the folders above it. Returns it with its disk, if it has one.
pub(crate) fn create(path: &Path, overwrite: bool) -> Result<(Output, Option<Disk>), Error> {
    with_disk(writer::create(path, overwrite)?, path)
}

/// Returns a created file with its disk, if it has one.
pub(super) fn with_disk(file: File, path: &Path) -> Result<(Output, Option<Disk>), Error> {
    let disk = disk(&file).map_err(|error| Error::Create {
        path: path.to_owned(),
        error,
    })?;
    Ok((Box::new(file), disk))
}

/// Returns whether a numbered file could not be created because its name is in use, whoever uses it.
pub(super) fn is_taken(error: &Error) -> bool {
    match error {
        Error::Exists(_) | Error::Written(_) => true,
        Error::Create { path, .. } => fs::symlink_metadata(path).is_ok(),
        Error::Thread(_) => false,
    }
}

/// Checks whether files can be created in the folder of `path`. It creates a file and deletes it again.
pub(super) fn probe(path: &Path) -> Result<(), Error> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.probe", std::process::id()));
    let probe = path.with_file_name(name);
    drop(writer::create(&probe, true)?);
    fs::remove_file(&probe).map_err(|error| Error::Create {
        path: path.to_owned(),
        error,
    })
}
