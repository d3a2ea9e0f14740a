//! Foxglove's own client of its protocol, against a running application: what it understands, sets and calls, two thousand
//! values a second beside a reader that does not read, and broken frames.

use std::process::Command;

use anyhow::Result;

use crate::browser::{self, PageRun};
use crate::shell;
use crate::step::StepOutcome;
use crate::test::Context;

const SCRIPT: &str = "programs/web/tests/foxglove.mjs";
const APPLICATION: &str = "programs/jde/tests/apps/flood.toml";
const PACKAGES: &[&str] = &["@foxglove/ws-protocol@0.8.0", "ws@8.23.0"];
const INSTALL: &str = "sudo apt-get install nodejs npm";

/// Skipped without Node.js, in CI too, as the step of the browser.
pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if let Some(missing) = browser::missing(&["node", "npm"]) {
        return Ok(StepOutcome::Skipped(format!(
            "{missing} is not installed: {INSTALL}"
        )));
    }
    let folder = browser::install(context, "foxglove", PACKAGES)?;
    let run = PageRun::start(context, APPLICATION, "foxglove: ", &[])?;
    let mut node = Command::new("node");
    node.arg(context.root.join(SCRIPT))
        .arg(&run.address)
        .current_dir(&folder);
    shell::run(&mut node, context.paint)?;
    run.end()?;
    Ok(StepOutcome::Passed)
}
