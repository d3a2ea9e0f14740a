//! Counts the programs that have a pseudo-terminal open, by inotify events of its path. The terminal itself
//! reports to its master only that the last program has closed it, and not even that if the next one opens it
//! at once.

use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;

use rustix::fs::inotify::{self, CreateFlags, ReadFlags, WatchFlags};

/// Bytes of events that one read takes; the next update reads the rest.
const EVENT_BYTES: usize = 1024;

/// The watch on a terminal.
pub(crate) struct TerminalWatch {
    /// `None` if inotify is not available. A client's departure then shows only by its silence.
    inotify: Option<OwnedFd>,
    /// How many programs have it open, besides those that had it open before the watch.
    open_count: u32,
}

impl TerminalWatch {
    /// Starts to watch a path.
    pub(crate) fn of(path: &Path) -> Self {
        let inotify = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC).and_then(|inotify| {
            let events = WatchFlags::OPEN | WatchFlags::CLOSE_WRITE | WatchFlags::CLOSE_NOWRITE;
            inotify::add_watch(&inotify, path, events).map(|_| inotify)
        });
        Self {
            inotify: inotify.ok(),
            open_count: 0,
        }
    }

    /// Returns the descriptor to poll.
    pub(crate) fn poll_fd(&self) -> Option<BorrowedFd<'_>> {
        self.inotify.as_ref().map(AsFd::as_fd)
    }

    /// Reads the events. Returns whether the last program closed the terminal since the last update.
    pub(crate) fn update(&mut self) -> bool {
        let Some(inotify) = &self.inotify else {
            return false;
        };
        let mut buffer = [MaybeUninit::uninit(); EVENT_BYTES];
        let mut events = inotify::Reader::new(inotify, &mut buffer);
        let mut was_closed = false;
        // `next` fails when there are no more events.
        while let Ok(event) = events.next() {
            let flags = event.events();
            if flags.contains(ReadFlags::OPEN) {
                self.open_count += 1;
            } else if flags.intersects(ReadFlags::CLOSE_WRITE | ReadFlags::CLOSE_NOWRITE) {
                self.open_count = self.open_count.saturating_sub(1);
                was_closed |= self.open_count == 0;
            }
        }
        was_closed
    }

    /// Returns whether no program has it open; false if that is unknown.
    pub(crate) fn is_unused(&self) -> bool {
        self.inotify.is_some() && self.open_count == 0
    }
}
