//! Private copies of plugins' files: they stay on disk while they are in use, so that backtraces and debuggers find symbols,
//! and go with the last who uses them. What a killed process left behind goes with the next one's first copy.

use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Once;

use tempfile::TempPath;

/// Copies are called `jde-<process>-<plugin>-<something>.so`.
const PREFIX: &str = "jde-";

/// Writes a copy of the library `original`, whose content is `bytes`, for this process alone.
pub(super) fn of(original: &Path, bytes: &[u8]) -> io::Result<TempPath> {
    static SWEPT: Once = Once::new();
    SWEPT.call_once(|| sweep(&std::env::temp_dir()));
    let name = original.file_stem().unwrap_or_default().to_string_lossy();
    let prefix = format!("{PREFIX}{}-{name}-", std::process::id());
    let mut copy = tempfile::Builder::new()
        .prefix(&prefix)
        .suffix(".so")
        .tempfile()?;
    copy.write_all(bytes)?;
    copy.flush()?;
    Ok(copy.into_temp_path())
}

/// Removes the copies of processes that are no more. Whatever cannot be removed is somebody else's.
fn sweep(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        if name
            .to_str()
            .and_then(owner)
            .is_some_and(|process| !Path::new("/proc").join(process.to_string()).exists())
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The process that made a copy of that name.
fn owner(name: &str) -> Option<u32> {
    let rest = name.strip_prefix(PREFIX)?.strip_suffix(".so")?;
    rest.split_once('-')?.0.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_goes_with_the_last_who_uses_it() {
        let copy = of(Path::new("libx.so"), b"bytes").unwrap();
        let path = copy.to_path_buf();
        assert_eq!(fs::read(&path).unwrap(), b"bytes");
        drop(copy);
        assert!(!path.exists());
    }

    #[test]
    fn only_what_the_dead_left_behind_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        // No process has this number: the kernel's greatest is 2^22.
        let dead = folder.path().join("jde-4194305-libx-abc.so");
        let own = folder
            .path()
            .join(format!("jde-{}-libx-abc.so", std::process::id()));
        let other = folder.path().join("jde-notes.so");
        for path in [&dead, &own, &other] {
            fs::write(path, "").unwrap();
        }
        sweep(folder.path());
        assert!(!dead.exists() && own.exists() && other.exists());
    }
}
