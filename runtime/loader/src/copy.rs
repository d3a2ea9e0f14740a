//! Private copies of plugin files. A copy stays on disk while it is in use, so that backtraces and debuggers
//! find its symbols, and is removed with its last user. The first copy of a process also removes the copies
//! of killed processes. A copy is held open: whoever cleans up the folder takes its name, and not its content.

use std::fs::{self, File};
use std::io;
use std::os::fd::{AsFd as _, OwnedFd};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::sync::Once;

use tempfile::TempPath;

use super::python::is_python;
use super::{LoadError, modules};

/// Copies are called `jde-<process>-<plugin>-<random>` with the extension of the original.
const PREFIX: &str = "jde-";
/// The largest plugin, bytes: several times a debug build. A sparse file would fill the disk with its copy.
const MAX_FILE: u64 = 1 << 30;
/// Bytes that are compared at once.
const PIECE_BYTES: usize = 1 << 16;

/// A copy that no other process writes. Dropping this value removes it.
#[derive(Debug)]
pub(super) struct PrivateCopy {
    path: TempPath,
    /// Open for reading alone.
    file: File,
    /// What the modules contained that a file of Python imports from beside it.
    modules: Vec<(PathBuf, Vec<u8>)>,
    /// Size in bytes.
    pub(super) length: u64,
}

/// Copies the plugin `original` for this process alone. The kernel copies if it can, without passing the
/// contents through this process.
pub(super) fn create(original: &Path) -> Result<PrivateCopy, LoadError> {
    static CLEANED: Once = Once::new();
    CLEANED.call_once(|| remove_stale(&std::env::temp_dir()));
    if original.is_dir() {
        return Err(LoadError::Invalid(String::from(
            "it is a directory; name the library in it",
        )));
    }
    let name = original.file_stem().unwrap_or_default().to_string_lossy();
    let prefix = format!("{PREFIX}{}-{name}-", std::process::id());
    let suffix = if is_python(original) { ".py" } else { ".so" };
    let mut file = jde_files::open(original)?;
    // Before the file is copied: what is written meanwhile is another build.
    let modules = if is_python(original) {
        read_modules(original)
    } else {
        Vec::new()
    };
    if file.metadata()?.len() > MAX_FILE {
        return Err(LoadError::Invalid(format!(
            "it has more than {} MiB, and no plugin is that large",
            MAX_FILE >> 20
        )));
    }
    let copied = tempfile::Builder::new()
        .prefix(&prefix)
        .suffix(suffix)
        .tempfile()
        .and_then(|mut copy| {
            let length = io::copy(&mut file, copy.as_file_mut())?;
            let path = copy.into_temp_path();
            let file = File::open(&path)?;
            Ok(PrivateCopy {
                path,
                file,
                modules,
                length,
            })
        });
    copied.map_err(|error| LoadError::Copy {
        folder: std::env::temp_dir(),
        error,
    })
}

impl PrivateCopy {
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether both have the same content, and imported the same; false if one cannot be read.
    pub(super) fn has_same_content(&self, other: &Self) -> bool {
        self.length == other.length
            && self.modules == other.modules
            && compare_files(&self.file, &other.file).unwrap_or(false)
    }

    /// Returns the open file, for another process.
    pub(super) fn held(&self) -> io::Result<OwnedFd> {
        self.file.as_fd().try_clone_to_owned()
    }
}

fn read_modules(file: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let modules = modules::of(file).into_iter();
    modules
        .filter_map(|module| Some((module.clone(), fs::read(module).ok()?)))
        .collect()
}

/// Whether two files of the same length have the same content.
fn compare_files(one: &File, other: &File) -> io::Result<bool> {
    let mut pieces = [vec![0; PIECE_BYTES], vec![0; PIECE_BYTES]];
    let [first, second] = &mut pieces;
    let mut offset = 0;
    loop {
        let length = one.read_at(first, offset)?;
        if length == 0 {
            return Ok(true);
        }
        other.read_exact_at(&mut second[..length], offset)?;
        if first[..length] != second[..length] {
            return Ok(false);
        }
        offset += length as u64;
    }
}

/// Removes the copies of processes that no longer exist. A file that cannot be removed belongs to another
/// user.
fn remove_stale(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        if name
            .to_str()
            .and_then(owner_pid)
            .is_some_and(|process| !Path::new("/proc").join(process.to_string()).exists())
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Returns the id of the process that created a copy of that name.
fn owner_pid(name: &str) -> Option<u32> {
    let rest = name.strip_prefix(PREFIX)?;
    let rest = rest.strip_suffix(".so").or(rest.strip_suffix(".py"))?;
    rest.split_once('-')?.0.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_is_removed_with_its_last_user() {
        let folder = tempfile::tempdir().unwrap();
        let original = folder.path().join("libx.so");
        fs::write(&original, b"bytes").unwrap();
        let copy = create(&original).unwrap();
        let path = copy.path().to_path_buf();
        assert_eq!(fs::read(&path).unwrap(), b"bytes");
        assert_eq!(copy.length, 5);
        drop(copy);
        assert!(!path.exists());
    }

    #[test]
    fn copies_have_the_same_content_only_if_all_bytes_agree() {
        let folder = tempfile::tempdir().unwrap();
        let copy = |name: &str, bytes: &[u8]| {
            let original = folder.path().join(name);
            fs::write(&original, bytes).unwrap();
            create(&original).unwrap()
        };
        let mut bytes = vec![7; 200_000];
        let (one, same) = (copy("libone.so", &bytes), copy("libsame.so", &bytes));
        bytes[199_999] = 8;
        let (other, shorter) = (
            copy("libother.so", &bytes),
            copy("libshorter.so", &bytes[..199_999]),
        );
        assert!(one.has_same_content(&same));
        assert!(!one.has_same_content(&other) && !one.has_same_content(&shorter));
    }

    #[test]
    fn only_copies_of_ended_processes_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        // No process has this number: the kernel's largest is 2^22.
        let dead = folder.path().join("jde-4194305-libx-abc.so");
        let own = folder
            .path()
            .join(format!("jde-{}-libx-abc.so", std::process::id()));
        let other = folder.path().join("jde-notes.so");
        for path in [&dead, &own, &other] {
            fs::write(path, "").unwrap();
        }
        remove_stale(folder.path());
        assert!(!dead.exists() && own.exists() && other.exists());
    }
}
