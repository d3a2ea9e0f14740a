//! `jde run --watch`: watches the files of an application's plugins, and reloads every complete new build.
//!
//! It compares times, sizes and inode numbers ten times a second instead of using notifications of the
//! kernel. This works on every file system and needs no library, at ten calls of `stat` a second for each
//! plugin, and for each module that a file of Python imports from beside it. Files that a linker has not finished are left
//! alone.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_host::Handle;
use jde_host::reload::{ReloadOptions, Reloader};
use jde_loader::{Plugins, modules, python};
use jde_records::reload::ReloadOutcome;

/// Time between two checks of the files.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// How long a file must stay unchanged to count as written. Linkers write in many steps, and copies of large
/// files arrive in parts.
const SETTLE_TIME: Duration = Duration::from_millis(200);
/// How long a file that is not a complete library may stay unchanged before that is reported.
const INCOMPLETE_TIMEOUT: Duration = Duration::from_secs(2);

/// Watches until it is dropped.
pub(super) struct PluginWatcher {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// A watched file.
struct WatchedFile {
    /// Its plugin's place in the application.
    plugin: usize,
    file: PathBuf,
    /// The modules that a file of Python imports from beside it.
    modules: Vec<PathBuf>,
    /// Its state and theirs when it was last handled.
    handled: Option<Vec<FileStamp>>,
    /// The new state, and since when.
    pending: Option<(Vec<FileStamp>, Instant)>,
    tried: bool,
}

/// The state of a file, as far as needed to detect changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FileStamp {
    modified: (i64, i64),
    length: u64,
    inode: u64,
}

/// What to do about a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ReloadAction {
    Nothing,
    /// The file appears to be complete: try to load it.
    Try,
    /// The file has stayed unchanged for long: try to load it, and report why if that fails.
    TryLast,
}

impl PluginWatcher {
    /// Watches the plugins of an application on a new thread.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub(super) fn start(handle: Handle, plugins: Arc<Plugins>) -> std::io::Result<Self> {
        let reloader = Reloader::new(handle, plugins);
        let files = reloader.files().into_iter();
        let mut files: Vec<_> = files
            .map(|(plugin, file)| WatchedFile::new(plugin, file))
            .collect();
        let (stop, stopped) = channel();
        let watch = move || {
            while let Err(RecvTimeoutError::Timeout) = stopped.recv_timeout(POLL_INTERVAL) {
                for watched in &mut files {
                    let action = watched.check(Instant::now(), watched.stamps());
                    if action != ReloadAction::Nothing {
                        reload(&reloader, watched, action);
                    }
                }
            }
        };
        let thread = std::thread::Builder::new()
            .name("watch".to_owned())
            .spawn(watch)?;
        Ok(Self {
            stop: Some(stop),
            thread: Some(thread),
        })
    }
}

impl Drop for PluginWatcher {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl WatchedFile {
    fn new(plugin: usize, file: PathBuf) -> Self {
        let mut watched = Self {
            plugin,
            modules: imported(&file),
            file,
            handled: None,
            pending: None,
            tried: false,
        };
        watched.handled = watched.stamps();
        watched
    }

    /// Returns the state of the file and its modules. A module that is missing will be missed by the file, too.
    fn stamps(&self) -> Option<Vec<FileStamp>> {
        let file = FileStamp::of(&self.file)?;
        let modules = self.modules.iter().filter_map(|module| FileStamp::of(module));
        Some(std::iter::once(file).chain(modules).collect())
    }

    /// Returns what to do about the file's present state. A missing file is about to be replaced.
    fn check(&mut self, now: Instant, stamps: Option<Vec<FileStamp>>) -> ReloadAction {
        let Some(stamps) = stamps.filter(|stamps| self.handled.as_ref() != Some(stamps)) else {
            self.pending = None;
            return ReloadAction::Nothing;
        };
        match &self.pending {
            Some((pending, since)) if *pending == stamps => {
                let unchanged_for = now.saturating_duration_since(*since);
                if unchanged_for >= INCOMPLETE_TIMEOUT {
                    ReloadAction::TryLast
                } else if unchanged_for >= SETTLE_TIME && !self.tried {
                    self.tried = true;
                    ReloadAction::Try
                } else {
                    ReloadAction::Nothing
                }
            }
            Some(_) | None => {
                self.pending = Some((stamps, now));
                self.tried = false;
                ReloadAction::Nothing
            }
        }
    }

