//! The folder of all files that an agent may name. A path is checked as it really is, behind all links, and nothing
//! outside is read.

use std::path::{Path, PathBuf};

use jde_session::paths;

use crate::failure::{Failure, RunFailure, display_path};

/// The folder.
pub(super) struct Folder {
    root: PathBuf,
}

impl Folder {
    /// Makes this the working folder of the process, to which all paths are relative.
    ///
    /// # Errors
    /// It does not exist.
    pub(super) fn open(path: &Path) -> Result<Self, Failure> {
        let root = path.canonicalize().map_err(Failure::file(path))?;
        std::env::set_current_dir(&root).map_err(Failure::file(path))?;
        Ok(Self { root })
    }

    /// Returns the real path of a file or a folder in it.
    ///
    /// # Errors
    /// There is none, or it is outside.
    pub(super) fn resolve(&self, given: &str) -> Result<PathBuf, Failure> {
        self.check(given, Path::new(given), &[])
    }

    /// Returns the real path of an application or an experiment, which may be one that comes with `jde`. `find` looks for
    /// its name.
    ///
    /// # Errors
    /// There is none, or it is outside.
    pub(super) fn resolve_named(
        &self,
        given: &str,
        find: impl FnOnce(&Path) -> Result<PathBuf, RunFailure>,
    ) -> Result<PathBuf, Failure> {
        check_text(given)?;
        let found = find(Path::new(given))?;
        self.check(given, &found, &[paths::data()])
    }

    /// Checks that files which were found beside a given one are in the folder too.
    ///
    /// # Errors
    /// One is outside.
    pub(super) fn check_all<'f>(&self, mut files: impl Iterator<Item = &'f Path>) -> Result<(), Failure> {
        files.try_for_each(|file| self.check(&file.to_string_lossy(), file, &[]).map(drop))
    }

    fn check(&self, given: &str, path: &Path, others: &[PathBuf]) -> Result<PathBuf, Failure> {
        check_text(given)?;
        let is_within = |path: &Path| {
            let others = others.iter().filter_map(|other| other.canonicalize().ok());
            path.starts_with(&self.root) || others.into_iter().any(|other| path.starts_with(other))
        };
        match self.root.join(path).canonicalize() {
            Ok(real) if is_within(&real) => Ok(real),
            // What is outside is not distinguished from what does not exist.
            Ok(_) | Err(_) => Err(Failure::broken(format!(
                "there is no file `{}` in the folder of this server",
                display_path(Path::new(given))
            ))),
        }
    }
}

/// Refuses what is no path of a file here, whatever exists.
fn check_text(given: &str) -> Result<(), Failure> {
    match given {
        "" => Err(Failure::broken("the path is empty")),
        _ if given.starts_with('-') => Err(Failure::broken("a path does not begin with `-`")),
        _ if given.contains('\0') => Err(Failure::broken("a path has no zero byte")),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn only_what_is_really_in_the_folder_is_found() {
        let above = tempfile::tempdir().unwrap();
        let root = above.path().canonicalize().unwrap().join("robot");
        fs::create_dir_all(root.join("tests")).unwrap();
        fs::write(root.join("drive.mcap"), "").unwrap();
        fs::write(root.join("-rf"), "").unwrap();
        fs::write(above.path().join("secret"), "").unwrap();
        symlink(above.path().join("secret"), root.join("link")).unwrap();
        symlink(above.path(), root.join("up")).unwrap();
        symlink(root.join("drive.mcap"), root.join("newest")).unwrap();
        let folder = Folder { root: root.clone() };
        for given in ["drive.mcap", "./tests/../drive.mcap", "newest"] {
            assert_eq!(folder.resolve(given).unwrap(), root.join("drive.mcap"), "{given}");
        }
        assert!(folder.resolve(root.join("tests").to_str().unwrap()).is_ok());
        for given in [
            "link",
            "up/secret",
            "../secret",
            "/etc/passwd",
            "-rf",
            "",
            "a\0b",
            "none",
        ] {
            assert!(folder.resolve(given).is_err(), "{given}");
        }
        let found = |path: &str| folder.resolve_named("name", |_| Ok(path.into()));
        assert!(found("drive.mcap").is_ok() && found("../secret").is_err());
    }
}
