//! Searches for running applications and for recordings, on its own thread. It opens none.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use eframe::egui;
use jde_link::message::About;
use jde_link::{Client, Reach};
use parking_lot::{Mutex, MutexGuard};

use super::present::Present;

/// Pause between two searches.
const SEARCH_INTERVAL: Duration = Duration::from_secs(1);
/// Maximum number of recordings listed, the newest first.
const MAX_RECORDINGS: usize = 200;

/// A search that repeats once a second until dropped.
pub(crate) struct Discovery(Arc<Mutex<Discovered>>);

/// The result of the last search.
#[derive(Default)]
pub(crate) struct Discovered {
    pub(super) searched: bool,
    pub(crate) running: Vec<About>,
    pub(super) recordings: Vec<RecordingFile>,
    pub(super) trouble: Option<String>,
    /// How each application stands, by its id, once it has answered.
    pub(super) present: HashMap<String, Present>,
}

/// A recording.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RecordingFile {
    pub(super) path: PathBuf,
    pub(super) bytes: u64,
    pub(super) written: SystemTime,
}

impl Discovered {
    /// Whether a search found something else. How applications stand is reported by whoever watches them.
    fn is_other(&self, new: &Self) -> bool {
        (self.searched, &self.running, &self.recordings, &self.trouble)
            != (new.searched, &new.running, &new.recordings, &new.trouble)
    }
}

impl Discovery {
    /// Starts to search for applications within `reach`, and for recordings in `folders`.
    pub(crate) fn new(ctx: &egui::Context, reach: &Reach, folders: &[PathBuf]) -> Self {
        let seen = Arc::new(Mutex::new(Discovered::default()));
        let (results, reach, folders) = (Arc::downgrade(&seen), reach.clone(), folders.to_vec());
        let repaint = ctx.clone();
        let worker = move || poll(&results, &reach, &folders, &repaint);
        if let Err(error) = thread::Builder::new().name("view-start".to_owned()).spawn(worker) {
            seen.lock().trouble = Some(format!("no thread for the search: {error}"));
        }
        Self(seen)
    }

    /// The result of the last search. The search thread waits for the lock while it is held.
    pub(crate) fn seen(&self) -> MutexGuard<'_, Discovered> {
        self.0.lock()
    }
}

/// Searches once a second until the result is no longer held.
fn poll(results: &Weak<Mutex<Discovered>>, reach: &Reach, folders: &[PathBuf], repaint: &egui::Context) {
    // Who asks each application, by its id.
    let mut watched: HashMap<String, JoinHandle<()>> = HashMap::new();
    loop {
        let found = Client::connect(reach).and_then(|client| {
            let running = client.applications()?;
            let unanswered = client.unanswered().into_iter().map(|one| one.reason);
            Ok((running, unanswered.collect::<Vec<_>>().join("; ")))
        });
        let recordings = files(folders);
        let Some(seen) = results.upgrade() else { return };
        // Who asked has lost the connection: what it said is old, and the application is asked again if it still runs.
        watched.retain(|id, watcher| {
            let has_ended = watcher.is_finished();
            if has_ended && seen.lock().present.remove(id).is_some() {
                repaint.request_repaint();
            }
            !has_ended
        });
        let running = found.iter().flat_map(|(running, _)| running);
        for about in running.filter(|about| about.executor != "replay") {
            if let Entry::Vacant(place) = watched.entry(about.id.clone())
                && let Some(watcher) = watch(results, reach, about, repaint)
            {
                place.insert(watcher);
            }
        }
        {
            let mut seen = seen.lock();
            let (running, trouble) = match found {
                Ok((running, trouble)) => (running, Some(trouble).filter(|trouble| !trouble.is_empty())),
                Err(error) => (Vec::new(), Some(error.to_string())),
            };
            let now = Discovered {
                searched: true,
                running,
                recordings,
                trouble,
                present: std::mem::take(&mut seen.present),
            };
            let is_new = seen.is_other(&now);
            *seen = now;
            if is_new {
                repaint.request_repaint();
            }
        }
        drop(seen);
        thread::sleep(SEARCH_INTERVAL);
    }
}

/// Asks an application once a second how it stands, on a thread of its own, so that one that hangs delays no other. The
/// thread ends with the connection.
fn watch(
    results: &Weak<Mutex<Discovered>>,
    reach: &Reach,
    about: &About,
    repaint: &egui::Context,
) -> Option<JoinHandle<()>> {
    let (results, reach, repaint) = (results.clone(), reach.clone(), repaint.clone());
    let name = format!("{}@{}", about.name, about.id);
    let worker = move || {
        let Ok(remote) = Client::connect(&reach).and_then(|client| client.application(Some(&name))) else {
            return;
        };
        while remote.is_alive() {
            let present = Present::of(&remote);
            let Some(seen) = results.upgrade() else { return };
            seen.lock().present.insert(remote.about().id.clone(), present);
            repaint.request_repaint();
            drop(seen);
            thread::sleep(SEARCH_INTERVAL);
        }
    };
    thread::Builder::new()
        .name("view-present".to_owned())
        .spawn(worker)
        .inspect_err(|error| tracing::error!("no thread to ask an application: {error}"))
        .ok()
}

/// The recordings in `folders`, the newest first, at most [`MAX_RECORDINGS`].
fn files(folders: &[PathBuf]) -> Vec<RecordingFile> {
    let mut files: Vec<RecordingFile> = folders.iter().flat_map(|folder| in_folder(folder)).collect();
    files.sort_by_key(|file| std::cmp::Reverse(file.written));
    files.truncate(MAX_RECORDINGS);
    files
}

fn in_folder(folder: &Path) -> Vec<RecordingFile> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    entries
        .filter_map(|entry| {
            let entry = entry.ok()?;
            let path = entry.path();
            let about = entry.metadata().ok()?;
            (path.extension()? == "mcap" && about.is_file()).then(|| RecordingFile {
                path,
                bytes: about.len(),
                written: about.modified().unwrap_or(UNIX_EPOCH),
            })
        })
        .collect()
}
