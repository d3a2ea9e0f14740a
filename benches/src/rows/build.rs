//! What a new user waits for: both commands of the README, from a fresh clone, and the second one again.

use std::collections::HashSet;
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};

use crate::scope::Scope;

const MINUTE: f64 = 60e9;

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let folder = tempfile::tempdir()?;
    let clone = folder.path().join("jde");
    time(
        Command::new("git")
            .args(["clone", "--quiet"])
            .arg(&scope.root)
            .arg(&clone),
    )?;
    let cargo = |arguments: &[&str]| {
        let mut cargo = Command::new("cargo");
        cargo
            .args(arguments)
            .current_dir(&clone)
            .env_remove("CARGO_TARGET_DIR")
            .env_remove("RUSTFLAGS");
        time(&mut cargo)
    };
    // In virtual time the whole drive takes less than a second.
    let demo = cargo(&["run", "--", "demo", "--headless", "--lockstep"])?;
    let cold = cargo(&["xtask", "test"])?;
    let size = Figure::Bytes(size(&clone.join("target"), &mut HashSet::new())? as f64);
    let warm = cargo(&["xtask", "test"])?;
    let below = |minutes: f64| Goal::Below(Figure::Time(minutes * MINUTE));
    Ok(vec![
        Line::new("fresh clone: `cargo run -- demo`", demo, below(1.5)),
        Line::new("then `cargo xtask test`", cold, below(12.0)),
        Line::new("the same again", warm, below(3.0)),
        Line::new("size of its target folder", size, Goal::Below(Figure::Bytes(8e9))),
    ])
}

/// Returns the time of a command that must succeed.
fn time(command: &mut Command) -> Result<Figure> {
    let start = Instant::now();
    let output = command.stdin(Stdio::null()).output();
    let output = output.with_context(|| format!("cannot start {command:?}"))?;
    ensure!(
        output.status.success(),
        "{command:?} ended with {}:\n{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    Ok(Figure::Time(start.elapsed().as_nanos() as f64))
}

/// Returns the size of all files below a folder, in bytes. Cargo gives many files two names: each counts once.
fn size(folder: &Path, counted: &mut HashSet<u64>) -> Result<u64> {
    let mut sum = 0;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let metadata = entry.metadata()?;
        if metadata.is_dir() {
            sum += size(&entry.path(), counted)?;
        } else if counted.insert(metadata.ino()) {
            sum += metadata.len();
        }
    }
    Ok(sum)
}
