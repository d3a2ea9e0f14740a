//! Counts the programs that have a pseudo-terminal open, by inotify events of its path. The terminal itself
//! reports to its master only that the last program has closed it, and not even that if the next one opens it
//! at once.

use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;

use rustix::fs::inotify::{self, CreateFlags, ReadFlags, WatchFlags};

/// Bytes of events that one read takes; the next look reads the rest.
const TOLD: usize = 1024;

/// The watch on a terminal.
pub(crate) struct Door {
    /// `None` if inotify is not available. A client's departure then shows only by its silence.
    told: Option<OwnedFd>,
    /// How many programs have it open, besides those that had it open before the watch.
    here: u32,
}

impl Door {
    /// Starts to watch a path.
    pub(crate) fn of(path: &Path) -> Self {
        let told = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC).and_then(|told| {
            let wanted = WatchFlags::OPEN | WatchFlags::CLOSE_WRITE | WatchFlags::CLOSE_NOWRITE;
            inotify::add_watch(&told, path, wanted).map(|_| told)
        });
        Self {
            told: told.ok(),
            here: 0,
        }
    }

    /// Returns the descriptor to poll.
    pub(crate) fn wakes(&self) -> Option<BorrowedFd<'_>> {
        self.told.as_ref().map(AsFd::as_fd)
    }

    /// Reads the events. Returns whether the last program closed the terminal since the last look.
    pub(crate) fn look(&mut self) -> bool {
        let Some(told) = &self.told else {
            return false;
        };
        let mut room = [MaybeUninit::uninit(); TOLD];
        let mut events = inotify::Reader::new(told, &mut room);
        let mut left = false;
        // `next` fails when there are no more events.
        while let Ok(event) = events.next() {
            let happened = event.events();
            if happened.contains(ReadFlags::OPEN) {
                self.here += 1;
            } else if happened.intersects(ReadFlags::CLOSE_WRITE | ReadFlags::CLOSE_NOWRITE) {
                self.here = self.here.saturating_sub(1);
                left |= self.here == 0;
            }
        }
        left
    }

    /// Returns whether no program has it open; false if that is unknown.
    pub(crate) fn nobody(&self) -> bool {
        self.told.is_some() && self.here == 0
    }
}
