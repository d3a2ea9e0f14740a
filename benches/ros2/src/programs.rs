//! Starts programs of ROS 2 and jde around one router. Measures only their processor time.

use std::ffi::OsStr;
use std::fs::{self, DirBuilder};
use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::os::unix::fs::DirBuilderExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::rc::Rc;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, ensure};
use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

/// The longest time until a program is ready, and until it has ended.
const PATIENCE: Duration = Duration::from_secs(60);
/// The time until all connections are made and used. It is not part of a measurement.
pub(crate) const SETTLING: Duration = Duration::from_secs(4);

/// The places of all programs, and their router's port.
#[derive(Clone)]
pub(crate) struct Programs {
    /// Whether to take a tenth of the time, for less reliable figures.
    pub(crate) quick: bool,
    root: PathBuf,
    built: PathBuf,
    peers: PathBuf,
    pub(crate) port: u16,
    pub(crate) folder: Rc<TempDir>,
    /// The network namespace in which programs start, if any.
    namespace: Option<&'static str>,
    /// The address of the router, and whether it is on another machine.
    address: &'static str,
    is_remote: bool,
}

/// A program that runs until its standard input closes or it is asked to end. It is killed when dropped.
pub(crate) struct Program {
    child: Child,
    output: Receiver<String>,
    /// Its command, for messages.
    pub(crate) name: String,
}

impl Programs {
    pub(crate) fn new(root: PathBuf, built: PathBuf, peers: PathBuf, quick: bool) -> Result<Self> {
        Ok(Self {
            quick,
            root,
            built,
            peers,
            port: TcpListener::bind("127.0.0.1:0")?.local_addr()?.port(),
            folder: Rc::new(tempfile::tempdir()?),
            namespace: None,
            address: "127.0.0.1",
            is_remote: false,
        })
    }

    /// The same programs in a network namespace.
    pub(crate) fn inside(&self, namespace: &'static str) -> Self {
        Self {
            namespace: Some(namespace),
            ..self.clone()
        }
    }

    /// The same programs with the router of another machine.
    pub(crate) fn at(&self, address: &'static str) -> Self {
        Self {
            address,
            is_remote: true,
            ..self.clone()
        }
    }

    /// Returns a command for a program.
    fn command(&self, program: impl AsRef<OsStr>) -> Command {
        match self.namespace {
            None => Command::new(program),
            Some(namespace) => {
                let mut command = Command::new("ip");
                command.args(["netns", "exec", namespace]).arg(program);
                command
            }
        }
    }

    /// Returns one of two times in seconds, by the effort.
    pub(crate) fn seconds(&self, quick: u64, full: u64) -> Duration {
        Duration::from_secs(if self.quick { quick } else { full })
    }

    /// Starts the router, and waits until it listens.
    pub(crate) fn router(&self) -> Result<Program> {
        let mut command = self.command(installed("rmw_zenoh_cpp", "rmw_zenohd")?);
        // Of a namespace, the other machine reaches it too.
        let address = self.namespace.map_or(self.address, |_| "0.0.0.0");
        let listen = format!("listen/endpoints=[\"tcp/{address}:{}\"]", self.port);
        command
            .env("ZENOH_CONFIG_OVERRIDE", listen)
            .env("RUST_LOG", "error")
            .env("ZENOH_ROUTER_CHECK_ATTEMPTS", "-1");
        let program = Program::spawn(&mut command, Stdio::null())?;
        if self.namespace.is_some() {
            thread::sleep(SETTLING);
            return Ok(program);
        }
        let start = Instant::now();
        while TcpStream::connect((self.address, self.port)).is_err() {
            ensure!(start.elapsed() < PATIENCE, "the router does not listen");
            thread::sleep(Duration::from_millis(20));
        }
        Ok(program)
    }

    /// Starts the program of rclcpp in a role.
    pub(crate) fn rclcpp(&self, arguments: &[String]) -> Result<Program> {
        let mut command = self.command(self.peers.join("ros2_peer"));
        command.args(arguments);
        self.start(&mut command)
    }

    /// Starts one of our programs in Python.
    pub(crate) fn python(&self, file: &str, arguments: &[&str]) -> Result<Program> {
        let mut command = self.command("python3");
        let folder = self.root.join("benches/peers/ros2");
        self.start(command.arg(folder.join(file)).args(arguments))
    }

    /// Starts an installed program of ROS 2 that says nothing.
    pub(crate) fn node(&self, package: &str, arguments: &[String]) -> Result<Program> {
        let mut command = self.command(installed(package, package)?);
        Program::spawn(self.connect(command.args(arguments)), Stdio::null())
    }

    fn start(&self, command: &mut Command) -> Result<Program> {
        Program::spawn(self.connect(command), Stdio::piped())?.ready()
    }

