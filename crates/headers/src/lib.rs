//! The files that are generated from the Rust source, so that the two cannot differ: the C headers of the ABI
//! and of the standard types, and the table of policies in the documentation.
//!
//! `jde.h` is written from the source of `jde_abi::raw`, which uses only constants and C structures with
//! comments. A general generator would keep Rust's links in the comments and could not compute the magic
//! number. It would also turn an opaque structure into one without members, which C does not permit. Nothing
//! in this crate runs on a robot.

mod abi;
mod names;
mod policies;
mod types;

use std::path::Path;
use std::{fs, io};

/// The command that renews the files.
pub const RENEW: &str = "cargo xtask headers";

/// The page with the table of policies.
const PAGE: &str = "docs/applications.md";

/// Returns the generated files of the project at `root`: their paths from there, and their text.
#[must_use]
pub fn all(root: &Path) -> Vec<(&'static str, String)> {
    let mut files = vec![("include/jde.h", jde_h()), ("include/jde_types.h", jde_types_h())];
    let page = fs::read_to_string(root.join(PAGE));
    files.extend(page.ok().map(|page| (PAGE, policies::renew(&page))));
    files
}

/// Returns the paths of the files that differ from the source.
#[must_use]
pub fn stale(root: &Path) -> Vec<&'static str> {
    let files = all(root).into_iter();
    files
        .filter(|(path, text)| fs::read_to_string(root.join(path)).ok().as_ref() != Some(text))
        .map(|(path, _)| path)
        .collect()
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

/// Writes the files that differ, and returns their paths.
///
/// # Errors
/// If a file cannot be written.
pub fn renew(root: &Path) -> io::Result<Vec<&'static str>> {
    let stale = stale(root);
    for (path, text) in all(root) {
        if stale.contains(&path) {
            let path = root.join(path);
            fs::create_dir_all(path.parent().unwrap_or(root))?;
            fs::write(path, text)?;
        }
    }
    Ok(stale)
}
