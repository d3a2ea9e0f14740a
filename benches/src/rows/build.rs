//! The time of a build from a fresh clone, which a new user waits for before a robot moves.

use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};

use crate::scope::Scope;

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let folder = tempfile::tempdir()?;
    let clone = folder.path().join("jde");
    let start = Instant::now();
    succeed(
        Command::new("git")
            .args(["clone", "--quiet"])
            .arg(&scope.root)
            .arg(&clone),
    )?;
    let mut cargo = Command::new("cargo");
    cargo.args([
        "run",
        "--release",
        "--quiet",
        "--",
        "run",
        "safe-navigation",
        "--lockstep",
        "--for",
        "1s",
    ]);
    cargo
        .current_dir(&clone)
        .env_remove("CARGO_TARGET_DIR")
        .env_remove("RUSTFLAGS");
    succeed(&mut cargo)?;
    Ok(vec![Line::alone(
        "fresh clone to a moving robot, libraries downloaded before",
        Figure::Time(start.elapsed().as_nanos() as f64),
        Goal::Reported,
    )])
}

fn succeed(command: &mut Command) -> Result<()> {
    let output = command.stdin(Stdio::null()).output();
    let output = output.with_context(|| format!("cannot start {command:?}"))?;
    ensure!(
        output.status.success(),
        "{command:?} ended with {}:\n{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    Ok(())
}