    /// Lets a program of ROS 2 use the router.
    fn connect<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        // A router does not pass messages on between peers of two machines.
        let mode = if self.is_remote { "mode=\"client\";" } else { "" };
        let connect = format!("{mode}connect/endpoints=[\"tcp/{}:{}\"]", self.address, self.port);
        // Its warnings would be on the standard output.
        command
            .env("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")
            .env("ZENOH_CONFIG_OVERRIDE", connect)
            .env("RUST_LOG", "error")
    }

    /// Starts an application, which is given as text. What its schemas record is in files that begin with its name.
    pub(crate) fn jde(&self, name: &str, application: &str) -> Result<Program> {
        let file = self.folder.path().join(format!("{name}.toml"));
        fs::write(&file, application)?;
        let private = self.folder.path().join("run");
        // The folder exists after the first call.
        let _ = DirBuilder::new().mode(0o700).create(&private);
        let mut command = self.command(self.built.join("jde"));
        command
            .args(["run", "--plain"])
            .arg(&file)
            .env("JDE_RUNTIME_DIR", private.join("jde"))
            .env("JDE_PLUGIN_PATH", &self.built)
            .env("JDE_BENCH_NOTES", self.folder.path().join(name))
            .current_dir(&self.root);
        Program::spawn(&mut command, Stdio::null())
    }

    /// Returns what a schema of an application that has ended has recorded.
    pub(crate) fn recorded(&self, name: &str, schema: &str) -> Result<String> {
        let file = self.folder.path().join(format!("{name}.{schema}"));
        fs::read_to_string(&file).with_context(|| format!("`{schema}` has recorded nothing"))
    }
}

/// Returns the path of a program of a package of ROS 2.
pub(crate) fn installed(package: &str, program: &str) -> Result<PathBuf> {
    let prefixes = std::env::var("AMENT_PREFIX_PATH").unwrap_or_default();
    let mut files = prefixes
        .split(':')
        .map(|prefix| Path::new(prefix).join("lib").join(package).join(program));
    files
        .find(|file| file.is_file())
        .with_context(|| format!("{package} is not installed in the ROS 2 that is sourced"))
}

impl Program {
    /// Starts a program, and reads its output.
    pub(crate) fn spawn(command: &mut Command, input: Stdio) -> Result<Self> {
        let name = format!("{command:?}");
        let mut child = command
            .stdin(input)
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot start {name}"))?;
        let stdout = child.stdout.take().context("its output is piped")?;
        let (sender, output) = channel();
        thread::spawn(move || read_first_line_then_rest(stdout, &|text| sender.send(text).is_ok()));
        Ok(Self { child, output, name })
    }

    /// Waits until it is ready.
    pub(crate) fn ready(self) -> Result<Self> {
        let line = self.read()?;
        ensure!(line == "ready", "{} printed {line}", self.name);
        Ok(self)
    }

    fn read(&self) -> Result<String> {
        let received = self.output.recv_timeout(PATIENCE);
        received.with_context(|| format!("{} does not say anything", self.name))
    }

    /// Waits for the end of what it does, and returns its output.
    pub(crate) fn output(self) -> Result<String> {
        self.read()
    }

    /// Writes a line to its standard input.
    pub(crate) fn write(&mut self, line: &str) -> Result<()> {
        let input = self.child.stdin.as_mut().context("its input is piped")?;
        // As a whole: the program reads once.
        Ok(input.write_all(format!("{line}\n").as_bytes())?)
    }

    /// Closes its standard input, and returns its output.
    pub(crate) fn end(mut self) -> Result<String> {
        drop(self.child.stdin.take());
        self.read()
    }

    /// Asks it to end, and waits for that.
    pub(crate) fn terminate(mut self) -> Result<()> {
        let pid = Pid::from_child(&self.child);
        kill_process(pid, Signal::TERM)?;
        let start = Instant::now();
        while self.child.try_wait()?.is_none() {
            ensure!(start.elapsed() < PATIENCE, "{} does not end", self.name);
            thread::sleep(Duration::from_millis(10));
        }
        Ok(())
    }

    /// Returns its processor time so far, s.
    pub(crate) fn processor_time(&self) -> Result<f64> {
        let text = fs::read_to_string(format!("/proc/{}/stat", self.child.id()))?;
        // The name may contain blanks; the rest does not.
        let (_, rest) = text.rsplit_once(')').context("stat has no name")?;
        let fields: Vec<&str> = rest.split_whitespace().collect();
        let ticks: u64 = fields[11].parse::<u64>()? + fields[12].parse::<u64>()?;
        Ok(ticks as f64 / rustix::param::clock_ticks_per_second() as f64)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended before.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn read_first_line_then_rest(mut stdout: ChildStdout, send: &dyn Fn(String) -> bool) {
    let mut line = Vec::new();
    let mut byte = [0];
    while let Ok(1) = stdout.read(&mut byte) {
        if byte == *b"\n" {
            break;
        }
        line.push(byte[0]);
    }
    let mut rest = String::new();
    // What is not UTF-8 is no output of these programs, and what is missing is an error of the reader.
    let _ = send(String::from_utf8_lossy(&line).into_owned())
        && stdout.read_to_string(&mut rest).is_ok()
        && send(rest);
}
