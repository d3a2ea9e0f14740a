//! What this process itself does. A schema that received what its own application commands would command it again, without
//! end; and another session of this process is no other program. A schema with a process of its own is not known here.

use std::collections::{BTreeSet, VecDeque};

use parking_lot::Mutex;

use crate::attachment::Gid;

/// The number of sessions that are remembered. The tokens of one that has ended may be seen for some seconds.
const MAX_SESSIONS: usize = 256;

static PUBLICATIONS: Mutex<BTreeSet<Gid>> = Mutex::new(BTreeSet::new());
static OPENED: Mutex<VecDeque<String>> = Mutex::new(VecDeque::new());

/// A publication whose messages command a robot, until it is dropped.
#[derive(Debug)]
pub(crate) struct OwnCommands(Gid);

impl OwnCommands {
    pub(crate) fn of(publication: Gid) -> Self {
        PUBLICATIONS.lock().insert(publication);
        Self(publication)
    }

    /// Whether a publication is one of this process.
    pub(crate) fn contain(publication: Gid) -> bool {
        PUBLICATIONS.lock().contains(&publication)
    }
}

impl Drop for OwnCommands {
    fn drop(&mut self) {
        PUBLICATIONS.lock().remove(&self.0);
    }
}

/// Remembers a session of this process by its identifier.
pub(crate) fn remember_session(id: String) {
    let mut opened = OPENED.lock();
    if opened.len() >= MAX_SESSIONS {
        opened.pop_front();
    }
    opened.push_back(id);
}

/// Whether a session is one of this process.
pub(crate) fn is_own_session(id: &str) -> bool {
    OPENED.lock().iter().any(|own| own == id)
}
