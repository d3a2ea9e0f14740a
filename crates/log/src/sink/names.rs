//! Creates files, numbers their names, and checks whether a folder accepts files.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

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

/// Returns the name with a number: `drive-001.mcap` for `drive.mcap`.
pub(crate) fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number:03}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_files_precede_the_extension() {
        for (path, third) in [
            ("runs/drive.mcap", "runs/drive-003.mcap"),
            ("drive", "drive-003"),
            ("a.b.mcap", "a.b-003.mcap"),
        ] {
            assert_eq!(numbered(path.as_ref(), 3), Path::new(third));
        }
        assert_eq!(numbered("d.mcap".as_ref(), 1234), Path::new("d-1234.mcap"));
    }
}
