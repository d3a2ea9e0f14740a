//! Synchronises a file with the disk, and keeps the results. The disk may be slow, so this has a thread of
//! its own. The system reports a failed write only once, to the next caller, so every result must be kept.

use std::fs::File;
use std::io::{self, ErrorKind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use parking_lot::Mutex;

/// Returns once the disk has stored everything that the system has of a file.
pub(crate) type Disk = Box<dyn FnMut() -> io::Result<()> + Send>;

pub(super) struct Syncer {
    requests: Option<SyncSender<()>>,
    thread: Option<JoinHandle<()>>,
    state: Arc<SyncState>,
}

#[derive(Default)]
struct SyncState {
    /// The number of messages in the file.
    submitted: AtomicU64,
    /// The number of messages that the disk has stored.
    synced: AtomicU64,
    failed: Mutex<Option<io::Error>>,
}

impl Syncer {
    pub(super) fn start(mut disk: Disk) -> io::Result<Self> {
        let (sender, requests) = sync_channel(1);
        let state = Arc::new(SyncState::default());
        let shared = Arc::clone(&state);
        let thread = Builder::new().name("recording-sync".to_owned()).spawn(move || {
            while requests.recv().is_ok() {
                let submitted = shared.submitted.load(Ordering::Acquire);
                if let Err(error) = disk() {
                    // There is no second call: it might succeed although the data are lost.
                    *shared.failed.lock() = Some(error);
                    return;
                }
                shared.synced.store(submitted, Ordering::Release);
            }
        })?;
        Ok(Self {
            requests: Some(sender),
            thread: Some(thread),
            state,
        })
    }

    /// Requests a synchronisation, now that the file has `submitted` messages. A request that has not been
    /// started yet is not repeated.
    pub(super) fn request(&self, submitted: u64) {
        self.state.submitted.store(submitted, Ordering::Release);
        if let Some(requests) = &self.requests {
            let _ = requests.try_send(());
        }
    }

    /// Returns the result of the disk since the last call.
    ///
    /// # Errors
    /// The disk has not stored everything that it should have.
    pub(super) fn check(&self) -> io::Result<()> {
        self.state.failed.lock().take().map_or(Ok(()), Err)
    }

    /// Returns the number of messages that the disk has stored.
    pub(super) fn synced(&self) -> u64 {
        self.state.synced.load(Ordering::Acquire)
    }

    /// Ends the requests.
    pub(super) fn close(&mut self) {
        drop(self.requests.take());
    }

    /// Returns whether the disk has finished all requests from before [`Self::close`].
    pub(super) fn is_done(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Closes, and waits until all requests are finished.
    pub(super) fn wait(&mut self) {
        self.close();
        if let Some(thread) = self.thread.take() {
            // It panics only in the call of the disk, which the panic hook has reported.
            let _ = thread.join();
        }
    }
}

impl Drop for Syncer {
    fn drop(&mut self) {
        self.wait();
    }
}

/// Returns the disk of a file. A pipe or a device has none.
///
/// # Errors
/// The system refuses a second handle of the file.
pub(crate) fn disk(file: &File) -> io::Result<Option<Disk>> {
    if !file.metadata()?.is_file() {
        return Ok(None);
    }
    let file = file.try_clone()?;
    Ok(Some(Box::new(move || match file.sync_data() {
        // A file system without synchronisation has not failed.
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        result => result,
    })))
}
