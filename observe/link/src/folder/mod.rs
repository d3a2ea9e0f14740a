//! The folders in which applications of one user announce themselves on one machine, and in which tools
//! search for them. An application uses the first folder that only its user controls. A tool searches all of
//! them, since a boot service, a login and `su` have different environments. Opens no session.

pub(crate) mod runtime_folder;

use std::path::{Path, PathBuf};

use crate::{Error, whoami};
pub(crate) use runtime_folder::{Announcement, Claim, Listing, RunningEntry, Secret, new_id};
use runtime_folder::{RuntimeFolder, is_own};

/// Environment variable with the only folder to use, for tests and for isolated applications.
const ONLY: &str = "JDE_RUNTIME_DIR";

/// The folder for temporary files below the root, for processes without another one in their environment,
/// such as boot services.
const TEMPORARY: &str = "tmp";

/// The private folders of a user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folders {
    /// At least one.
    folders: Vec<RuntimeFolder>,
}

impl Folders {
    /// The folders of this user: the one in `$JDE_RUNTIME_DIR` alone, if that is set. Otherwise `jde` in
    /// `$XDG_RUNTIME_DIR` and in `/run/user/<uid>`, `jde-<uid>` among the temporary files, and one per
    /// machine below the user's home, where other users cannot interfere.
    #[must_use]
    pub fn of_user() -> Self {
        let named = |key: &str| {
            let path = std::env::var_os(key).map(PathBuf::from);
            path.filter(|path| path.is_absolute())
        };
        if let Some(only) = named(ONLY) {
            return Self::at(only);
        }
        let user = rustix::process::getuid().as_raw();
        Self::among(
            user,
            [named("XDG_RUNTIME_DIR"), Some(format!("/run/user/{user}").into())],
            [std::env::temp_dir(), Path::new("/").join(TEMPORARY)],
            whoami::home(),
        )
    }

    /// Combines runtime folders, as far as the user owns them, folders for temporary files, and a home.
    fn among(
        user: u32,
        runtime: [Option<PathBuf>; 2],
        temporary: [PathBuf; 2],
        home: Option<PathBuf>,
    ) -> Self {
        let runtime = runtime.into_iter().flatten().filter(|folder| is_own(folder));
        let temporary = temporary.map(|folder| folder.join(format!("jde-{user}")));
        let home = home.map(|home| {
            // Machines may share a home.
            let run = format!("run-{}", whoami::host());
            RuntimeFolder::below(home, Path::new(".local/state/jde").join(run))
        });
        let mut folders: Vec<RuntimeFolder> = Vec::new();
        let direct = runtime.map(|folder| folder.join("jde")).chain(temporary);
        for folder in direct.map(RuntimeFolder::at).chain(home) {
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
        Self { folders }
    }

    /// A single folder.
    #[must_use]
    pub fn at(path: impl Into<PathBuf>) -> Self {
        Self {
            folders: vec![RuntimeFolder::at(path.into())],
        }
    }

    /// Several folders, for tests of searches in all of them.
    #[cfg(test)]
    pub(crate) fn several(paths: [PathBuf; 2]) -> Self {
        Self {
            folders: paths.map(RuntimeFolder::at).into(),
        }
    }

    /// The first folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folders[0].path()
    }

    /// Starts listing all folders concurrently.
    pub(crate) fn listings(&self) -> Vec<Listing> {
        let only = self.folders.len() == 1;
        self.folders
            .iter()
            .map(|folder| folder.start_listing(only))
            .collect()
    }

    /// Lists the running applications in order of their start, and removes the files of killed ones. A folder
    /// that cannot be listed is skipped, unless it is the only one.
    ///
    /// # Errors
    /// [`Error::Folder`]. A folder that does not exist is no error. Takes 5 s at most.
    pub(crate) fn list(&self) -> Result<Vec<RunningEntry>, Error> {
        let mut entries: Vec<RunningEntry> = Vec::new();
        for listing in self.listings() {
            match listing.wait() {
                Ok(found) => entries.extend(found),
                Err(error) if self.folders.len() == 1 => return Err(error),
                Err(error) => tracing::debug!("{error}"),
            }
        }
        entries.sort_by(|a, b| (a.about.started_ns, &a.about.id).cmp(&(b.about.started_ns, &b.about.id)));
        // The same folder may be found under two names.
        entries.dedup_by(|a, b| a.about.id == b.about.id);
        Ok(entries)
    }

