//! Runs the example of `docs/agents.md`: an agent that uses the protocol's own client for Python finds why a recorded robot
//! stood, and proves its remedy in the simulator. A part of the step `peers`.

use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, ensure};

use crate::python::Environment;
use crate::shell;
use crate::test::Context;

/// The Python environment of the client.
const ENVIRONMENT: Environment = Environment {
    folder: "agents",
    packages: &["mcp==2.3.0"],
    imports: &["mcp"],
};
/// The folder of the example.
const EXAMPLE_FOLDER: &str = "examples/agents";
/// A hundred times the usual time.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(600);

pub(crate) fn run(context: &Context) -> Result<()> {
    let python = ENVIRONMENT.interpreter(&context.target, context.paint)?;
    let jde = context.target.join("debug/jde");
    let folder = context.target.join("agents/night");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    for entry in std::fs::read_dir(context.root.join(EXAMPLE_FOLDER))? {
        let file = entry?.path();
        std::fs::copy(&file, folder.join(file.file_name().unwrap_or_default()))?;
    }
    let mut record = Command::new(&jde);
    record
        .args(["run", "night.toml", "--lockstep", "--for", "120s"])
        .args(["--record", "night.mcap"]);
    let mut diagnose = Command::new(&python);
    diagnose.arg("diagnose.py").arg(&jde).arg("night.mcap");
    for command in [&mut record, &mut diagnose] {
        command
            .current_dir(&folder)
            .env("JDE_PLUGIN_PATH", context.target.join("debug"));
        shell::show(command, context.paint);
    }
    // The robot does not arrive, so the exit status is 1: that is what the agent is to explain.
    record.output().context("cannot start `jde run`")?;
    let output = shell::read_within(&mut diagnose, CLIENT_TIMEOUT).context("the agent failed")?;
    print!("{output}");
    ensure!(
        output.contains("10 of 10 drives passed"),
        "the agent proved no remedy"
    );
    Ok(())
}
