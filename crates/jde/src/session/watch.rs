//! `jde run --watch`: watches the files of an application's plugins, and reloads every complete new build.
//!
//! It compares times, sizes and inode numbers ten times a second instead of using notifications of the kernel.
//! This works on every file system and needs no library, at ten calls of `stat` a second for each plugin.
//! Files that a linker has not finished are left alone.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_host::Handle;
use jde_host::plugin::Plugins;
use jde_host::reload::{Became, How, Reloader};

/// Time between two looks at the files.
const EVERY: Duration = Duration::from_millis(100);
/// How long a file must stay unchanged to count as written. Linkers write in many steps, and copies of large
/// files arrive in parts.
const STILL: Duration = Duration::from_millis(200);
/// How long a file that is not a complete library may stay unchanged before that is reported.
const BROKEN: Duration = Duration::from_secs(2);

/// Watches until it is dropped.
pub(super) struct Watch {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// A watched file.
struct Watched {
    plugin: String,
    file: PathBuf,
    /// Its state when it was last handled.
    known: Option<Stamp>,
    /// Its new state, and since when.
    seen: Option<(Stamp, Instant)>,
    tried: bool,
}

/// The state of a file, as far as needed to detect changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp {
    modified: (i64, i64),
    length: u64,
    inode: u64,
}

/// What to do about a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Due {
    Nothing,
    /// The file appears to be complete: try to load it.
    Try,
    /// The file has stayed unchanged for long: try to load it, and report why if that fails.
    TryLast,
}

impl Watch {
    /// Watches the plugins of an application on a new thread.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub(super) fn begin(handle: Handle, plugins: Arc<Plugins>) -> std::io::Result<Self> {
        let reloader = Reloader::new(handle, plugins);
        let files = reloader.files().into_iter();
        let mut files: Vec<_> = files.map(|(plugin, file)| Watched::new(plugin, file)).collect();
        let (stop, stopped) = channel();
        let watch = move || {
            while let Err(RecvTimeoutError::Timeout) = stopped.recv_timeout(EVERY) {
                for watched in &mut files {
                    let due = watched.look(Instant::now(), Stamp::of(&watched.file));
                    if due != Due::Nothing {
                        reload(&reloader, watched, due);
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

impl Drop for Watch {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Watched {
    fn new(plugin: String, file: PathBuf) -> Self {
        Self {
            known: Stamp::of(&file),
            plugin,
            file,
            seen: None,
            tried: false,
        }
    }

    /// Returns what to do about the file's present state. A missing file is about to be replaced.
    fn look(&mut self, now: Instant, stamp: Option<Stamp>) -> Due {
        let Some(stamp) = stamp else {
            self.seen = None;
            return Due::Nothing;
        };
        if self.known == Some(stamp) {
            self.seen = None;
            return Due::Nothing;
        }
        match self.seen {
            Some((seen, since)) if seen == stamp => {
                let still = now.saturating_duration_since(since);
                if still >= BROKEN {
                    Due::TryLast
                } else if still >= STILL && !self.tried {
                    self.tried = true;
                    Due::Try
                } else {
                    Due::Nothing
                }
            }
            Some(_) | None => {
                self.seen = Some((stamp, now));
                self.tried = false;
                Due::Nothing
            }
        }
    }

    /// Marks the present state as handled, until the file changes again.
    fn deal_with(&mut self) {
        if let Some((stamp, _)) = self.seen.take() {
            self.known = Some(stamp);
        }
    }
}

impl Stamp {
    fn of(file: &Path) -> Option<Self> {
        let about = fs::metadata(file).ok()?;
        Some(Self {
            modified: (about.mtime(), about.mtime_nsec()),
            length: about.len(),
            inode: about.ino(),
        })
    }
}

/// Reloads a plugin, and logs refusals, delays and the notes of a takeover. Events report the rest.
fn reload(reloader: &Reloader, watched: &mut Watched, due: Due) {
    match reloader.reload("watch", &watched.plugin, How::default()) {
        Err(refused) if refused.may_be_unfinished() && due == Due::Try => return,
        Err(refused) => tracing::warn!("{refused}"),
        Ok(reloaded) => {
            for (schema, became) in &reloaded.schemas {
                match became {
                    Became::Waiting => {
                        tracing::warn!("{schema} is inside a call and is reloaded when that returns");
                    }
                    Became::Reloaded(takeover) => {
                        for note in &takeover.notes {
                            tracing::warn!("{schema}: {note}");
                        }
                    }
                    Became::Unchanged | Became::Restarted | Became::Undone(_) => {}
                }
            }
        }
    }
    watched.deal_with();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(length: u64) -> Option<Stamp> {
        Some(Stamp {
            modified: (1, 2),
            length,
            inode: 3,
        })
    }

    fn watched() -> Watched {
        Watched {
            plugin: "vff".to_owned(),
            file: PathBuf::from("libvff.so"),
            known: stamp(100),
            seen: None,
            tried: false,
        }
    }

    #[test]
    fn a_file_that_stays_as_it_is_calls_for_nothing() {
        let (mut watched, start) = (watched(), Instant::now());
        for ms in 0..10_000 {
            let now = start + Duration::from_millis(ms);
            assert_eq!(watched.look(now, stamp(100)), Due::Nothing);
        }
    }

    #[test]
    fn a_new_file_is_tried_once_it_is_still_and_only_once() {
        let (mut watched, start) = (watched(), Instant::now());
        let mut tried = Vec::new();
        for ms in 0..1900 {
            // The file grows for 500 ms.
            let now = start + Duration::from_millis(ms);
            if watched.look(now, stamp(100 + ms.clamp(1, 500))) == Due::Try {
                tried.push(ms);
            }
        }
        assert_eq!(tried, [500 + 200]);
        watched.deal_with();
        let later = start + Duration::from_secs(100);
        assert_eq!(watched.look(later, stamp(600)), Due::Nothing);
    }

    #[test]
    fn a_file_that_is_away_for_a_moment_is_waited_for() {
        let (mut watched, start) = (watched(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        assert_eq!(watched.look(at(0), stamp(200)), Due::Nothing);
        assert_eq!(watched.look(at(100), None), Due::Nothing);
        assert_eq!(watched.look(at(300), stamp(200)), Due::Nothing);
        assert_eq!(watched.look(at(499), stamp(200)), Due::Nothing);
        assert_eq!(watched.look(at(500), stamp(200)), Due::Try);
    }

    #[test]
    fn what_stays_half_written_is_told_in_the_end() {
        let (mut watched, start) = (watched(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        assert_eq!(watched.look(at(0), stamp(50)), Due::Nothing);
        assert_eq!(watched.look(at(200), stamp(50)), Due::Try);
        assert_eq!(watched.look(at(1999), stamp(50)), Due::Nothing);
        assert_eq!(watched.look(at(2000), stamp(50)), Due::TryLast);
    }

    #[test]
    fn one_state_of_a_file_differs_from_another() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("libx.so");
        assert_eq!(Stamp::of(&file), None);
        fs::write(&file, "one").unwrap();
        let one = Stamp::of(&file);
        assert!(one.is_some());
        fs::write(folder.path().join("other"), "two").unwrap();
        fs::rename(folder.path().join("other"), &file).unwrap();
        assert_ne!(Stamp::of(&file), one);
    }
}
