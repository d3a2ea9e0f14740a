//! Making files, the names of those that are numbered, and whether files can be made there at all.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use super::syncer::{Disk, disk};
use crate::writer::Output;
use crate::{Error, writer};

/// Makes a file and the folders above it; answers also with its disk, if it has one.
pub(crate) fn create(path: &Path, overwrite: bool) -> Result<(Output, Option<Disk>), Error> {
    with_disk(writer::create(path, overwrite)?, path)
}

/// A file that was made, and its disk.
pub(super) fn with_disk(file: File, path: &Path) -> Result<(Output, Option<Disk>), Error> {
    let disk = disk(&file).map_err(|error| Error::Create {
        path: path.to_owned(),
        error,
    })?;
    Ok((Box::new(file), disk))
}

/// Whether files can be made beside the one that is asked for. What it makes it takes away again.
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

/// `drive.mcap` with a number: `drive-001.mcap`.
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
    fn files_are_numbered_before_their_ending() {
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
