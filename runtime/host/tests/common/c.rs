//! Plugins in C and C++, built by `cc` and `c++`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Builds a library from a file of `tests/c`, with these macros.
pub(crate) fn build(source: &str, macros: &[String], to: &Path) {
    let root = env!("CARGO_MANIFEST_DIR");
    let (compiler, standard) = match source.ends_with(".cpp") {
        true => ("c++", "-std=c++17"),
        false => ("cc", "-std=c11"),
    };
    let output = Command::new(compiler)
        .args([
            "-shared",
            "-fPIC",
            standard,
            "-I",
            &format!("{root}/../../include"),
        ])
        .args(macros)
        .arg("-o")
        .args([to, &PathBuf::from(format!("{root}/tests/c/{source}"))])
        .output()
        .expect("compilers named cc and c++ are installed");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
