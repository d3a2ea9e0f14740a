//! The process that runs the application, and its tools: the real executable, in a folder of its own that
//! isolates it from other applications, with the terminal, the pipes and the disk that its fault needs.

use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use anyhow::{Context as _, Result, bail};
use jde_device::port::Pty;
use rustix::process::{Pid, Signal, kill_process};

use super::log_file;
use crate::campaign::Campaign;
use crate::plan::Kind;

/// The demonstration's lines for its simulated robot and for its roots.
const SIMULATED: &str = "type  = \"sim/robot\"\nworld = \"../worlds/office.toml\"\n";
const ROOTS: &str = "roots   = [\"teleop\", \"example\"]";
/// A root that is never ready by its own precondition, and that only crashes.
const DRIFTER: &str = "\n[schemas.drifter]\ntype = \"fault/motor\"\non = 0\noff = 1\nactuators = { base = \"pioneer.velocity\" }\n";

/// Source of the preloaded library that simulates the disk of a recording.
const DISK: &str = "programs/jde/tests/c/disk.c";
/// Capacity of a small disk, bytes: some seconds of a drive.
const DISK_CAPACITY: &str = "300000";

/// The destination of its output and its recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Environment {
    /// Files.
    Files,
    /// Pipes that no process reads, with much output.
    UnreadPipes,
    /// A terminal of its own, which shows the oscilloscope.
    Terminal,
    /// Files, and a recording on a disk that fails as this setting states.
    Disk(&'static str, &'static str),
}

impl Environment {
    pub(super) fn of(kind: Kind) -> Self {
        match kind {
            Kind::Unread => Self::UnreadPipes,
            Kind::TerminalLost => Self::Terminal,
            Kind::DiskFull => Self::Disk("DISK_ROOM", DISK_CAPACITY),
            Kind::DiskFails => Self::Disk("DISK_BAD_SYNC", "2"),
            _ => Self::Files,
        }
    }
}

/// The process.
pub(super) struct HostProcess {
    process: Child,
    program: PathBuf,
    plugins: std::ffi::OsString,
    folder: tempfile::TempDir,
    /// The controlling end of its terminal, if it has one.
    terminal: Option<Pty>,
}

