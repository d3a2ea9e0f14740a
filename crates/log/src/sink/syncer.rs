//! Asks the disk to have what the system was given, and keeps what it answers. It may take its time, so it has a thread of its own.
//! The system tells of a failed write once, to whoever asks next; nobody may ask without hearing it.

use std::fs::File;
use std::io::{self, ErrorKind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{Builder, JoinHandle};

use crate::lane::lock;

/// Returns once the disk has all that the system was given of a file.
pub(crate) type Disk = Box<dyn FnMut() -> io::Result<()> + Send>;

pub(super) struct Syncer {
    ask: Option<SyncSender<()>>,
    thread: Option<JoinHandle<()>>,
    state: Arc<State>,
}

#[derive(Default)]
struct State {
    /// Messages that the file has.
    given: AtomicU64,
    /// Messages that the disk has.
    safe: AtomicU64,
    failed: Mutex<Option<io::Error>>,
}

impl Syncer {
    pub(super) fn start(mut disk: Disk) -> io::Result<Self> {
        let (ask, asked) = sync_channel(1);
        let state = Arc::new(State::default());
        let told = Arc::clone(&state);
        let thread = Builder::new().name("recording-sync".to_owned()).spawn(move || {
            while asked.recv().is_ok() {
                let given = told.given.load(Ordering::Acquire);
                if let Err(error) = disk() {
                    // Asked again it may say that all is well: what is lost stays lost.
                    *lock(&told.failed) = Some(error);
                    return;
                }
                told.safe.store(given, Ordering::Release);
            }
        })?;
        Ok(Self {
            ask: Some(ask),
            thread: Some(thread),
            state,
        })
    }

    /// Asks for it, now that the file has so many messages, unless it has been asked for and not begun.
    pub(super) fn ask(&self, given: u64) {
        self.state.given.store(given, Ordering::Release);
        if let Some(ask) = &self.ask {
            let _ = ask.try_send(());
        }
    }

    /// What the disk has said since the last call.
    ///
    /// # Errors
    /// It does not have all that it was asked to have.
    pub(super) fn check(&self) -> io::Result<()> {
        lock(&self.state.failed).take().map_or(Ok(()), Err)
    }

    /// Messages that the disk has said to have.
    pub(super) fn safe(&self) -> u64 {
        self.state.safe.load(Ordering::Acquire)
    }

    /// Nothing more is asked for.
    pub(super) fn close(&mut self) {
        drop(self.ask.take());
    }

    /// Whether the disk has answered to all that was asked before [`Self::close`].
    pub(super) fn is_done(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits until it has.
    pub(super) fn wait(&mut self) {
        self.close();
        if let Some(thread) = self.thread.take() {
            // It cannot panic but in the disk's own call, which a hook has told.
            let _ = thread.join();
        }
    }
}

impl Drop for Syncer {
    fn drop(&mut self) {
        self.wait();
    }
}

/// The disk of a file; a pipe or a device has none.
///
/// # Errors
/// The system refuses another handle on it.
pub(crate) fn disk(file: &File) -> io::Result<Option<Disk>> {
    if !file.metadata()?.is_file() {
        return Ok(None);
    }
    let file = file.try_clone()?;
    Ok(Some(Box::new(move || match file.sync_data() {
        // A file system that cannot be asked has not failed.
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        answer => answer,
    })))
}
