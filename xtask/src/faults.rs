//! Builds the executable, the plugins and the campaign of faults, and runs the campaign, which defines its
//! own options.

use std::ffi::OsString;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context as _, Result};

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::shell;

/// Runs the campaign with these arguments. Its exit status becomes that of this program.
pub(crate) fn run(root: &Path, dev: bool, arguments: &[OsString], paint: Paint) -> Result<ExitCode> {
    // Help needs no optimised build, which takes many minutes.
    let dev = dev
        || arguments
            .iter()
            .any(|argument| argument == "--help" || argument == "-h");
    let mut cargo = shell::cargo();
    // `cargo build` alone omits the campaign, since users do not need it.
    cargo.args(["build", "--workspace"]).current_dir(root);
    if !dev {
        cargo.arg("--release");
    }
    shell::run(&mut cargo, paint)?;
    let target = Metadata::of_workspace(root)?.target_directory;
    let program = target
        .join(if dev { "debug" } else { "release" })
        .join("jde-faults");
    // Replaces this process, so that Ctrl-C reaches the campaign alone.
    let error = std::process::Command::new(&program).args(arguments).exec();
    Err(error).with_context(|| format!("cannot start {}", program.display()))
}
