//! Asks the disk to have what the system was given. It may take its time, so it has a thread of its own.

use std::fs::File;
use std::io;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

pub(super) struct Syncer {
    ask: Option<SyncSender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Syncer {
    pub(super) fn start(file: File) -> io::Result<Self> {
        let (ask, asked) = sync_channel(1);
        let thread = Builder::new().name("recording-sync".to_owned()).spawn(move || {
            while asked.recv().is_ok() {
                // What the disk cannot do the next write is told of.
                let _ = file.sync_data();
            }
        })?;
        Ok(Self {
            ask: Some(ask),
            thread: Some(thread),
        })
    }

    /// Asks for it, unless it has been asked for and not begun.
    pub(super) fn ask(&self) {
        if let Some(ask) = &self.ask {
            let _ = ask.try_send(());
        }
    }
}

/// Waits until the disk has what it was asked to have.
impl Drop for Syncer {
    fn drop(&mut self) {
        drop(self.ask.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