    /// Claims a name in the first folder that only this user controls: the requested name, or, if it is taken
    /// and not required, the name with a number appended.
    ///
    /// # Errors
    /// [`Error::Folder`] of the first folder if none is usable; [`Error::NameTaken`] for a required name;
    /// [`Error::Name`].
    pub(crate) fn claim(&self, requested: &str, required: bool) -> Result<Claim, Error> {
        let mut refused = None;
        for folder in &self.folders {
            match folder.claim(requested, required, || self.list()) {
                Err(error @ Error::Folder { .. }) => {
                    refused.get_or_insert(error);
                }
                claimed => {
                    if let Some(error) = refused {
                        tracing::warn!("{error}; {} is used instead", folder.path().display());
                    }
                    return claimed;
                }
            }
        }
        Err(refused.expect("there is at least one folder"))
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{DirBuilderExt as _, symlink};

    use super::*;

    /// The folders of a user below one root: a runtime folder if `named`, a folder for temporary files, and a
    /// home.
    fn of_user(root: &Path, named: bool) -> Folders {
        let user = rustix::process::getuid().as_raw();
        let temporary = root.join("tmp");
        let runtime = root.join("run");
        Folders::among(
            user,
            [named.then_some(runtime.clone()), None],
            [temporary.clone(), temporary],
            Some(root.join("home")),
        )
    }

    fn announce(folders: &Folders, name: &str) -> Announcement {
        let claim = folders.claim(name, true).unwrap();
        let about = runtime_folder::tests::about(name, &claim.id);
        claim.announce(&about).unwrap()
    }

    fn names(folders: &Folders) -> Vec<String> {
        let entries = folders.list().unwrap().into_iter();
        let mut names: Vec<_> = entries.map(|entry| entry.about.name).collect();
        names.sort();
        names
    }

    #[test]
    fn an_announcement_of_a_boot_service_is_found_from_a_login_with_another_runtime_folder() {
        let root = tempfile::tempdir().unwrap();
        for folder in ["run", "tmp"] {
            std::fs::create_dir(root.path().join(folder)).unwrap();
        }
        let (service, login) = (of_user(root.path(), false), of_user(root.path(), true));
        let _booted = announce(&service, "booted");
        assert_eq!(names(&login), ["booted"]);
        let taken = login.claim("booted", true).err().unwrap();
        assert!(matches!(taken, Error::NameTaken { .. }), "{taken}");
        let _second = announce(&login, "second");
        assert_eq!(names(&login), ["booted", "second"]);
        assert_eq!(login.path(), root.path().join("run/jde"));
    }

    #[test]
    fn an_unsafe_folder_is_skipped_when_announcing_and_searching() {
        let root = tempfile::tempdir().unwrap();
        for folder in ["tmp", "home"] {
            std::fs::create_dir(root.path().join(folder)).unwrap();
        }
        let folders = of_user(root.path(), false);
        let squatted = folders.path().to_owned();
        assert_eq!(squatted.parent(), Some(&*root.path().join("tmp")));
        // Another user may create there: a folder that others may enter, a link, or a file.
        std::fs::DirBuilder::new().mode(0o777).create(&squatted).unwrap();
        let mode = std::os::unix::fs::PermissionsExt::from_mode(0o777);
        std::fs::set_permissions(&squatted, mode).unwrap();
        assert_eq!(names(&folders), [""; 0]);
        let _robot = announce(&folders, "robot");
        assert_eq!(names(&folders), ["robot"]);
        std::fs::remove_dir(&squatted).unwrap();
        symlink(root.path(), &squatted).unwrap();
        assert_eq!(names(&folders), ["robot"]);
        std::fs::remove_file(&squatted).unwrap();
        std::fs::write(&squatted, "").unwrap();
        assert_eq!(names(&folders), ["robot"]);
        let _other = announce(&folders, "other");
        assert_eq!(names(&folders), ["other", "robot"]);
    }

    #[test]
    fn if_no_folder_is_usable_the_error_names_the_first() {
        let root = tempfile::tempdir().unwrap();
        let error = of_user(root.path(), false).claim("robot", false).err().unwrap();
        assert!(error.to_string().contains("/tmp/jde-"), "{error}");
    }
}
