//! Tests the ROS 2 drivers over a Zenoh router and sockets of the loopback interface. A ROS 2 program drives a
//! robot of jde by its topics, and schemas of jde drive a robot of ROS 2. The step `ros2` does so with ROS 2 itself and
//! its tools, the step `peers` with an independent implementation.

use std::fs;
use std::io::{self, BufRead, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command, Stdio};

use anyhow::{Context as _, Result, ensure};

use crate::lints;
use crate::package::python;
use crate::shell::{self, ChildGuard};
use crate::step::StepOutcome;
use crate::test::Context;

/// The Python package to install, and the module to import as a check.
pub(crate) const PACKAGE: &str = "zenoh_ros2_sdk==0.1.8";
pub(crate) const IMPORT: &str = "zenoh_ros2_sdk";
/// The peers, which use no code of jde: a router, a program that drives, and a robot.
const PEER: &str = "drivers/ros2/tests/peers/ros2_peer.py";
/// The tools of ROS 2, which list, show and drive a robot of jde.
const TOOLS: &str = "drivers/ros2/tests/peers/ros2_tools.py";
/// Succeeds where ROS 2 with its Zenoh middleware is sourced.
const SOURCED_CHECK: &str = "command -v ros2 && ros2 pkg prefix rmw_zenoh_cpp && python3 -c 'import rclpy'";
/// An application with both ends of an action.
const ACTIONS: &str = "examples/ros2/fibonacci/app.toml";
/// The schemas of `ros2-arbiter` that connect.
const SOURCES: [&str; 4] = ["robot", "teleop", "docking", "navigation"];
/// The packages of Nav2 that drive a robot.
const NAV2: [&str; 4] = [
    "nav2_planner",
    "nav2_regulated_pure_pursuit_controller",
    "nav2_behaviors",
    "nav2_bt_navigator",
];
/// Why it was not used.
pub(crate) const NOT_SOURCED: &str =
    "no ROS 2 with rmw_zenoh_cpp is sourced in this terminal: source /opt/ros/jazzy/setup.bash";
/// The limit for one run of `jde`.
const LIMIT: &str = "180s";

/// A peer that runs until its standard input closes or this is dropped.
struct Peer {
    process: ChildGuard,
    output: BufReader<ChildStdout>,
}

/// The programs of ROS 2, the library by which they use it, and the port of their router.
struct Peers<'a> {
    context: &'a Context,
    python: &'a Path,
    library: &'static str,
    port: String,
}

/// With an independent implementation, a part of the step `peers`.
pub(crate) fn run(context: &Context, python: &Path) -> Result<()> {
    in_folder(context, || Peers::new(context, python, "sdk")?.run())
}

/// With ROS 2 itself, where it is sourced.
pub(crate) fn step(context: &Context) -> Result<StepOutcome> {
    if !is_sourced() {
        return Ok(StepOutcome::Skipped(NOT_SOURCED.to_owned()));
    }
    in_folder(context, || {
        let peers = Peers::new(context, Path::new("python3"), "rclpy")?;
        peers.run()?;
        peers.run_tools()?;
        let peers = Peers::new(context, Path::new("python3"), "rclpy")?;
        peers.among("restart", &mut peers.jde("ros2", &["topics"]))
    })?;
    Ok(StepOutcome::Passed)
}

/// Whether ROS 2 with its Zenoh middleware is sourced.
pub(crate) fn is_sourced() -> bool {
    shell::succeeds(Command::new("sh").args(["-c", SOURCED_CHECK]))
}

/// What the addresses of drivers begin with in this terminal.
fn prefix() -> &'static str {
    match std::env::var("ROS_DISTRO").as_deref() {
        Ok("humble") => "humble/",
        _ => "",
    }
}

/// Runs something while the folder of the peers exists.
fn in_folder(context: &Context, run: impl FnOnce() -> Result<()>) -> Result<()> {
    let folder = folder(context);
    // A run that was killed may have left files.
    let clear = || match fs::remove_dir_all(&folder) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        Ok(()) | Err(_) => Ok(()),
    };
    clear()?;
    fs::create_dir_all(&folder)?;
    let result = run();
    clear()?;
    result
}

/// The folder for the peers' temporary files. Peers that are killed after a failure cannot remove them.
fn folder(context: &Context) -> PathBuf {
    context.target.join("peers/ros2")
}

impl<'a> Peers<'a> {
    /// Chooses a free port.
    fn new(context: &'a Context, python: &'a Path, library: &'static str) -> Result<Self> {
        Ok(Self {
            context,
            python,
            library,
            port: TcpListener::bind("127.0.0.1:0")?.local_addr()?.port().to_string(),
        })
    }

