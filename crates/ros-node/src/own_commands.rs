//! The publications of this process whose messages command a robot. A schema that received what its own application commands
//! would command it again, without end.

use std::collections::BTreeSet;
use std::sync::Mutex;

use crate::attachment::Gid;
use crate::shared::lock;

static PUBLICATIONS: Mutex<BTreeSet<Gid>> = Mutex::new(BTreeSet::new());

/// A publication, until it is dropped.
#[derive(Debug)]
pub(crate) struct OwnCommands(Gid);

impl OwnCommands {
    pub(crate) fn of(publication: Gid) -> Self {
        lock(&PUBLICATIONS).insert(publication);
        Self(publication)
    }

    /// Whether a publication is one of this process.
    pub(crate) fn contain(publication: Gid) -> bool {
        lock(&PUBLICATIONS).contains(&publication)
    }
}

impl Drop for OwnCommands {
    fn drop(&mut self) {
        lock(&PUBLICATIONS).remove(&self.0);
    }
}
