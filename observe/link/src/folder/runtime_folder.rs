//! A folder in which applications announce themselves. It is private to the user and has a file and a socket
//! for each application. A file is valid only while its application holds a lock on it, so neither `kill -9`
//! nor a reused process id leaves a false announcement.
//!
//! long because listing, claiming and removing follow one protocol of locks and files.

use std::fs::{DirBuilder, File, OpenOptions, TryLockError};
use std::io::{Read, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use rustix::fs::OFlags;

use crate::keys;
use crate::message::About;
use crate::{Error, decode};

/// Longest announcement file that is read, bytes.
const MAX_ANNOUNCEMENT: u64 = 64 << 10;
/// Longest path of a socket, bytes.
const SOCKET_PATH: usize = 107;
/// Lock file, held while an application claims its name.
const LOCK: &str = "lock";
/// Longest wait for another application's claim.
const LOCK_TIMEOUT: Duration = Duration::from_secs(10);
/// Longest time for listing a folder.
const LIST_TIMEOUT: Duration = Duration::from_secs(5);
/// Most concurrent listings. Listings of a folder that does not answer never end.
const MAX_LISTINGS: usize = 64;
static ACTIVE_LISTINGS: AtomicUsize = AtomicUsize::new(0);

/// A folder that only the user may control.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RuntimeFolder {
    path: PathBuf,
    /// The user's own folder above it. Folders in between are created as needed.
    owned_parent: Option<PathBuf>,
}

/// A listing in progress.
pub(crate) struct Listing {
    folder: RuntimeFolder,
    since: Instant,
    receiver: Receiver<Result<Vec<RunningEntry>, Error>>,
}

/// A claimed name. No other application can claim one in this folder meanwhile.
pub(crate) struct Claim {
    folder: RuntimeFolder,
    pub(crate) name: String,
    pub(crate) id: String,
    /// Released with the claim.
    _lock: File,
}

/// An announced application; dropping it withdraws the announcement.
pub(crate) struct Announcement {
    folder: RuntimeFolder,
    id: String,
    /// Its lock marks the application as running.
    _file: File,
}

/// A running application on this machine.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RunningEntry {
    pub(crate) about: About,
    pub(crate) socket: PathBuf,
    /// The socket for requests to stop everything.
    pub(crate) stop_socket: PathBuf,
}

impl RuntimeFolder {
    pub(super) fn at(path: PathBuf) -> Self {
        Self {
            path,
            owned_parent: None,
        }
    }

    /// A folder below one that must be the user's. The ownership is checked at use, not here.
    pub(super) fn below(folder: PathBuf, path: impl AsRef<Path>) -> Self {
        Self {
            path: folder.join(path),
            owned_parent: Some(folder),
        }
    }

    /// The path.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Starts listing the running applications on a thread of its own, since a network file system may not
    /// answer. A folder that another user made contains none; this is an error only if it is the `only`
    /// folder.
    pub(super) fn start_listing(&self, only: bool) -> Listing {
        let (sender, receiver) = sync_channel(1);
        let since = Instant::now();
        let free = ACTIVE_LISTINGS.try_update(Ordering::Relaxed, Ordering::Relaxed, |listings| {
            (listings < MAX_LISTINGS).then_some(listings + 1)
        });
        if free.is_ok() {
            let folder = self.clone();
            std::thread::spawn(move || {
                let result = match folder.list() {
                    Err(_) if !only && folder.is_foreign() => Ok(Vec::new()),
                    result => result,
                };
                let _ = sender.send(result);
                ACTIVE_LISTINGS.fetch_sub(1, Ordering::Relaxed);
            });
        }
        Listing {
            folder: self.clone(),
            since,
            receiver,
        }
    }

    /// Whether another user owns it or it is not a folder, so that no application of this user can be in it.
    fn is_foreign(&self) -> bool {
        let user = rustix::process::getuid().as_raw();
        std::fs::symlink_metadata(&self.path).is_ok_and(|found| !found.is_dir() || found.uid() != user)
    }

