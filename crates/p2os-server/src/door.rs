//! Who has a pseudo-terminal open, by what the system tells of its path. A terminal tells its master only
//! that nobody has it open any more, and not even that if the next one is there at once.

use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;

use rustix::fs::inotify::{self, CreateFlags, ReadFlags, WatchFlags};

/// Room for what the system tells at once, bytes; the rest comes at the next look.
const TOLD: usize = 1024;

/// The door of a terminal.
pub(crate) struct Door {
    /// None where the system does not tell: then silence has to.
    told: Option<OwnedFd>,
    /// How many have it open, besides those that had before.
    here: u32,
}

impl Door {
    /// From now on.
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

    /// What to wait for.
    pub(crate) fn wakes(&self) -> Option<BorrowedFd<'_>> {
        self.told.as_ref().map(AsFd::as_fd)
    }

    /// Whether since the last look there was a moment in which the last of them had left.
    pub(crate) fn look(&mut self) -> bool {
        let Some(told) = &self.told else {
            return false;
        };
        let mut room = [MaybeUninit::uninit(); TOLD];
        let mut events = inotify::Reader::new(told, &mut room);
        let mut left = false;
        // It ends with the system's word that there is no more.
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

    /// Whether nobody has it open, where that is known.
    pub(crate) fn nobody(&self) -> bool {
        self.told.is_some() && self.here == 0
    }
}
