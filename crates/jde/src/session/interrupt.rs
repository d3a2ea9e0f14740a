//! Ctrl-C, and other ways in which a process is asked to end: the first stops the application, the second ends at once.

use std::io;
use std::thread::JoinHandle;

use jde_host::Handle;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::{self, Signals};
use signal_hook::low_level;

/// What a shell adds to the number of the signal that ended a process.
const BY_SIGNAL: i32 = 128;

/// Listens to signals while it lives.
pub(crate) struct Interrupts {
    signals: iterator::Handle,
    thread: Option<JoinHandle<()>>,
}

impl Interrupts {
    /// Stops this application at the first signal: actuators first, then everything in order.
    ///
    /// # Errors
    /// The system refuses to tell of signals.
    pub(crate) fn stop(application: Handle) -> io::Result<Self> {
        let mut listener = Signals::new([SIGINT, SIGTERM, SIGHUP])?;
        let signals = listener.handle();
        let thread = std::thread::Builder::new()
            .name("signals".to_owned())
            .spawn(move || {
                let mut before = false;
                for signal in listener.forever() {
                    if std::mem::replace(&mut before, true) {
                        low_level::exit(BY_SIGNAL + signal);
                    }
                    application.stop();
                }
            })?;
        Ok(Self {
            signals,
            thread: Some(thread),
        })
    }
}

impl Drop for Interrupts {
    fn drop(&mut self) {
        self.signals.close();
        if let Some(thread) = self.thread.take() {
            // It does nothing that panics.
            let _ = thread.join();
        }
    }
}