    /// Lists the running applications in no order, and removes the files of killed ones.
    ///
    /// # Errors
    /// [`Error::Folder`]; a folder that does not exist is no error.
    fn list(&self) -> Result<Vec<RunningEntry>, Error> {
        if self.owned_parent.as_deref().is_some_and(|folder| !is_own(folder)) {
            return Ok(Vec::new());
        }
        match std::fs::symlink_metadata(&self.path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            _ => self.check()?,
        }
        // In tests a pipe of this name takes the place of a network file system that does not answer.
        #[cfg(test)]
        drop(File::open(self.path.join("hung")));
        let names = std::fs::read_dir(&self.path).map_err(|error| self.unusable(error))?;
        let mut entries = Vec::new();
        let mut unreadable = Vec::new();
        for file in names.flatten() {
            let name = file.file_name();
            let Some(id) = name.to_str().and_then(|name| name.strip_suffix(".json")) else {
                continue;
            };
            match read_announcement(&file.path()) {
                AnnouncementState::Running(about) if about.id == id => entries.push(RunningEntry {
                    about: *about,
                    socket: self.socket(id),
                    stop_socket: self.stop_socket(id),
                }),
                AnnouncementState::Running(_) | AnnouncementState::Unreadable => {
                    unreadable.push(file.path());
                }
                AnnouncementState::Stale => self.remove_files(id),
            }
        }
        match unreadable.as_slice() {
            [] => {}
            [file] => tracing::warn!(file = %file.display(), "an announcement cannot be read"),
            [file, others @ ..] => {
                let others = others.len();
                tracing::warn!(file = %file.display(), others, "announcements cannot be read");
            }
        }
        Ok(entries)
    }

    /// Claims a name: the requested one, or, if a running application has it and it is not required,
    /// the name with a number appended.
    ///
    /// # Errors
    /// [`Error::Folder`]; [`Error::NameTaken`] for a required name; [`Error::Name`].
    pub(super) fn claim(
        &self,
        requested: &str,
        required: bool,
        running: impl Fn() -> Result<Vec<RunningEntry>, Error>,
    ) -> Result<Claim, Error> {
        if !keys::is_name(requested) {
            return Err(Error::Name(requested.to_owned()));
        }
        self.create()?;
        let lock = self.lock()?;
        let running = running()?;
        self.remove_stale_files(&running)?;
        let holder = |name: &str| running.iter().find(|entry| entry.about.name == name);
        let mut name = requested.to_owned();
        let mut number = 1;
        while let Some(other) = holder(&name) {
            if required {
                return Err(Error::NameTaken {
                    name,
                    pid: other.about.pid,
                });
            }
            number += 1;
            let suffix = format!("-{number}");
            name = format!("{}{suffix}", &requested[..requested.len().min(64 - suffix.len())]);
        }
        let claim = Claim {
            folder: self.clone(),
            name,
            id: new_id()?,
            _lock: lock,
        };
        let socket = claim.socket();
        if socket.as_os_str().len() > SOCKET_PATH {
            return Err(self.refused(
                format!("the path of a socket in it has more than {SOCKET_PATH} bytes"),
                "set XDG_RUNTIME_DIR to a folder with a shorter path",
            ));
        }
        Ok(claim)
    }

    fn socket(&self, id: &str) -> PathBuf {
        self.path.join(format!("{id}.sock"))
    }

    fn stop_socket(&self, id: &str) -> PathBuf {
        self.path.join(format!("{id}.stop"))
    }

    fn create(&self) -> Result<(), Error> {
        let create = || {
            if self.owned_parent.as_deref().is_some_and(|folder| !is_own(folder)) {
                return Err(std::io::ErrorKind::PermissionDenied.into());
            }
            if let Some(parent) = self.path.parent().filter(|_| self.owned_parent.is_some()) {
                DirBuilder::new().mode(0o700).recursive(true).create(parent)?;
            }
            DirBuilder::new().mode(0o700).create(&self.path)
        };
        match create() {
            Ok(()) => Ok(()),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => self.check(),
            Err(error) => Err(self.unusable(error)),
        }
    }

