//! Experiments on clusters: the examples of `docs/clusters.md`, each with the engine that it is for, on this
//! machine. The results must be those of one call of `jde experiment`, to the bit, though a process is killed
//! in the middle. No engine that is installed here is used or changed: each has ports and a folder of its own.

pub(crate) mod dask;
pub(crate) mod slurm;

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};

use crate::shell::{self, ChildGuard};
use crate::test::Context;

/// Short drives whose results differ.
const EXPERIMENT: &str = r#"application = "APPLICATION"
for         = "20s"
mission     = "ignored"

[axes]
seeds = "1..60"

[set]
"pioneer.wheel_error" = 0.05

[must."no collision"]
never = "collisions > 0"

[measure]
nearest  = "clearance"
distance = "distance"
"#;
/// The file of the experiment, in the folder of a trial.
const FILE: &str = "drives.toml";
/// The folders of one machine's results and of the cluster's.
const LOCAL_FOLDER: &str = "local";
const OUT_FOLDER: &str = "out";
/// The parts, of 15 drives each: enough that a process can be killed between the first result and the last.
const PART_COUNT: usize = 4;
/// The limit of each wait: twenty times what a whole trial takes.
const TRIAL_TIMEOUT: Duration = Duration::from_secs(600);
/// The time between two looks at the same thing.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// The variable by which the processes of a trial are recognized; its value is the trial's folder.
const MARK: &str = "JDE_CLUSTER_TRIAL";

/// One cluster on this machine. Its processes, and those that they started, are killed when it is dropped.
struct Trial<'c> {
    context: &'c Context,
    folder: PathBuf,
    /// The variables of its processes.
    variables: Vec<(&'static str, OsString)>,
}

impl<'c> Trial<'c> {
    /// Runs the experiment on this machine alone, in an empty folder.
    fn start(context: &'c Context, name: &str) -> Result<Self> {
        let folder = context.target.join("clusters").join(name);
        let programs = context.target.join("debug");
        // The path of most users lacks the folder of daemons.
        let path = std::env::var("PATH").unwrap_or_default();
        let path = format!("{}:{path}:/usr/sbin", programs.display());
        let variables = vec![
            ("PATH", path.into()),
            ("JDE_PLUGIN_PATH", programs.into()),
            (MARK, folder.clone().into()),
        ];
        let trial = Self {
            context,
            folder,
            variables,
        };
        // A run that was killed may have left processes and files.
        trial.end_processes()?;
        if let Err(error) = fs::remove_dir_all(&trial.folder)
            && error.kind() != io::ErrorKind::NotFound
        {
            return Err(error).with_context(|| format!("cannot empty {}", trial.folder.display()));
        }
        fs::create_dir_all(&trial.folder)?;
        let application = context.root.join("apps/safe-navigation.toml");
        let text = EXPERIMENT.replace("APPLICATION", &application.display().to_string());
        fs::write(trial.folder.join(FILE), text)?;
        trial.read(Command::new("jde").args(["experiment", FILE, "--out", LOCAL_FOLDER]))?;
        Ok(trial)
    }

    /// Runs a command in the trial's folder. Returns its standard output.
    fn read(&self, command: &mut Command) -> Result<String> {
        shell::show(command, self.context.paint);
        shell::read_within(self.prepare(command), TRIAL_TIMEOUT)
    }

    /// Starts a process in the trial's folder. Its output goes to `NAME.log`.
    fn spawn(&self, name: &str, command: &mut Command) -> Result<ChildGuard> {
        shell::show(command, self.context.paint);
        let log = File::create(self.folder.join(name).with_extension("log"))?;
        let child = self
            .prepare(command)
            .stdin(Stdio::null())
            .stdout(log.try_clone()?)
            .stderr(log)
            .spawn();
        Ok(ChildGuard(child.with_context(|| format!("cannot start {name}"))?))
    }

