//! The delays that a user notices: until a robot moves, until new code takes over, until many plugins are
//! loaded.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, anyhow, ensure};
use jde_host::reload::{ReloadOptions, Reloader};
use jde_host::{Options, Running};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::Rounds;
use jde_records::reload::ReloadOutcome;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use rustix::process::{Pid, Signal, kill_process};

use crate::scope::Scope;
use crate::{loaded, product};

/// The number of plugins that are loaded one after another.
const PLUGINS: usize = 100;

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let folder = tempfile::tempdir()?;
    let times = scope.either(3, 15);
    let starts = (0..times)
        .map(|_| start(scope, folder.path()))
        .collect::<Result<_>>()?;
    let files = loaded::copies(scope, PLUGINS, folder.path())?;
    let loads = (0..scope.either(1, 3))
        .map(|_| load(&files, folder.path()))
        .collect::<Result<_>>()?;
    let bytes = fs::metadata(&files[0])?.len();
    // Debug information is nearly all of a library's file, and the loader does not load it.
    let lean = tempfile::tempdir()?;
    let lean_files = files
        .iter()
        .map(|file| strip(file, lean.path()))
        .collect::<Result<Vec<_>>>()?;
    let lean_loads = (0..scope.either(1, 3))
        .map(|_| load(&lean_files, lean.path()))
        .collect::<Result<_>>()?;
    let lean_bytes = fs::metadata(&lean_files[0])?.len();
    let (gaps, exchanges) = reload(scope, folder.path(), times)?;
    let line = |what: &str, times: Vec<f64>, goal: f64| {
        Line::alone(
            what,
            Figure::Time(Rounds::of(times).median()),
            Goal::Below(Figure::millis(goal)),
        )
    };
    Ok(vec![
        line(
            "reload, from the old build's last turn to the new one's first",
            gaps,
            10.0,
        ),
        line("reload, the exchange alone", exchanges, 10.0),
        line("`jde run` to the first iteration", starts, 100.0),
        line(
            &format!("{PLUGINS} plugins loaded, {} each", Figure::Bytes(bytes as f64)),
            loads,
            200.0,
        ),
        line(
            &format!(
                "the same, {} each without lines",
                Figure::Bytes(lean_bytes as f64)
            ),
            lean_loads,
            200.0,
        ),
    ])
}

/// Returns the time from the start of the process to the first iteration of its schema, ns.
fn start(scope: &Scope, folder: &Path) -> Result<f64> {
    let application = folder.join("first.toml");
    fs::write(
        &application,
        "roots = [\"first\"]\n[schemas.first]\ntype = \"bench-000/first\"\n",
    )?;
    let pipe = folder.join("first.pipe");
    // The file of the previous run may exist.
    let _ = fs::remove_file(&pipe);
    mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0)?;
    let mut command = product::jde(scope, folder);
    command
        .args(["run", "--plain"])
        .arg(&application)
        .env("JDE_BENCH_FIRST", &pipe);
    command.stdout(product::nowhere()?).stderr(product::nowhere()?);
    let start = Instant::now();
    let child = Stopped(command.spawn().context("cannot start `jde run`")?);
    // Returns when the schema has written and closed the pipe.
    let message = fs::read_to_string(&pipe)?;
    let took = start.elapsed();
    ensure!(message == "iterated", "{application:?} did not iterate");
    drop(child);
    Ok(took.as_nanos() as f64)
}

/// Returns the time to load all files into a new catalogue, ns. Earlier mappings stay, but each call maps the
/// files anew.
fn load(files: &[PathBuf], folder: &Path) -> Result<f64> {
    let plugins = loaded::plugins(folder);
    let start = Instant::now();
    for file in files {
        plugins.open(file)?;
    }
    Ok(start.elapsed().as_nanos() as f64)
}

/// Copies a library into the folder without its debug information.
fn strip(file: &Path, folder: &Path) -> Result<PathBuf> {
    let to = folder.join(file.file_name().context("a plugin has a name")?);
    let mut strip = Command::new("strip");
    product::read(strip.arg("--strip-debug").arg(file).arg("-o").arg(&to))?;
    Ok(to)
}

/// Reloads builds in real time. Returns the gaps between turns and the durations of the exchanges, ns.
fn reload(scope: &Scope, folder: &Path, times: usize) -> Result<(Vec<f64>, Vec<f64>)> {
    let plugins = Arc::new(loaded::plugins(folder));
    let text = "roots = [\"act\"]\n[schemas.act]\ntype = \"bench-000/act\"\nperiod = \"10ms\"\n";
    let application = loaded::application(text, &plugins)?;
    let running = Running::start(application, &plugins, Options::default())?;
    let reloader = Reloader::new(running.handle(), Arc::clone(&plugins));
    let file = folder.join("libbench_000.so");
    let library = fs::read(loaded::file(scope))?;
    let (mut gaps, mut exchanges) = (Vec::new(), Vec::new());
    for number in 0..times {
        // Another build is a file with other content. Bytes after the end of a library do not change it.
        let beside = folder.join("beside");
        fs::write(&beside, [&library, format!("build {number}").as_bytes()].concat())?;
        fs::rename(&beside, &file)?;
        let options = ReloadOptions {
            probation: 0,
            fresh: false,
        };
        let reloaded = reloader
            .reload("bench", "act", options)
            .map_err(|refused| anyhow!("{refused}"))?;
        for (name, outcome) in reloaded.schemas {
            let ReloadOutcome::Reloaded(took) = outcome else {
                return Err(anyhow!("{name}: {outcome:?}"));
            };
            gaps.push(took.gap.context("the schema is awake")? as f64);
            exchanges.push(took.took as f64);
        }
        // The new build gets some turns.
        std::thread::sleep(Duration::from_millis(43));
    }
    Ok((gaps, exchanges))
}

/// A process that gets SIGTERM and is waited for when dropped.
struct Stopped(Child);

impl Drop for Stopped {
    fn drop(&mut self) {
        if let Some(pid) = Pid::from_raw(self.0.id().cast_signed()) {
            // The process may have ended before.
            let _ = kill_process(pid, Signal::TERM);
        }
        let _ = self.0.wait();
    }
}