    fn run(&self) -> Result<()> {
        let _router = Peer::start(self, "router")?;
        // With this range the laser sees the end of the corridor. The program compares the wheels' odometry with
        // it.
        let range = ["--set", "pioneer.laser_range=30"];
        self.among("drive", self.jde("ros2", &["topics"]).args(range))?;
        self.among("arbitrate", &mut self.jde("ros2-arbiter", &SOURCES))?;
        self.serve()
    }

    /// Runs the tools of ROS 2 beside applications.
    fn run_tools(&self) -> Result<()> {
        let _router = Peer::start(self, "router")?;
        let tools = |role| self.python_file(TOOLS, &[role, &self.port]);
        beside(self.context, &mut self.jde("ros2", &["topics"]), tools("robot"))?;
        let jde = self.context.target.join("debug/jde").display().to_string();
        let mut services = self.python_file(TOOLS, &["services", &self.port, &jde]);
        print!(
            "{}",
            shell::read(&mut services).context("the tools of ROS 2 failed")?
        );
        beside(
            self.context,
            &mut self.jde("ros2-arbiter", &SOURCES),
            tools("arbiter"),
        )?;
        python::make(
            &self.context.root,
            &self.context.target,
            lints::build_all(self.context),
            self.context.paint,
        )?;
        let mut application = self.jde(ACTIONS, &["actions"]);
        beside(
            self.context,
            application.arg("--set=ask.order=30"),
            tools("actions"),
        )?;
        let has = |package| shell::succeeds(Command::new("ros2").args(["pkg", "prefix", package]));
        if has("robot_state_publisher") {
            let mut application = self.jde("ros2", &["topics"]);
            beside(
                self.context,
                application.arg("--set=topics.tf_static_topic="),
                tools("frames"),
            )?;
        } else {
            println!("SKIPPED: no robot_state_publisher in this ROS 2, so no frame comes from it");
        }
        if !has("nav2_msgs") {
            println!("SKIPPED: no nav2_msgs in this ROS 2, so no goal of Nav2's action is sent");
            return Ok(());
        }
        let mut application = self.jde("ros2-goals", &["topics", "goals"]);
        beside(self.context, &mut application, tools("goals"))?;
        if !NAV2.iter().all(|package| has(package)) {
            println!("SKIPPED: no Nav2 in this ROS 2, so it drives no robot of jde");
            return Ok(());
        }
        let mut application = self.jde("ros2-nav2", &["topics", "nav2"]);
        application.arg("--set=nav2.target={ pose = [3.55, 2.8, \"90 deg\"], set = true }");
        beside(self.context, &mut application, tools("nav2"))
    }

    /// Runs an application while a ROS 2 program, which has this role, uses it.
    fn among(&self, role: &str, command: &mut Command) -> Result<()> {
        beside(self.context, command, self.command(role))
    }

    /// Drives a robot of ROS 2 with the schemas of safe-navigation.
    fn serve(&self) -> Result<()> {
        let mut robot = Peer::start(self, "serve")?;
        let mut command = self.jde("ros2-robot", &["robot"]);
        shell::show(&command, self.context.paint);
        // It succeeds if the robot has reached all its targets.
        shell::read(&mut command).context("our schemas did not drive the robot of ROS 2")?;
        println!("{}", robot.end()?);
        Ok(())
    }

    /// Returns the command for a ROS 2 program with this role.
    fn command(&self, role: &str) -> Command {
        self.python_file(PEER, &[self.library, role, &self.port])
    }

    fn python_file(&self, file: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(self.python);
        command.arg(self.context.root.join(file)).args(arguments);
        shell::show(&command, self.context.paint);
        command.env("TMPDIR", folder(self.context));
        command
    }

    /// Returns the command for an application, of which these schemas connect to the router.
    fn jde(&self, application: &str, schemas: &[&str]) -> Command {
        let mut command = Command::new(self.context.target.join("debug/jde"));
        command
            .args(["run", application, "--plain", "--for", LIMIT])
            .args(
                schemas
                    .iter()
                    .map(|schema| format!("--set={schema}.connect={}tcp/127.0.0.1:{}", prefix(), self.port)),
            )
            .env_remove("ROS_DOMAIN_ID")
            .current_dir(&self.context.root);
        command
    }
}

/// Runs an application while a ROS 2 program uses it.
fn beside(context: &Context, command: &mut Command, mut program: Command) -> Result<()> {
    shell::show(command, context.paint);
    let application = command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .context("cannot start the application")?;
    let mut application = ChildGuard(application);
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

impl Peer {
    /// Starts a program with this role and waits until it is ready.
    fn start(peers: &Peers<'_>, role: &str) -> Result<Self> {
        let mut process = peers
            .command(role)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .context("cannot start the peer")?;
        let output = process.stdout.take().context("it has no standard output")?;
        let mut peer = Self {
            process: ChildGuard(process),
            output: BufReader::new(output),
        };
        let ready = peer.line()?;
        ensure!(ready == "ready", "the peer printed {ready}");
        Ok(peer)
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
