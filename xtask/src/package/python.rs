//! The package for Python as a folder: the sources, and the extension module that cargo built.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};

use crate::paint::Paint;
use crate::{project_files, shell};

/// The crate with the package.
pub(crate) const CRATE: &str = "programs/python";
/// The library that cargo builds.
const LIBRARY: &str = "lib_jde.so";
/// The same in the package, with the name of Python's stable ABI.
pub(super) const MODULE: &str = "jde/_jde.abi3.so";

/// Builds with a call of `cargo build` for the whole workspace, and writes the package as `python/jde` in cargo's
/// target folder, where the executable of the same build finds it. Returns the folder `python`.
pub(crate) fn make(root: &Path, target: &Path, mut cargo: Command, paint: Paint) -> Result<PathBuf> {
    shell::run(&mut cargo, paint)?;
    let folder = target.join("python");
    write(root, &target.join("debug"), &folder, |from, to| {
        fs::copy(from, to)
            .map(drop)
            .context("the extension module cannot be copied")
    })?;
    Ok(folder)
}

/// Writes the package into a folder of its own. `install` copies the extension module.
pub(super) fn write(
    root: &Path,
    built: &Path,
    folder: &Path,
    install: impl FnOnce(&Path, &Path) -> Result<()>,
) -> Result<()> {
    project_files::empty(folder)?;
    project_files::copy(&root.join(CRATE).join("python"), &["jde"], folder)?;
    install(&built.join(LIBRARY), &folder.join(MODULE))
}
