//! Repeats something after every change of files. It compares times and lengths of the files, which works on
//! every file system.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, SystemTime};

use jde_terminal::{self as terminal, FAINT};

/// The time between two looks at the files.
const INTERVAL: Duration = Duration::from_millis(200);

/// What tells a file from its next version; `None` while it does not exist.
type Stamp = Option<(SystemTime, u64)>;

/// Calls `run`, and again after every change of one of the files that it returned, until `stop` is set.
///
/// # Errors
/// Standard error cannot be written.
pub(super) fn until(stop: &AtomicBool, mut run: impl FnMut() -> BTreeSet<PathBuf>) -> io::Result<()> {
    while !stop.load(Ordering::Relaxed) {
        let before = SystemTime::now();
        let files = run();
        let handled = stamps(&files);
        // A file that changed during the run may have been read before that.
        let is_newer = |stamp: &Stamp| stamp.is_some_and(|(modified, _)| modified > before);
        if handled.values().any(is_newer) {
            settle(&files, stop);
            continue;
        }
        if !stop.load(Ordering::Relaxed) {
            writeln!(
                terminal::err(),
                "{FAINT}waiting for a change; Ctrl-C ends{FAINT:#}"
            )?;
        }
        while stamps(&files) == handled && !stop.load(Ordering::Relaxed) {
            thread::sleep(INTERVAL);
        }
        settle(&files, stop);
    }
    Ok(())
}

/// Waits until nothing changes any more: compilers and editors write in several steps.
fn settle(files: &BTreeSet<PathBuf>, stop: &AtomicBool) {
    let mut last = stamps(files);
    loop {
        thread::sleep(INTERVAL);
        let now = stamps(files);
        if now == last && now.values().all(Option::is_some) || stop.load(Ordering::Relaxed) {
            return;
        }
        last = now;
    }
}

fn stamps(files: &BTreeSet<PathBuf>) -> BTreeMap<PathBuf, Stamp> {
    let stamp = |file: &PathBuf| {
        let data = fs::metadata(file).ok()?;
        Some((data.modified().ok()?, data.len()))
    };
    files.iter().map(|file| (file.clone(), stamp(file))).collect()
}
