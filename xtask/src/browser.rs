//! The page from the robot in a real browser: sizes, themes, names for screen readers, what lets the pad go, and the stop.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};

use anyhow::{Context as _, Result};

use crate::shell::{self, ChildGuard};
use crate::step::StepOutcome;
use crate::test::Context;

/// The script, which plays the person.
const SCRIPT: &str = "programs/web/tests/browser.mjs";
/// The application: one that can be driven by hand, and has no end.
const RUN: &[&str] = &[
    "run",
    "apps/safe-navigation.toml",
    "--plain",
    "--set",
    "example.rounds=0",
    "--web",
];
/// What the script needs from the registry of npm.
const PACKAGES: &[&str] = &["playwright-core@1.65.1", "axe-core@4.14.1"];
const INSTALL: &str = "sudo apt-get install chromium nodejs npm";

/// Skipped without a browser, in CI too: it is larger than all else that the tests need.
pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    let has = |program: &str| shell::succeeds(Command::new(program).arg("--version"));
    if let Some(missing) = ["chromium", "node", "npm"]
        .into_iter()
        .find(|program| !has(program))
    {
        return Ok(StepOutcome::Skipped(format!(
            "{missing} is not installed: {INSTALL}"
        )));
    }
    let folder = context.target.join("browser");
    fs::create_dir_all(&folder)?;
    let mut npm = Command::new("npm");
    npm.args(["install", "--no-save", "--no-audit", "--no-fund", "--prefix"])
        .arg(&folder);
    shell::run(npm.args(PACKAGES), context.paint)?;
    let mut jde = Command::new(context.target.join("debug/jde"));
    jde.args(RUN)
        .current_dir(&context.root)
        .env("JDE_PLUGIN_PATH", context.target.join("debug"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    shell::show(&jde, context.paint);
    let mut run = ChildGuard(jde.spawn()?);
    let lines = BufReader::new(run.0.stderr.take().context("it is piped")?).lines();
    let mut lines = lines.map_while(Result::ok);
    let address = lines.find_map(|line| line.strip_prefix("page: ").map(str::to_owned));
    let address = address.context("the run printed no address")?;
    let mut node = Command::new("node");
    node.arg(context.root.join(SCRIPT))
        .arg(address)
        .arg(&folder)
        .current_dir(&folder);
    shell::run(&mut node, context.paint)?;
    run.terminate()?;
    Ok(StepOutcome::Passed)
}