    /// Refuses a folder in which another user could have placed a file.
    fn check(&self) -> Result<(), Error> {
        let found = std::fs::symlink_metadata(&self.path).map_err(|error| self.unusable(error))?;
        let user = rustix::process::getuid().as_raw();
        if !found.is_dir() {
            return Err(self.refused("it is not a folder", "remove it"));
        }
        if found.uid() != user {
            return Err(self.refused(
                format!("it belongs to user {}, not to {user}", found.uid()),
                "have it removed, or set XDG_RUNTIME_DIR to a folder of yours",
            ));
        }
        if found.mode() & 0o077 != 0 {
            return Err(self.refused(
                format!("others may enter it (mode {:o})", found.mode() & 0o777),
                format!("remove it, or run `chmod 700 {}`", self.path.display()),
            ));
        }
        Ok(())
    }

    fn lock(&self) -> Result<File, Error> {
        let lock = OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            // A pipe would wait for its reader.
            .custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed())
            .open(self.path.join(LOCK))
            .map_err(|error| self.unusable(error))?;
        let deadline = Instant::now() + LOCK_TIMEOUT;
        loop {
            match lock.try_lock() {
                Ok(()) => return Ok(lock),
                Err(TryLockError::WouldBlock) if Instant::now() < deadline => {
                    std::thread::sleep(Duration::from_millis(5));
                }
                Err(TryLockError::WouldBlock) => {
                    return Err(self.refused(
                        "another application has held its lock for too long",
                        "end the application that is stopped",
                    ));
                }
                Err(TryLockError::Error(error)) => return Err(self.unusable(error)),
            }
        }
    }

    /// Removes files of applications that do not run. The caller holds the lock, so no application is
    /// starting up here.
    fn remove_stale_files(&self, running: &[RunningEntry]) -> Result<(), Error> {
        let names = std::fs::read_dir(&self.path).map_err(|error| self.unusable(error))?;
        for file in names.flatten() {
            let name = file.file_name();
            let name = name.to_string_lossy();
            let of_running = running
                .iter()
                .any(|entry| name.starts_with(entry.about.id.as_str()));
            let suffixes = [".sock", ".sock.lock", ".stop", ".tmp"];
            if !of_running && suffixes.iter().any(|suffix| name.ends_with(suffix)) {
                let _ = std::fs::remove_file(file.path());
            }
        }
        Ok(())
    }

    fn remove_files(&self, id: &str) {
        for suffix in ["json", "sock", "sock.lock", "stop"] {
            // Another process may remove it at the same time.
            let _ = std::fs::remove_file(self.path.join(format!("{id}.{suffix}")));
        }
    }

    fn unusable(&self, error: std::io::Error) -> Error {
        self.refused(
            error.to_string(),
            "set XDG_RUNTIME_DIR to a folder that you may write to",
        )
    }

    fn refused(&self, reason: impl Into<String>, advice: impl Into<String>) -> Error {
        Error::Folder {
            path: self.path.clone(),
            reason: reason.into(),
            advice: advice.into(),
        }
    }
}

impl Listing {
    /// The path of the folder.
    pub(crate) fn path(&self) -> &Path {
        &self.folder.path
    }

    /// Waits for the running applications, in no order.
    ///
    /// # Errors
    /// [`Error::Folder`], also if the folder does not answer in 5 s. A folder that does not exist is no
    /// error.
    pub(crate) fn wait(self) -> Result<Vec<RunningEntry>, Error> {
        let remaining = LIST_TIMEOUT.saturating_sub(self.since.elapsed());
        self.receiver.recv_timeout(remaining).unwrap_or_else(|_| {
            Err(self.folder.refused(
                format!("it cannot be listed within {LIST_TIMEOUT:?}"),
                "check its file system",
            ))
        })
    }
}

impl Claim {
    /// The socket on which the application listens.
    pub(crate) fn socket(&self) -> PathBuf {
        self.folder.socket(&self.id)
    }

