//! The executable `jde` that belongs to this library.

use std::ffi::{CStr, OsStr};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

/// Returns the executable of the prefix that contains this library, the one beside the library as in a build of the
/// checkout, or that of the `PATH`.
pub(crate) fn find() -> Option<PathBuf> {
    let library = library().and_then(|library| library.canonicalize().ok());
    let folder = library.as_deref().and_then(Path::parent);
    let of_library = folder.into_iter().flat_map(|folder| {
        let prefix = folder.parent().map(|prefix| prefix.join("bin"));
        prefix.into_iter().chain([folder.to_owned()])
    });
    let listed = std::env::var_os("PATH").unwrap_or_default();
    let listed: Vec<_> = std::env::split_paths(&listed).collect();
    let mut files = of_library.chain(listed).map(|folder| folder.join("jde"));
    files.find(|file| file.is_file())
}

/// Returns the file of this library.
fn library() -> Option<PathBuf> {
    let mut info = libc::Dl_info {
        dli_fname: std::ptr::null(),
        dli_fbase: std::ptr::null_mut(),
        dli_sname: std::ptr::null(),
        dli_saddr: std::ptr::null_mut(),
    };
    // SAFETY: an address of this library, and a structure to fill in.
    let found = unsafe { libc::dladdr(library as *const libc::c_void, &raw mut info) };
    if found == 0 || info.dli_fname.is_null() {
        return None;
    }
    // SAFETY: `dladdr` gave a text that ends with a NUL, and the library stays loaded.
    let file = unsafe { CStr::from_ptr(info.dli_fname) };
    Some(PathBuf::from(OsStr::from_bytes(file.to_bytes())))
}
