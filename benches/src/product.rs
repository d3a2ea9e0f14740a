//! Starts the executable as users have it, in a private folder. Builds nothing.

use std::fs::{self, DirBuilder, File};
use std::io::{Seek as _, Write as _};
use std::os::unix::fs::DirBuilderExt;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context as _, Result, ensure};

use crate::scope::Scope;

/// Returns a command for `jde` with its plugins. All its sockets are in `folder`.
pub(crate) fn jde(scope: &Scope, folder: &Path) -> Command {
    let private = folder.join("run");
    // The folder exists after the first call.
    let _ = DirBuilder::new().mode(0o700).create(&private);
    let mut command = Command::new(scope.built.join("jde"));
    command
        .env("JDE_RUNTIME_DIR", private.join("jde"))
        .env("JDE_PLUGIN_PATH", &scope.built)
        .current_dir(&scope.root)
        .stdin(Stdio::null());
    command
}

/// Runs a command to its end and returns its standard output. Its output is shown only if it fails.
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

/// Like [`read`], with `text` as the standard input.
pub(crate) fn run_with_input(command: &mut Command, text: &str) -> Result<String> {
    let mut file = tempfile::tempfile()?;
    file.write_all(text.as_bytes())?;
    file.rewind()?;
    read(command.stdin(file))
}

/// Opens `/dev/null`, for output that is not needed.
pub(crate) fn null_device() -> Result<File> {
    Ok(File::options().write(true).open("/dev/null")?)
}

/// Returns the processor time of all child processes that have ended, s.
pub(crate) fn children_processor_time() -> Result<f64> {
    let text = fs::read_to_string("/proc/self/stat")?;
    // The name may contain blanks; the rest does not.
    let (_, rest) = text.rsplit_once(')').context("stat has no name")?;
    let fields: Vec<&str> = rest.split_whitespace().collect();
    let ticks: u64 = fields[13].parse::<u64>()? + fields[14].parse::<u64>()?;
    Ok(ticks as f64 / rustix::param::clock_ticks_per_second() as f64)
}