    /// Marks the present state as handled, until the file changes again.
    fn mark_handled(&mut self) {
        if let Some((stamps, _)) = self.pending.take() {
            self.handled = Some(stamps);
            // What is written meanwhile is another state. If it imports others now, their states are, too.
            self.modules = imported(&self.file);
        }
    }
}

fn imported(file: &Path) -> Vec<PathBuf> {
    if python::is_python(file) {
        modules::of(file)
    } else {
        Vec::new()
    }
}

impl FileStamp {
    fn of(file: &Path) -> Option<Self> {
        let metadata = fs::metadata(file).ok()?;
        Some(Self {
            modified: (metadata.mtime(), metadata.mtime_nsec()),
            length: metadata.len(),
            inode: metadata.ino(),
        })
    }
}

/// Reloads a plugin, and logs delays and the notes of a takeover. Events report the rest.
fn reload(reloader: &Reloader, watched: &mut WatchedFile, action: ReloadAction) {
    match reloader.reload_plugin("watch", watched.plugin, ReloadOptions::default()) {
        Err(error) if error.may_be_unfinished() && action == ReloadAction::Try => return,
        Err(error) => reloader.report_failure(watched.plugin, &error),
        Ok(result) => {
            for (schema, outcome) in &result.schemas {
                match outcome {
                    ReloadOutcome::Waiting => {
                        tracing::warn!("{schema} is inside a call and is reloaded when that returns");
                    }
                    ReloadOutcome::Reloaded(takeover) => {
                        for note in &takeover.notes {
                            tracing::warn!("{schema}: {note}");
                        }
                    }
                    ReloadOutcome::Unchanged | ReloadOutcome::Restarted | ReloadOutcome::Undone(_) => {}
                }
            }
        }
    }
    watched.mark_handled();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(length: u64) -> Option<Vec<FileStamp>> {
        Some(vec![FileStamp {
            modified: (1, 2),
            length,
            inode: 3,
        }])
    }

    fn watched() -> WatchedFile {
        WatchedFile {
            plugin: 0,
            file: PathBuf::from("libvff.so"),
            modules: Vec::new(),
            handled: stamp(100),
            pending: None,
            tried: false,
        }
    }

    #[test]
    fn an_unchanged_file_needs_no_reload() {
        let (mut watched, start) = (watched(), Instant::now());
        for ms in 0..10_000 {
            let now = start + Duration::from_millis(ms);
            assert_eq!(watched.check(now, stamp(100)), ReloadAction::Nothing);
        }
    }

    #[test]
    fn a_new_file_is_loaded_once_when_it_stops_changing() {
        let (mut watched, start) = (watched(), Instant::now());
        let mut tried = Vec::new();
        for ms in 0..1900 {
            // The file grows for 500 ms.
            let now = start + Duration::from_millis(ms);
            if watched.check(now, stamp(100 + ms.clamp(1, 500))) == ReloadAction::Try {
                tried.push(ms);
            }
        }
        assert_eq!(tried, [500 + 200]);
        watched.mark_handled();
        let later = start + Duration::from_secs(100);
        assert_eq!(watched.check(later, stamp(600)), ReloadAction::Nothing);
    }

    #[test]
    fn a_file_that_is_missing_for_a_moment_is_waited_for() {
        let (mut watched, start) = (watched(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        assert_eq!(watched.check(at(0), stamp(200)), ReloadAction::Nothing);
        assert_eq!(watched.check(at(100), None), ReloadAction::Nothing);
        assert_eq!(watched.check(at(300), stamp(200)), ReloadAction::Nothing);
        assert_eq!(watched.check(at(499), stamp(200)), ReloadAction::Nothing);
        assert_eq!(watched.check(at(500), stamp(200)), ReloadAction::Try);
    }

    #[test]
    fn a_file_that_stays_incomplete_is_reported() {
        let (mut watched, start) = (watched(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        assert_eq!(watched.check(at(0), stamp(50)), ReloadAction::Nothing);
        assert_eq!(watched.check(at(200), stamp(50)), ReloadAction::Try);
        assert_eq!(watched.check(at(1999), stamp(50)), ReloadAction::Nothing);
        assert_eq!(watched.check(at(2000), stamp(50)), ReloadAction::TryLast);
    }

    #[test]
    fn a_module_beside_a_file_of_python_is_watched_with_it() {
        let folder = tempfile::tempdir().unwrap();
        let [file, module] = ["hog.py", "helper.py"].map(|name| folder.path().join(name));
        fs::write(&file, "import helper\n").unwrap();
        fs::write(&module, "x = 1\n").unwrap();
        let mut watched = WatchedFile::new(0, file);
        let stamps = watched.stamps();
        fs::write(&module, "x = 10\n").unwrap();
        assert_ne!(watched.stamps(), stamps);
        let start = Instant::now();
        watched.check(start, watched.stamps());
        let later = start + SETTLE_TIME;
        assert_eq!(watched.check(later, watched.stamps()), ReloadAction::Try);
    }

    #[test]
    fn file_stamps_differ_when_the_file_changes() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("libx.so");
        assert_eq!(FileStamp::of(&file), None);
        fs::write(&file, "one").unwrap();
        let one = FileStamp::of(&file);
        assert!(one.is_some());
        fs::write(folder.path().join("other"), "two").unwrap();
        fs::rename(folder.path().join("other"), &file).unwrap();
        assert_ne!(FileStamp::of(&file), one);
    }
}
