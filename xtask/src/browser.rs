//! The page from the robot in a real browser: sizes, themes, names for screen readers, what lets the pad go, and the stop.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context as _, Result};

use crate::shell::{self, ChildGuard};
use crate::step::StepOutcome;
use crate::test::Context;

/// The script, which plays the person.
const SCRIPT: &str = "programs/web/tests/browser.mjs";
/// The application: one that can be driven by hand, and has no end.
const APPLICATION: &str = "apps/safe-navigation.toml";
const OPTIONS: &[&str] = &["--set", "example.rounds=0"];
/// What the script needs from the registry of npm.
const PACKAGES: &[&str] = &["playwright-core@1.65.1", "axe-core@4.14.1"];
const INSTALL: &str = "sudo apt-get install chromium nodejs npm";

/// A run with a page. It is killed when dropped.
pub(crate) struct PageRun {
    process: ChildGuard,
    pub(crate) address: String,
}

/// Skipped without a browser, in CI too: it is larger than all else that the tests need.
pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if let Some(missing) = missing(&["chromium", "node", "npm"]) {
        return Ok(StepOutcome::Skipped(format!(
            "{missing} is not installed: {INSTALL}"
        )));
    }
    let folder = install(context, "browser", PACKAGES)?;
    let run = PageRun::start(context, APPLICATION, "page: ", OPTIONS)?;
    let mut node = Command::new("node");
    node.arg(context.root.join(SCRIPT))
        .arg(&run.address)
        .arg(&folder)
        .current_dir(&folder);
    shell::run(&mut node, context.paint)?;
    run.end()?;
    Ok(StepOutcome::Passed)
}

/// Returns the first of these programs that is not installed.
pub(crate) fn missing<'p>(programs: &[&'p str]) -> Option<&'p str> {
    let has = |program: &str| shell::succeeds(Command::new(program).arg("--version"));
    programs.iter().copied().find(|program| !has(program))
}

/// Installs packages of npm in a folder of their own, and returns it.
pub(crate) fn install(context: &Context, name: &str, packages: &[&str]) -> Result<PathBuf> {
    let folder = context.target.join(name);
    fs::create_dir_all(&folder)?;
    let mut npm = Command::new("npm");
    npm.args(["install", "--no-save", "--no-audit", "--no-fund", "--prefix"])
        .arg(&folder);
    shell::run(npm.args(packages), context.paint)?;
    Ok(folder)
}

impl PageRun {
    /// Starts an application with a page, and reads the address that follows a word.
    pub(crate) fn start(context: &Context, application: &str, word: &str, options: &[&str]) -> Result<Self> {
        let mut jde = Command::new(context.target.join("debug/jde"));
        jde.args(["run", application, "--plain", "--web"])
            .args(options)
            .current_dir(&context.root)
            .env("JDE_PLUGIN_PATH", context.target.join("debug"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        shell::show(&jde, context.paint);
        let mut process = ChildGuard(jde.spawn()?);
        let errors = process.0.stderr.take().context("it is piped")?;
        let mut lines = BufReader::new(errors).lines().map_while(Result::ok);
        let address = lines.find_map(|line| line.strip_prefix(word).map(str::to_owned));
        let address = address.context("the run printed no address")?;
        Ok(Self { process, address })
    }

    /// Ends the run.
    pub(crate) fn end(self) -> Result<()> {
        self.process.terminate()
    }
}
