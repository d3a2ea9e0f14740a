//! The folder of a file that is to be written.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;

/// Creates a folder unless it exists, and none above it: a mistaken path leaves no tree of folders. An empty path is the
/// working folder.
///
/// # Errors
/// The folder above does not exist, which the error names with what creates it, or the folder cannot be created.
pub fn create_folder(folder: &Path) -> io::Result<()> {
    if folder.as_os_str().is_empty() || folder.is_dir() {
        return Ok(());
    }
    let created = fs::create_dir(folder);
    created.or_else(|error| match (error.kind(), folder.parent()) {
        // Somebody else has just created it.
        (ErrorKind::AlreadyExists, _) if folder.is_dir() => Ok(()),
        (ErrorKind::AlreadyExists, _) => {
            let message = format!("{} is a file, where a folder is needed", folder.display());
            Err(io::Error::new(ErrorKind::AlreadyExists, message))
        }
        (ErrorKind::NotFound, Some(above)) => {
            let above = above.display();
            let message = format!("the folder {above} does not exist; create it first: mkdir -p {above}");
            Err(io::Error::new(ErrorKind::NotFound, message))
        }
        (_, _) => Err(error),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_folder_is_created_and_no_tree() {
        let folder = tempfile::tempdir().unwrap();
        let last = folder.path().join("last");
        create_folder(&last).unwrap();
        create_folder(&last).unwrap();
        create_folder(Path::new("")).unwrap();
        assert!(last.is_dir());
        let above = folder.path().join("none");
        let refused = create_folder(&above.join("last")).unwrap_err().to_string();
        let advice = format!("mkdir -p {}", above.display());
        assert!(refused.ends_with(&advice) && !above.exists(), "{refused}");
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(create_folder(&file).is_err(), "it is no folder");
    }
}
