//! Runs clients of the link in Python against an application: the programs of `docs/protocol.md`, unchanged,
//! and peers without credentials. A part of the step `peers`.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{self, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, ensure};

use crate::shell::{self, ChildGuard};
use crate::test::Context;

/// The page with the programs.
const PAGE: &str = "docs/protocol.md";
/// The application that the programs inspect. Its schema `example` has a panel.
const APPLICATION: &str = "apps/safe-navigation.toml";
/// Peers without credentials. None of them may operate the application.
const ROGUE: &str = "observe/link/tests/peers/rogue.py";
/// The endpoint of the robot on the page, which is replaced by that of the test.
const ENDPOINT: &str = "tcp/robot2.local:7447";
/// The limit for finding the application and for one program: a hundred times the usual time.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(60);

pub(crate) fn run(context: &Context, python: &Path) -> Result<()> {
    let page = std::fs::read_to_string(context.root.join(PAGE))?;
    let programs = programs(&page);
    ensure!(!programs.is_empty(), "{PAGE} shows no program in Python");
    let (endpoint, _robot) = robot(context)?;
    for (number, program) in programs.iter().enumerate() {
        ensure!(
            program.contains(ENDPOINT),
            "a program of {PAGE} does not connect to {ENDPOINT}"
        );
        let file = context.target.join(format!("peers/client-{number}.py"));
        std::fs::write(&file, program.replace(ENDPOINT, &endpoint))?;
        let mut command = Command::new(python);
        command.arg(&file);
        shell::show(&command, context.paint);
        let output = shell::read_within(&mut command, CLIENT_TIMEOUT)
            .with_context(|| format!("a program of {PAGE} failed"))?;
        ensure!(!output.trim().is_empty(), "a program of {PAGE} found nothing");
        print!("{output}");
    }
    let mut rogue = Command::new(python);
    rogue
        .arg(context.root.join(ROGUE))
        .arg(context.target.join("debug/jde"))
        .arg(application(context, "closed.toml", "")?)
        .arg(context.target.join("peers"))
        .env("JDE_PLUGIN_PATH", context.target.join("debug"));
    shell::show(&rogue, context.paint);
    print!("{}", shell::read_within(&mut rogue, 4 * CLIENT_TIMEOUT)?);
    Ok(())
}

/// Writes a copy of the application with more lines into the folder of the peers.
fn application(context: &Context, name: &str, more: &str) -> Result<PathBuf> {
    let text = std::fs::read_to_string(context.root.join(APPLICATION))?;
    // Its paths are relative to the folder of the original.
    let text = text.replace("\"../", &format!("\"{}/", context.root.display()));
    let file = context.target.join("peers").join(name);
    std::fs::write(&file, text + more)?;
    Ok(file)
}

/// Returns the Python blocks of a page.
fn programs(page: &str) -> Vec<String> {
    let blocks = page.split("```python\n").skip(1);
    blocks
        .filter_map(|block| Some(block.split_once("\n```")?.0.to_owned() + "\n"))
        .collect()
}

/// Starts a robot that listens on the loopback interface. Returns its endpoint and its process.
fn robot(context: &Context) -> Result<(String, ChildGuard)> {
    // The port is free again before the robot binds it. No other program of this step requests a port.
    let port = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
    let endpoint = format!("tcp/127.0.0.1:{port}");
    let folder_of_plugins = context.target.join("debug");
    let link = format!("\n[link]\nlisten = [\"{endpoint}\"]\ninsecure = true\n");
    let file = application(context, "open.toml", &link)?;
    let mut command = Command::new(folder_of_plugins.join("jde"));
    // A unique name: other tests may run applications on this machine at the same time.
    let name = format!("documented-{}", process::id());
    command.args(["run", "--plain", "--name", &name]).arg(&file);
    command
        .env("JDE_PLUGIN_PATH", &folder_of_plugins)
        .current_dir(&context.root);
    shell::show(&command, context.paint);
    let child = command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .context("cannot start `jde run`")?;
    let mut robot = ChildGuard(child);
    let (begun, quoted) = (Instant::now(), format!("\"{name}\""));
    loop {
        let mut apps = Command::new(context.target.join("debug/jde"));
        if shell::read_within(apps.args(["apps", "--json"]), CLIENT_TIMEOUT)?.contains(&quoted) {
            return Ok((endpoint, robot));
        }
        ensure!(robot.0.try_wait()?.is_none(), "`jde run` ended at once");
        ensure!(
            begun.elapsed() < CLIENT_TIMEOUT,
            "`jde apps` does not find {name}, which has run for {CLIENT_TIMEOUT:?}"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::programs;

    #[test]
    fn the_programs_of_a_page_are_its_python_blocks() {
        let page = "a\n```sh\nls\n```\n```python\nimport json\nprint(1)\n```\nb\n```python\nx\n```\n";
        assert_eq!(programs(page), ["import json\nprint(1)\n", "x\n"]);
    }
}
