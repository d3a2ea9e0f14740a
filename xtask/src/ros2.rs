//! Tests the ROS 2 driver against an independent implementation, over a Zenoh router and sockets of the
//! loopback interface. A ROS 2 program drives a robot of jde by its topics, and schemas of jde drive a robot
//! of ROS 2. A part of the step `peers`.

use std::fs;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command, Stdio};

use anyhow::{Context as _, Result, ensure};

use crate::shell::{self, ChildGuard};
use crate::test::Context;

/// The Python package to install, and the module to import as a check.
pub(crate) const PACKAGE: &str = "zenoh_ros2_sdk==0.1.8";
pub(crate) const IMPORT: &str = "zenoh_ros2_sdk";
/// The peers, which use no code of jde: a router, a program that drives, and a robot.
const PEER: &str = "drivers/ros2/tests/peers/ros2_peer.py";
/// The limit for one run of `jde`.
const LIMIT: &str = "180s";

/// A peer that runs until its standard input closes or this is dropped.
struct Peer {
    process: ChildGuard,
    output: BufReader<ChildStdout>,
}

pub(crate) fn run(context: &Context, python: &Path) -> Result<()> {
    let folder = folder(context);
    // A run that was killed may have left files.
    let clear = || match fs::remove_dir_all(&folder) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        Ok(()) | Err(_) => Ok(()),
    };
    clear()?;
    fs::create_dir_all(&folder)?;
    let result = run_peers(context, python);
    clear()?;
    result
}

/// The folder for the peers' temporary files. Peers that are killed after a failure cannot remove them.
fn folder(context: &Context) -> PathBuf {
    context.target.join("peers/ros2")
}

/// Returns the command for a ROS 2 peer.
fn peer(context: &Context, python: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(python);
    command.arg(context.root.join(PEER)).args(arguments);
    shell::show(&command, context.paint);
    command.env("TMPDIR", folder(context));
    command
}

fn run_peers(context: &Context, python: &Path) -> Result<()> {
    let mut router = Peer::start(context, python, &["router"])?;
    let port = router.line()?;
    // With this range the laser sees the end of the corridor. The program compares the wheels' odometry with
    // it.
    let range = ["--set", "pioneer.laser_range=30"];
    among(
        context,
        python,
        &port,
        "drive",
        jde(context, "ros2", &["topics"], &port).args(range),
    )?;
    let sources = ["robot", "teleop", "docking", "navigation"];
    among(
        context,
        python,
        &port,
        "arbitrate",
        &mut jde(context, "ros2-arbiter", &sources, &port),
    )?;
    serve(context, python, &port)
}

/// Runs an application while a ROS 2 program, which has this role, uses it.
fn among(context: &Context, python: &Path, port: &str, role: &str, command: &mut Command) -> Result<()> {
    shell::show(command, context.paint);
    let application = command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .context("cannot start the application")?;
    let mut application = ChildGuard(application);
    let mut program = peer(context, python, &[role, port]);
    print!(
        "{}",
        shell::read(&mut program).context("the program of ROS 2 failed")?
    );
    ensure!(
        application.0.try_wait()?.is_none(),
        "the application ended too early"
    );
    application.terminate()?;
    let status = application.0.wait()?;
    ensure!(status.success(), "the application ended with {status}");
    Ok(())
}

/// Drives a robot of ROS 2 with the schemas of safe-navigation.
fn serve(context: &Context, python: &Path, port: &str) -> Result<()> {
    let mut robot = Peer::start(context, python, &["serve", port])?;
    let ready = robot.line()?;
    ensure!(ready == "ready", "the robot of ROS 2 printed {ready}");
    let mut command = jde(context, "ros2-robot", &["robot"], port);
    shell::show(&command, context.paint);
    // It succeeds if the robot has reached all its targets.
    shell::read(&mut command).context("our schemas did not drive the robot of ROS 2")?;
    println!("{}", robot.end()?);
    Ok(())
}

/// Returns the command for an application, of which these schemas connect to this port.
fn jde(context: &Context, application: &str, schemas: &[&str], port: &str) -> Command {
    let mut command = Command::new(context.target.join("debug/jde"));
    command
        .args(["run", application, "--plain", "--for", LIMIT])
        .args(
            schemas
                .iter()
                .map(|schema| format!("--set={schema}.connect=tcp/127.0.0.1:{port}")),
        )
        .env_remove("ROS_DOMAIN_ID")
        .current_dir(&context.root);
    command
}

impl Peer {
    fn start(context: &Context, python: &Path, arguments: &[&str]) -> Result<Self> {
        let mut process = peer(context, python, arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .context("cannot start the peer")?;
        let output = process.stdout.take().context("it has no standard output")?;
        Ok(Self {
            process: ChildGuard(process),
            output: BufReader::new(output),
        })
    }

    /// Returns the next line of the peer's output.
    fn line(&mut self) -> Result<String> {
        let mut line = String::new();
        self.output.read_line(&mut line)?;
        ensure!(line.ends_with('\n'), "the peer ended; see its error above");
        Ok(line.trim().to_owned())
    }

    /// Closes the peer's standard input and waits for its end. Returns its last line.
    fn end(&mut self) -> Result<String> {
        drop(self.process.0.stdin.take());
        let last = self.line()?;
        let status = self.process.0.wait()?;
        ensure!(status.success(), "the peer ended with {status}");
        Ok(last)
    }
}