    /// The socket at which it receives requests to stop everything.
    pub(crate) fn stop_socket(&self) -> PathBuf {
        self.folder.stop_socket(&self.id)
    }

    /// Writes a file that only this user can read, and that is removed when the result is dropped.
    pub(crate) fn secret(&self, text: &str) -> Result<Secret, Error> {
        let folder = &self.folder;
        let path = folder.path.join(format!("{}.tmp", new_id()?));
        write(&path, text).map_err(|error| folder.unusable(error))?;
        Ok(Secret { path })
    }

    /// Announces the application, which already listens.
    pub(crate) fn announce(self, about: &About) -> Result<Announcement, Error> {
        let folder = &self.folder;
        let path = folder.path.join(format!("{}.json", self.id));
        let new = folder.path.join(format!("{}.tmp", self.id));
        let announce = || {
            let text = serde_json::to_string_pretty(about).map_err(std::io::Error::from)?;
            let file = write(&new, &text)?;
            file.lock()?;
            std::fs::rename(&new, &path)?;
            Ok(file)
        };
        let file = announce().map_err(|error| folder.unusable(error))?;
        Ok(Announcement {
            folder: self.folder.clone(),
            id: self.id,
            _file: file,
        })
    }
}

impl Drop for Announcement {
    fn drop(&mut self) {
        self.folder.remove_files(&self.id);
    }
}

/// A file that only this user can read; removed when dropped.
pub(crate) struct Secret {
    path: PathBuf,
}

impl Secret {
    pub(crate) fn path(&self) -> String {
        self.path.to_string_lossy().into_owned()
    }
}

impl Drop for Secret {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Whether a path is a folder of this user.
pub(super) fn is_own(folder: &Path) -> bool {
    let user = rustix::process::getuid().as_raw();
    std::fs::metadata(folder).is_ok_and(|folder| folder.is_dir() && folder.uid() == user)
}

/// The state of an announcement file.
enum AnnouncementState {
    Running(Box<About>),
    /// Its application no longer runs.
    Stale,
    Unreadable,
}

fn read_announcement(path: &Path) -> AnnouncementState {
    let Ok(mut file) = OpenOptions::new()
        .read(true)
        // A pipe would wait for its writer.
        .custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed())
        .open(path)
    else {
        return AnnouncementState::Unreadable;
    };
    match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => {}
        Ok(()) => return AnnouncementState::Stale,
        Err(TryLockError::Error(_)) => return AnnouncementState::Unreadable,
    }
    let mut text = String::new();
    if Read::by_ref(&mut file)
        .take(MAX_ANNOUNCEMENT)
        .read_to_string(&mut text)
        .is_err()
    {
        return AnnouncementState::Unreadable;
    }
    match decode::about(text.as_bytes()) {
        Ok(about) => AnnouncementState::Running(Box::new(about)),
        Err(_) => AnnouncementState::Unreadable,
    }
}

fn write(path: &Path, text: &str) -> std::io::Result<File> {
    let mut file = OpenOptions::new()
        .read(true)
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(path)?;
    file.write_all(text.as_bytes())?;
    Ok(file)
}

/// A random id of 16 hexadecimal digits.
pub(crate) fn new_id() -> Result<String, Error> {
    let mut bytes = [0; 8];
    let mut random = File::open("/dev/urandom").map_err(|error| Error::Open(error.to_string()))?;
    random
        .read_exact(&mut bytes)
        .map_err(|error| Error::Open(error.to_string()))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
pub(crate) mod tests {
    use crate::message::{About, Network};

    /// The announcement of an application for tests.
    pub(crate) fn about(name: &str, id: &str) -> About {
        About {
            name: name.to_owned(),
            id: id.to_owned(),
            protocol: crate::PROTOCOL,
            version: String::new(),
            host: String::new(),
            user: String::new(),
            pid: 1,
            application: String::new(),
            file: String::new(),
            started_ns: 0,
            executor: String::new(),
            speed: 1.0,
            network: Network::Closed,
        }
    }
}
