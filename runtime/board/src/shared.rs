//! Memory of values that other processes can map: what the owner of a variable shares, and how another
//! process maps it.
//!
//! Only the bytes of values are shared. The words that define which value is the newest and which values
//! are held remain in the process of the [`Board`](crate::Board). A process that fails, or writes where it
//! should not, can therefore damage only the values that it may write. The component that acts on
//! its behalf releases what it held. The memory has no name in any file system, and ends with its last user.

#![allow(unsafe_code, reason = "mapped memory is only available as raw memory")]

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

/// Such memory, mapped into the process that received it.
pub struct Mapping {
    base: NonNull<u8>,
    bytes: usize,
}

// SAFETY: it returns raw pointers only; each use of one states why it is sound.
unsafe impl Send for Mapping {}
// SAFETY: as above.
unsafe impl Sync for Mapping {}

impl Shared {
    pub(crate) fn new(file: OwnedFd, first: usize, bytes: usize) -> Self {
        Self { file, first, bytes }
    }

    /// Returns zeroed memory of its own, of at least `bytes` bytes.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn zeroed(bytes: usize) -> io::Result<Self> {
        let bytes = bytes.next_multiple_of(PAGE);
        Ok(Self::new(memory_file(bytes)?, 0, bytes))
    }

    /// Returns the byte of the file at which to map it, a multiple of a page, and the number of bytes.
    #[must_use]
    pub fn extent(&self) -> (usize, usize) {
        (self.first, self.bytes)
    }

    /// Returns a file for a process that writes values.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn writable_file(&self) -> io::Result<OwnedFd> {
        self.file.try_clone()
    }

    /// Returns a file for a process that only reads: the system refuses writes through it.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn readable_file(&self) -> io::Result<OwnedFd> {
        let own = format!("/proc/self/fd/{}", self.file.as_raw_fd());
        Ok(open(own, OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?)
    }
}

impl Mapping {
    /// Maps the [`Shared::extent`] of a file, for writing or for reading only.
    ///
    /// # Errors
    /// Errors of the system, for example if a read-only file is mapped for writing.
    pub fn new(file: BorrowedFd<'_>, (first, bytes): (usize, usize), write: bool) -> io::Result<Self> {
        let base = map(file, first, bytes, write)?;
        Ok(Self { base, bytes })
    }

    /// Returns the address of `bytes` bytes at `offset`, if they are inside the mapping.
    #[must_use]
    pub fn at(&self, offset: usize, bytes: usize) -> Option<*mut u8> {
        let inside = offset.checked_add(bytes).is_some_and(|end| end <= self.bytes);
        // SAFETY: inside of the mapping.
        inside.then(|| unsafe { self.base.as_ptr().add(offset) })
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: mapped in `new` with this size, and owned.
        unsafe { unmap(self.base, self.bytes) };
    }
}

/// A multiple of every machine's page size, which is 4, 16 or 64 kB.
pub(crate) const PAGE: usize = 64 << 10;

/// Maps part of a file, shared with every other mapping of it.
pub(crate) fn map(file: BorrowedFd<'_>, first: usize, bytes: usize, write: bool) -> io::Result<NonNull<u8>> {
    let access = libc::PROT_READ | if write { libc::PROT_WRITE } else { 0 };
    let first = libc::off_t::try_from(first).map_err(|_| io::ErrorKind::InvalidInput)?;
    // SAFETY: a new mapping at an address that the system chooses affects no other memory.
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

/// Removes a mapping of [`map`].
///
/// # Safety
/// The mapping has this size, and nothing refers to it.
pub(crate) unsafe fn unmap(base: NonNull<u8>, bytes: usize) {
    // SAFETY: the caller's contract. It fails only for addresses that are not mapped.
    let _ = unsafe { libc::munmap(base.as_ptr().cast(), bytes) };
}

/// Returns memory as a file of a fixed size, so that no holder can shrink it while others use it. Only its
/// user may open it, and only for reading, so a process with a read-only file cannot open it again for
/// writing.
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
