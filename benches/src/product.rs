//! The executable as users have it, started in a private place. Builds nothing.

use std::fs::{DirBuilder, File};
use std::io::{Seek as _, Write as _};
use std::os::unix::fs::DirBuilderExt;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context as _, Result, ensure};

use crate::scope::Scope;

/// `jde` with its plugins, whose sockets are in `folder` and nowhere else.
pub(crate) fn jde(scope: &Scope, folder: &Path) -> Command {
    let private = folder.join("run");
    // There already after the first time.
    let _ = DirBuilder::new().mode(0o700).create(&private);
    let mut command = Command::new(scope.built.join("jde"));
    command
        .env("JDE_RUNTIME_DIR", private.join("jde"))
        .env("JDE_PLUGIN_PATH", &scope.built)
        .current_dir(&scope.root)
        .stdin(Stdio::null());
    command
}

/// Runs it to its end; what it wrote to standard output. Its words appear only if it fails.
pub(crate) fn read(command: &mut Command) -> Result<String> {
    let output = command
        .output()
        .with_context(|| format!("cannot start {command:?}"))?;
    ensure!(
        output.status.success(),
        "{command:?} ended with {}:\n{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    Ok(String::from_utf8(output.stdout)?)
}

/// As [`read`], for one that reads `text` from its standard input.
pub(crate) fn tell(command: &mut Command, text: &str) -> Result<String> {
    let mut file = tempfile::tempfile()?;
    file.write_all(text.as_bytes())?;
    file.rewind()?;
    read(command.stdin(file))
}

/// Where what a process says that nobody asked for goes.
pub(crate) fn nowhere() -> Result<File> {
    Ok(File::options().write(true).open("/dev/null")?)
}