impl HostProcess {
    /// Starts the demonstration on a robot behind TCP. Only the line of the driver is changed, and a root that
    /// never drives is added.
    pub(super) fn start(campaign: &Campaign, address: &str, environment: Environment) -> Result<Self> {
        let program = program(campaign)?;
        let folder = tempfile::tempdir().context("no folder for a process")?;
        std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o700))?;
        let delivered = campaign.root.0.join("apps/safe-navigation.toml");
        let text = std::fs::read_to_string(&delivered)
            .with_context(|| format!("cannot read {}", delivered.display()))?;
        if !text.contains(SIMULATED) || !text.contains(ROOTS) {
            bail!(
                "{} does not contain the lines that the campaign replaces",
                delivered.display()
            );
        }
        let real =
            format!("type  = \"p2os/pioneer\"\nport  = \"{address}\"\nstart = [3.55, 1.6, \"90deg\"]\n");
        let text = text
            .replace(SIMULATED, &real)
            .replace(ROOTS, "roots   = [\"teleop\", \"drifter\", \"example\"]");
        let file = folder.path().join("safe-navigation.toml");
        std::fs::write(&file, text + DRIFTER)?;
        let mut folders = campaign.plugins.clone();
        folders.extend(std::env::current_exe()?.parent().map(PathBuf::from));
        folders.extend(program.parent().map(PathBuf::from));
        let plugins = std::env::join_paths(folders).context("a folder of plugins has a colon in its name")?;
        let mut terminal = None;
        let application = file.display().to_string();
        let mut command = command(&program, &folder, &plugins);
        match environment {
            Environment::Files => {
                command.args(["run", &application, "--plain"]);
                redirect_output(&mut command, &folder)?;
            }
            Environment::UnreadPipes => {
                command.args(["run", &application, "--plain", "--log", "trace"]);
                command.stdout(Stdio::piped()).stderr(Stdio::piped());
            }
            Environment::Terminal => {
                let pty = Pty::open().context("no terminal for a process")?;
                // From util-linux: the process leads a session of its own, and its input becomes the
                // session's terminal.
                command = self::command(&"setsid".into(), &folder, &plugins);
                command.arg("--ctty").arg(&program).args(["run", &application]);
                let slave = OpenOptions::new().read(true).write(true).open(pty.path())?;
                command
                    .stdin(slave.try_clone()?)
                    .stdout(slave.try_clone()?)
                    .stderr(slave);
                command.env("TERM", "xterm");
                // No process reads the terminal, because a reader would keep it open.
                terminal = Some(pty);
            }
            Environment::Disk(setting, value) => {
                command.args(["run", &application, "--plain", "--record"]);
                command.arg(folder.path().join("drive.mcap"));
                redirect_output(&mut command, &folder)?;
                command.env("LD_PRELOAD", disk(campaign, folder.path())?);
                command.env(setting, value);
            }
        }
        let process = command
            .spawn()
            .with_context(|| format!("cannot start {}", program.display()))?;
        Ok(Self {
            process,
            program,
            plugins,
            folder,
            terminal,
        })
    }

    /// Closes its terminal, like the window of a terminal.
    pub(super) fn hang_up(&mut self) {
        self.terminal = None;
    }

    pub(super) fn signal(&self, signal: Signal) -> Result<()> {
        let process = Pid::from_raw(self.process.id().cast_signed()).context("the process has no id")?;
        kill_process(process, signal).context("the process has ended")
    }

    /// Its process id.
    pub(super) fn number(&self) -> u32 {
        self.process.id()
    }

    /// The names of the schemas that have faulted.
    pub(super) fn faulty(&self) -> Result<Vec<String>> {
        let snapshot: serde_json::Value = serde_json::from_str(&self.jde(&["ps", "--json"])?)?;
        let schemas = find_schemas(&snapshot).into_iter();
        let faulty = schemas.filter(|schema| schema["faults"].as_u64() != Some(0));
        Ok(faulty
            .map(|schema| schema["name"].as_str().unwrap_or("a schema").to_owned())
            .collect())
    }

    /// Whether the process runs.
    pub(super) fn is_running(&mut self) -> bool {
        matches!(self.process.try_wait(), Ok(None))
    }

    /// Kills the process and waits for it.
    pub(super) fn reap(&mut self) {
        // It may have ended before.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }

    /// Runs a verb of the executable to its end.
    pub(super) fn jde(&self, arguments: &[&str]) -> Result<String> {
        let output = command(&self.program, &self.folder, &self.plugins)
            .args(arguments)
            .output()?;
        if !output.status.success() {
            bail!(
                "jde {}: {}",
                arguments.join(" "),
                String::from_utf8_lossy(&output.stderr)
            );
        }
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// Starts a verb that continues, with the given output.
    pub(super) fn client(&self, arguments: &[&str], output: fn() -> Stdio) -> Result<Child> {
        let mut client = command(&self.program, &self.folder, &self.plugins);
        client.args(arguments).stdout(output()).stderr(output());
        client.spawn().context("cannot start a client")
    }

    /// The iterations and the period, ns, of each schema that iterates all the time.
    pub(super) fn turns(&self) -> Result<BTreeMap<String, (u64, u64)>> {
        let snapshot: serde_json::Value = serde_json::from_str(&self.jde(&["ps", "--json"])?)?;
        let mut turns = BTreeMap::new();
        for schema in find_schemas(&snapshot) {
            let (Some(name), Some(iterations), Some(period)) = (
                schema["name"].as_str(),
                schema["iterations"].as_u64(),
                schema["period"].as_u64(),
            ) else {
                continue;
            };
            // The motor schemas below win only at times.
            if ["pioneer", "example"].contains(&name) {
                turns.insert(name.to_owned(), (iterations, period));
            }
        }
        if turns.is_empty() {
            bail!("`jde ps --json` lists no schema of the demonstration: {snapshot}");
        }
        Ok(turns)
    }

    /// The sockets in its folder.
    pub(super) fn sockets(&self) -> Vec<PathBuf> {
        let mut found = Vec::new();
        let mut folders = vec![self.folder.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                let Ok(kind) = entry.file_type() else {
                    continue;
                };
                if kind.is_dir() {
                    folders.push(entry.path());
                } else if std::os::unix::fs::FileTypeExt::is_socket(&kind) {
                    found.push(entry.path());
                }
            }
        }
        found
    }

    /// Whether its error output contains a text.
    pub(super) fn has_logged(&self, text: &str) -> bool {
        std::fs::read_to_string(self.folder.path().join("stderr")).is_ok_and(|log| log.contains(text))
    }

    /// The last lines of its output.
    pub(super) fn output(&self) -> String {
        let read = |name| std::fs::read_to_string(self.folder.path().join(name)).unwrap_or_default();
        let all = read("stdout") + &read("stderr");
        let lines: Vec<&str> = all.lines().rev().take(5).collect();
        lines.into_iter().rev().collect::<Vec<_>>().join(" / ")
    }
}

impl Drop for HostProcess {
    fn drop(&mut self) {
        self.reap();
    }
}

fn redirect_output(command: &mut Command, folder: &tempfile::TempDir) -> Result<()> {
    command.stdout(log_file(folder.path(), "stdout")?);
    command.stderr(log_file(folder.path(), "stderr")?);
    Ok(())
}

/// Builds the disk library; returns its path.
fn disk(campaign: &Campaign, folder: &Path) -> Result<PathBuf> {
    let library = folder.join("disk.so");
    let output = Command::new("cc")
        .args(["-shared", "-fPIC", "-std=c11", "-o"])
        .args([&library, &campaign.root.0.join(DISK)])
        .output()
        .context("no C compiler named cc")?;
    if !output.status.success() {
        bail!(
            "{DISK} cannot be built: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    Ok(library)
}

fn command(program: &PathBuf, folder: &tempfile::TempDir, plugins: &std::ffi::OsStr) -> Command {
    let mut command = Command::new(program);
    command
        .env("JDE_RUNTIME_DIR", folder.path().join("jde"))
        .env("JDE_PLUGIN_PATH", plugins)
        .stdin(Stdio::null());
    command
}

fn program(campaign: &Campaign) -> Result<PathBuf> {
    let next_to_this = || Some(std::env::current_exe().ok()?.parent()?.join("jde"));
    let program = campaign
        .jde
        .clone()
        .or_else(next_to_this)
        .filter(|program| program.is_file());
    program.context("there is no `jde` beside this program; `cargo build --release --workspace` builds it")
}

fn find_schemas(reply: &serde_json::Value) -> Vec<&serde_json::Value> {
    let schemas = reply
        .get("schemas")
        .or_else(|| reply.get("snapshot").and_then(|snapshot| snapshot.get("schemas")));
    schemas
        .and_then(|schemas| schemas.as_array())
        .into_iter()
        .flatten()
        .collect()
}
