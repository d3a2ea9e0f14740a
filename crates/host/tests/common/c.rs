//! Plugins in C, built by `cc`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Builds a library from a file of `tests/c`, with these macros.
pub(crate) fn build(source: &str, macros: &[String], to: &Path) {
    let root = env!("CARGO_MANIFEST_DIR");
    let output = Command::new("cc")
        .args([
            "-shared",
            "-fPIC",
            "-std=c11",
            "-I",
            &format!("{root}/../../include"),
        ])
        .args(macros)
        .arg("-o")
        .args([to, &PathBuf::from(format!("{root}/tests/c/{source}"))])
        .output()
        .expect("a C compiler named cc is installed");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
