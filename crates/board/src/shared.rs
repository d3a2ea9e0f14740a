//! Memory of values that other processes can map: what the owner of a variable gives out, and what another process makes of it.
//!
//! Only the bytes of values are given out. The words that say which value is the newest and who holds which stay with the process
//! that has the [`Board`](crate::Board): a process that breaks, or writes where it should not, can spoil the values that it was let
//! to write and nothing else, and whatever it held is let go of by whoever held it in its name. The memory has no name in any file
//! system and is gone with the last who has it open.

#![allow(unsafe_code, reason = "memory that is mapped can only be had raw")]

use std::io;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::ptr::NonNull;

use rustix::fs::{
    MemfdFlags, Mode, OFlags, SealFlags, fchmod, fcntl_add_seals, ftruncate, memfd_create, open,
};

/// The memory of a variable's values.
pub struct Shared {
    file: OwnedFd,
    first: usize,
    bytes: usize,
}

/// Such memory in a process that was given it.
pub struct Mapped {
    base: NonNull<u8>,
    bytes: usize,
}

// SAFETY: it gives out raw pointers only; who follows them says why that is right.
unsafe impl Send for Mapped {}
// SAFETY: as above.
unsafe impl Sync for Mapped {}

impl Shared {
    pub(crate) fn new(file: OwnedFd, first: usize, bytes: usize) -> Self {
        Self { file, first, bytes }
    }

    /// From which byte of the file to map it, a multiple of a page, and how many bytes.
    #[must_use]
    pub fn extent(&self) -> (usize, usize) {
        (self.first, self.bytes)
    }

    /// A file to give to a process that writes values.
    ///
    /// # Errors
    /// Those of the system.
    pub fn to_write(&self) -> io::Result<OwnedFd> {
        self.file.try_clone()
    }

    /// A file to give to a process that only reads: the system lets nobody write through it.
    ///
    /// # Errors
    /// Those of the system.
    pub fn to_read(&self) -> io::Result<OwnedFd> {
        let own = format!("/proc/self/fd/{}", self.file.as_raw_fd());
        Ok(open(own, OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?)
    }
}

impl Mapped {
    /// Maps what [`Shared::extent`] says of a file, to be written or only to be read.
    ///
    /// # Errors
    /// Those of the system; also when a file that is only for reading is to be written.
    pub fn new(file: BorrowedFd<'_>, (first, bytes): (usize, usize), write: bool) -> io::Result<Self> {
        let base = map(file, first, bytes, write)?;
        Ok(Self { base, bytes })
    }

    /// The address of so many bytes at a place, if they are inside.
    #[must_use]
    pub fn at(&self, place: usize, bytes: usize) -> Option<*mut u8> {
        let inside = place.checked_add(bytes).is_some_and(|end| end <= self.bytes);
        // SAFETY: inside of the mapping.
        inside.then(|| unsafe { self.base.as_ptr().add(place) })
    }
}

impl Drop for Mapped {
    fn drop(&mut self) {
        // SAFETY: mapped in `new` with this size, and owned.
        unsafe { unmap(self.base, self.bytes) };
    }
}

/// A multiple of the pages of every machine: they have 4, 16 or 64 kB.
pub(crate) const PAGE: usize = 64 << 10;

/// Maps part of a file, shared with whoever else maps it.
pub(crate) fn map(file: BorrowedFd<'_>, first: usize, bytes: usize, write: bool) -> io::Result<NonNull<u8>> {
    let access = libc::PROT_READ | if write { libc::PROT_WRITE } else { 0 };
    let first = libc::off_t::try_from(first).map_err(|_| io::ErrorKind::InvalidInput)?;
    // SAFETY: a new mapping where the system finds room disturbs nothing.
    let base = unsafe {
        libc::mmap(
            std::ptr::null_mut(),
            bytes,
            access,
            libc::MAP_SHARED,
            file.as_raw_fd(),
            first,
        )
    };
    if base == libc::MAP_FAILED {
        return Err(io::Error::last_os_error());
    }
    NonNull::new(base.cast()).ok_or_else(|| io::ErrorKind::OutOfMemory.into())
}

/// Takes back what [`map`] gave.
///
/// # Safety
/// It is of this size, and nothing refers to it.
pub(crate) unsafe fn unmap(base: NonNull<u8>, bytes: usize) {
    // SAFETY: the caller's. It fails only for addresses that were not mapped.
    let _ = unsafe { libc::munmap(base.as_ptr().cast(), bytes) };
}

/// Memory as a file of a fixed size: nobody who has it can take bytes away beneath the others. It is its user's alone, and who was given it
/// to read cannot open it again to write.
pub(crate) fn memory_file(bytes: usize) -> io::Result<OwnedFd> {
    let file = memfd_create("jde-values", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)?;
    fchmod(&file, Mode::RUSR)?;
    ftruncate(&file, bytes as u64)?;
    fcntl_add_seals(
        file.as_fd(),
        SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL,
    )?;
    Ok(file)
}
