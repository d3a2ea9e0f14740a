//! The C headers of the ABI and of the standard types, made from their Rust, so that the two cannot differ.
//!
//! The ABI's is written from the source of `jde_abi::raw`, which is a small language of its own: constants and C structures
//! with comments. A general generator would keep Rust's links in the comments, could not tell the magic number, and gives C an
//! opaque structure of no size, which C does not have. Nothing here runs while a robot does.

mod abi;
mod names;
mod types;

use std::path::{Path, PathBuf};
use std::{fs, io};

/// The command that renews the files.
pub const RENEW: &str = "cargo xtask headers";

/// The files under `include/`, by name.
#[must_use]
pub fn all() -> [(&'static str, String); 2] {
    [("jde.h", jde_h()), ("jde_types.h", jde_types_h())]
}

/// The text of `include/jde.h`: the tables of the ABI, and macros that fill them.
#[must_use]
pub fn jde_h() -> String {
    abi::header()
}

/// The text of `include/jde_types.h`: the standard types as C structures, with their descriptions.
#[must_use]
pub fn jde_types_h() -> String {
    types::header()
}

/// The C name of a standard type: `LaserScan` is `jde_laser_scan`, and `jde_laser_scan_type` describes it.
#[must_use]
pub fn c_name(name: &str) -> String {
    names::structure(name)
}

/// Writes the files that differ under `include/` of the project at `root`, and says which.
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
