//! The campaign of faults: builds the executable, the plugins and the campaign, and runs it. All of its words are the campaign's own.

use std::ffi::OsString;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context as _, Result};

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::shell;

/// Runs it with these words; the exit status is its own.
pub(crate) fn run(root: &Path, dev: bool, words: &[OsString], paint: Paint) -> Result<ExitCode> {
    let mut cargo = shell::cargo();
    // The campaign is none of what `cargo build` builds: it is for those who work on jde.
    cargo.args(["build", "--workspace"]).current_dir(root);
    if !dev {
        cargo.arg("--release");
    }
    shell::run(&mut cargo, paint)?;
    let target = Metadata::of_workspace(root)?.target_directory;
    let program = target
        .join(if dev { "debug" } else { "release" })
        .join("jde-faults");
    // In place of this program, so that Ctrl-C is the campaign's alone.
    let error = std::process::Command::new(&program).args(words).exec();
    Err(error).with_context(|| format!("cannot start {}", program.display()))
}
