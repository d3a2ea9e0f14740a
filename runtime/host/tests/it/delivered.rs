//! Delivered applications, with their plugins built on demand. No result of another test is used.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use jde_loader::{Plugins, SearchPath};

pub(crate) const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
pub(crate) const SECOND: u64 = 1_000_000_000;

/// The plugins that the tests use.
const NAMES: [&str; 13] = [
    "ball", "depth", "drive", "example", "family", "father", "goon", "guard", "scan", "sim", "stop",
    "teleop", "vff",
];

/// Returns the folder with the plugins. The first call builds them, all at once: a second build of some of
/// them could replace files that another test reads.
pub(crate) fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| jde_test_plugins::folder(&NAMES))
}

/// The plugins of delivered applications.
pub(crate) fn plugins() -> Plugins {
    let mut path = SearchPath::default();
    path.push(folder(), "built for this test");
    Plugins::new(path)
}
