//! What a person waits for: until a robot moves, until new code moves it, until many plugins are there.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, anyhow, ensure};
use jde_host::reload::{Became, How, Reloader};
use jde_host::{Options, Running};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::Rounds;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use rustix::process::{Pid, Signal, kill_process};

use crate::scope::Scope;
use crate::{loaded, product};

/// Plugins that are loaded one after another.
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
    // What the compiler says of lines is nearly all of a library, and nobody loads it.
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

/// From the start of the process to the first iteration of a schema of it, ns.
fn start(scope: &Scope, folder: &Path) -> Result<f64> {
    let application = folder.join("first.toml");
    fs::write(
        &application,
        "roots = [\"first\"]\n[schemas.first]\ntype = \"bench-000/first\"\n",
    )?;
    let hears = folder.join("hears");
    // It may be there from the last time.
    let _ = fs::remove_file(&hears);
    mknodat(CWD, &hears, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0)?;
    let mut command = product::jde(scope, folder);
    command
        .args(["run", "--plain"])
        .arg(&application)
        .env("JDE_BENCH_FIRST", &hears);
    command.stdout(product::nowhere()?).stderr(product::nowhere()?);
    let start = Instant::now();
    let child = Stopped(command.spawn().context("cannot start `jde run`")?);
    // Ends when the schema has written and closed it.
    let said = fs::read_to_string(&hears)?;
    let took = start.elapsed();
    ensure!(said == "iterated", "{application:?} did not iterate");
    drop(child);
    Ok(took.as_nanos() as f64)
}

/// All of them into a process that has none of them, ns. Libraries stay mapped: each time they are mapped anew.
fn load(files: &[PathBuf], folder: &Path) -> Result<f64> {
    let plugins = loaded::plugins(folder);
    let start = Instant::now();
    for file in files {
        plugins.open(file)?;
    }
    Ok(start.elapsed().as_nanos() as f64)
}

/// A copy of a library in that folder that says nothing of its lines.
fn strip(file: &Path, folder: &Path) -> Result<PathBuf> {
    let to = folder.join(file.file_name().context("a plugin has a name")?);
    let mut strip = Command::new("strip");
    product::read(strip.arg("--strip-debug").arg(file).arg("-o").arg(&to))?;
    Ok(to)
}

/// Builds that take over from each other in real time: the gaps, and what the exchanges took, ns.
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
        // Another build is a file of other content; what is behind the end of a library changes nothing of it.
        let beside = folder.join("beside");
        fs::write(&beside, [&library, format!("build {number}").as_bytes()].concat())?;
        fs::rename(&beside, &file)?;
        let how = How {
            probation: 0,
            fresh: false,
        };
        let reloaded = reloader
            .reload("bench", "act", how)
            .map_err(|refused| anyhow!("{refused}"))?;
        for (name, became) in reloaded.schemas {
            let Became::Reloaded(took) = became else {
                return Err(anyhow!("{name}: {became:?}"));
            };
            gaps.push(took.gap.context("it is awake")? as f64);
            exchanges.push(took.took as f64);
        }
        // Some turns of the new build.
        std::thread::sleep(Duration::from_millis(43));
    }
    Ok((gaps, exchanges))
}

/// A process that is asked to end, and waited for, when dropped.
struct Stopped(Child);

impl Drop for Stopped {
    fn drop(&mut self) {
        if let Some(pid) = Pid::from_raw(self.0.id().cast_signed()) {
            // It may have ended by itself.
            let _ = kill_process(pid, Signal::TERM);
        }
        let _ = self.0.wait();
    }
}
