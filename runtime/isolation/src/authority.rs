//! Which instances have authority (R7), in memory that children read and the host alone writes. So a child
//! knows the outcome of a command without a request. The host still refuses the command of an instance that
//! has lost its authority when the command arrives.

#![allow(unsafe_code)]

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::atomic::{AtomicU32, Ordering};

use jde_board::{Mapping, Shared};
use jde_core::{Id, SchemaId};

/// The table of an application, as the host writes it.
pub struct AuthorityTable {
    shared: Shared,
    flags: Mapping,
    instances: usize,
}

/// The flag of one instance, as its child reads it.
pub(crate) struct AuthorityFlag {
    flags: Mapping,
    instance: SchemaId,
}

impl AuthorityTable {
    /// Returns a table in which no instance has authority.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn new(instances: usize) -> io::Result<Self> {
        let shared = Shared::zeroed(instances * size_of::<AtomicU32>())?;
        let flags = Mapping::new(shared.writable_file()?.as_fd(), shared.extent(), true)?;
        Ok(Self {
            shared,
            flags,
            instances,
        })
    }

    /// Records whether an instance has authority.
    pub fn set(&self, instance: SchemaId, has_authority: bool) {
        if let Some(flag) = flag(&self.flags, instance) {
            flag.store(u32::from(has_authority), Ordering::Release);
        }
    }

    /// Withdraws the authority of all instances.
    pub fn clear(&self) {
        (0..self.instances).for_each(|index| self.set(SchemaId::new(index), false));
    }

    /// Returns a file for a child, which can only read it.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn file(&self) -> io::Result<OwnedFd> {
        self.shared.readable_file()
    }
}

impl AuthorityFlag {
    /// Maps the table from the host's file.
    pub(crate) fn open(file: &OwnedFd, instance: SchemaId) -> io::Result<Self> {
        let bytes = (instance.index() + 1) * size_of::<AtomicU32>();
        let flags = Mapping::new(file.as_fd(), (0, bytes), false)?;
        Ok(Self { flags, instance })
    }

    /// Whether the instance has authority at this instant.
    pub(crate) fn is_set(&self) -> bool {
        flag(&self.flags, self.instance).is_some_and(|flag| flag.load(Ordering::Acquire) != 0)
    }
}

fn flag(flags: &Mapping, instance: SchemaId) -> Option<&AtomicU32> {
    let address = flags.at(instance.index() * size_of::<AtomicU32>(), size_of::<AtomicU32>())?;
    // SAFETY: inside of the mapping, which lives as long as the result, and aligned. All its users are atomic.
    Some(unsafe { AtomicU32::from_ptr(address.cast()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_child_reads_its_own_flag_and_cannot_write_it() {
        let table = AuthorityTable::new(3).expect("a table");
        let file = table.file().expect("a file");
        let flags = [0, 1, 2].map(|instance| AuthorityFlag::open(&file, SchemaId(instance)).expect("a flag"));
        table.set(SchemaId(1), true);
        assert_eq!(flags.each_ref().map(AuthorityFlag::is_set), [false, true, false]);
        table.set(SchemaId(2), true);
        table.set(SchemaId(1), false);
        assert_eq!(flags.each_ref().map(AuthorityFlag::is_set), [false, false, true]);
        table.clear();
        assert!(!flags[2].is_set());
        assert!(Mapping::new(file.as_fd(), (0, 4), true).is_err());
    }
}