    /// Lets a command run in the trial's folder with the trial's variables, which mark its process.
    fn prepare<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        command
            .envs(self.variables.iter().cloned())
            .current_dir(&self.folder)
    }

    /// Returns the folder of a part.
    fn part(&self, part: usize) -> PathBuf {
        self.folder
            .join(OUT_FOLDER)
            .join(format!("part-{part}-of-{PART_COUNT}"))
    }

    /// Whether a part has a result.
    fn has_begun(&self, part: usize) -> bool {
        fs::read(self.part(part).join("results.jsonl")).is_ok_and(|text| text.contains(&b'\n'))
    }

    /// Whether all results of a part are written.
    fn has_ended(&self, part: usize) -> bool {
        self.part(part).join("report.html").exists()
    }

    /// Compares the cluster's results with those of one machine.
    fn compare(&self) -> Result<()> {
        for file in ["results.jsonl", "results.csv", "junit.xml", "report.html"] {
            let (local, cluster) = (
                Path::new(LOCAL_FOLDER).join(file),
                Path::new(OUT_FOLDER).join("all").join(file),
            );
            let read = |path: &Path| {
                let path = self.folder.join(path);
                fs::read(&path).with_context(|| format!("cannot read {}", path.display()))
            };
            ensure!(
                read(&local)? == read(&cluster)?,
                "{} and {} in {} differ",
                local.display(),
                cluster.display(),
                self.folder.display()
            );
        }
        println!("the results are those of one machine, to the bit");
        Ok(())
    }

    /// Kills the processes of this trial: those that it started, and those that these started.
    fn end_processes(&self) -> Result<()> {
        let mark = format!("{MARK}={}", self.folder.display());
        poll("the end of the trial's processes", || {
            let processes = processes(|process| {
                let variables = fs::read(process.join("environ")).unwrap_or_default();
                contains(&variables, &mark) || self.is_daemon(process)
            })?;
            kill(&processes);
            Ok(processes.is_empty().then_some(()))
        })
    }

    /// Whether a process is a daemon of Slurm in the trial's folder. Some write their titles over their variables.
    fn is_daemon(&self, process: &Path) -> bool {
        let linked = |link| fs::read_link(process.join(link)).unwrap_or_default();
        // The system appends a remark to the name of a deleted folder.
        let place = linked("cwd").display().to_string();
        let program = linked("exe");
        let program = program.file_name().unwrap_or_default();
        program.as_encoded_bytes().starts_with(b"slurm")
            && place.starts_with(&self.folder.display().to_string())
    }
}

impl Drop for Trial<'_> {
    fn drop(&mut self) {
        if let Err(error) = self.end_processes() {
            println!("{error:#}");
        }
    }
}

/// Returns the processes whose folder in `/proc` is accepted. A process may end meanwhile, and the files of other
/// users' processes cannot be read.
fn processes(is_accepted: impl Fn(&Path) -> bool) -> Result<Vec<String>> {
    let mut found = Vec::new();
    for entry in fs::read_dir("/proc")? {
        let path = entry?.path();
        if is_accepted(&path) {
            found.extend(path.file_name().and_then(|id| id.to_str()).map(str::to_owned));
        }
    }
    Ok(found)
}

/// Returns the processes with this text among their variables (`environ`) or arguments (`cmdline`).
fn processes_with(file: &str, text: &str) -> Result<Vec<String>> {
    processes(|process| contains(&fs::read(process.join(file)).unwrap_or_default(), text))
}

/// Whether a text is one of several that end with a zero.
fn contains(texts: &[u8], text: &str) -> bool {
    texts.split(|byte| *byte == 0).any(|part| part == text.as_bytes())
}

/// Kills processes, which may have ended before.
fn kill(processes: &[String]) {
    if !processes.is_empty() {
        shell::succeeds(Command::new("kill").arg("-KILL").args(processes));
    }
}

/// Calls `look` until it returns something.
fn poll<T>(what: &str, mut look: impl FnMut() -> Result<Option<T>>) -> Result<T> {
    let begun = Instant::now();
    loop {
        if let Some(found) = look()? {
            return Ok(found);
        }
        if begun.elapsed() > TRIAL_TIMEOUT {
            bail!("{what} did not come within {TRIAL_TIMEOUT:?}");
        }
        thread::sleep(POLL_INTERVAL);
    }
}
