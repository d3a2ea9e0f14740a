//! The C headers of the ABI and of the standard types, generated from the Rust source so that the two cannot
//! differ.
//!
//! `jde.h` is written from the source of `jde_abi::raw`, which uses only constants and C structures with
//! comments. A general generator would keep Rust's links in the comments and could not compute the magic
//! number. It would also turn an opaque structure into one without members, which C does not permit. Nothing
//! in this crate runs on a robot.

mod abi;
mod names;
mod types;

use std::path::{Path, PathBuf};
use std::{fs, io};

/// The command that renews the headers.
pub const RENEW: &str = "cargo xtask headers";

/// Returns the files under `include/`, by name.
#[must_use]
pub fn all() -> [(&'static str, String); 2] {
    [("jde.h", jde_h()), ("jde_types.h", jde_types_h())]
}

/// Returns the text of `include/jde.h`: the tables of the ABI, and macros that fill them.
#[must_use]
pub fn jde_h() -> String {
    abi::header()
}

/// Returns the text of `include/jde_types.h`: the standard types as C structures, with their descriptions.
#[must_use]
pub fn jde_types_h() -> String {
    types::header()
}

/// Returns the C name of a standard type: `jde_laser_scan` for `LaserScan`. `jde_laser_scan_type` describes
/// that type.
#[must_use]
pub fn c_name(name: &str) -> String {
    names::structure(name)
}

/// Writes the files that differ under `include/` of the project at `root`, and returns their paths.
///
/// # Errors
/// If a file cannot be written.
pub fn renew(root: &Path) -> io::Result<Vec<PathBuf>> {
    let mut renewed = Vec::new();
    for (name, text) in all() {
        let path = root.join("include").join(name);
        if fs::read_to_string(&path).is_ok_and(|old| old == text) {
            continue;
        }
        fs::create_dir_all(root.join("include"))?;
        fs::write(&path, text)?;
        renewed.push(path);
    }
    Ok(renewed)
}
