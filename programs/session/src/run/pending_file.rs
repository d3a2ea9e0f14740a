//! A file that a run will write: checked for writability before the run, and left unchanged until there is
//! something to write.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// A writable file. If it was created here and nothing is written, it is removed again.
pub(crate) struct PendingFile {
    path: PathBuf,
    /// `None` once it is written.
    file: Option<File>,
    created: bool,
}

impl PendingFile {
    /// Opens a file without changing its content. A missing file and its folder are created.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn prepare(path: &Path) -> Result<Self, Failure> {
        let opened = path
            .parent()
            .map_or(Ok(()), jde_files::create_folder)
            .and_then(|()| open(path));
        let (file, made) = opened.map_err(Failure::file(path))?;
        Ok(Self {
            path: path.to_owned(),
            file: Some(file),
            created: made,
        })
    }

    /// Returns the file, emptied, for writing.
    ///
    /// # Errors
    /// The content cannot be removed.
    pub(crate) fn into_truncated(mut self) -> io::Result<File> {
        let file = self.file.take().ok_or(ErrorKind::NotFound)?;
        // Pipes and terminals have no length.
        if file.metadata()?.is_file() {
            file.set_len(0)?;
        }
        Ok(file)
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        if self.created && self.file.is_some() {
            // A leftover empty file does no harm.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Returns the file, and whether it was created.
fn open(path: &Path) -> io::Result<(File, bool)> {
    match File::options().write(true).create_new(true).open(path) {
        Ok(file) => Ok((file, true)),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            Ok((File::options().write(true).open(path)?, false))
        }
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn a_file_is_unchanged_until_it_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("above/old.png");
        drop(PendingFile::prepare(&path).unwrap());
        assert!(!path.exists(), "an unused file is not left behind");
        fs::write(&path, "the old picture").unwrap();
        drop(PendingFile::prepare(&path).unwrap());
        assert_eq!(fs::read(&path).unwrap(), b"the old picture");
        let mut file = PendingFile::prepare(&path).unwrap().into_truncated().unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert!(
            PendingFile::prepare(folder.path()).is_err(),
            "a folder is not a file"
        );
    }
}
