//! The example for Dask with a scheduler and two workers, one of which is killed in the middle of a part with
//! all that it runs, as if its machine had lost its power.

use std::fs;
use std::process::Command;

use anyhow::{Result, bail, ensure};

use super::{FILE, OUT_FOLDER, PART_COUNT, Trial, kill, poll, processes_with};
use crate::python::Environment;
use crate::shell;
use crate::step::StepOutcome;
use crate::test::Context;

const ENVIRONMENT: Environment = Environment {
    folder: "dask",
    packages: &["distributed==2026.8.0"],
    imports: &["distributed"],
};
const EXAMPLE: &str = "examples/clusters/dask_experiment.py";
/// What the scheduler writes, and by which the others find it.
const SCHEDULER: [&str; 2] = ["--scheduler-file", "scheduler.json"];
/// A worker runs one part at a time, in the process that is started.
const WORKER: &[&str] = &["--nthreads", "1", "--no-nanny"];
/// The variable by which the worker that is killed, and what it runs, are recognized.
const VICTIM: &str = "JDE_CLUSTER_VICTIM";

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if !shell::succeeds(Command::new("python3").args(["-c", "import ensurepip"])) {
        return context.missing_tool("Python with venv", "sudo apt-get install python3-venv");
    }
    let python = ENVIRONMENT.interpreter(&context.target, context.paint)?;
    let trial = Trial::start(context, "dask")?;
    let dask = |role: &str| {
        let mut command = Command::new(python.with_file_name("dask"));
        command
            .args([role, "--host", "127.0.0.1", "--no-dashboard"])
            .args(SCHEDULER);
        command
    };
    let _scheduler = trial.spawn("scheduler", dask("scheduler").args(["--port", "0"]))?;
    let mut victim = trial.spawn("victim", dask("worker").args(WORKER).env(VICTIM, &trial.folder))?;
    let _survivor = trial.spawn("survivor", dask("worker").args(WORKER))?;
    poll("the workers", || {
        let log = |name| fs::read_to_string(trial.folder.join(name)).unwrap_or_default();
        let is_ready = |name| log(name).contains("Registered to");
        Ok((is_ready("victim.log") && is_ready("survivor.log")).then_some(()))
    })?;
    let mut example = Command::new(&python);
    example
        .arg(context.root.join(EXAMPLE))
        .args([FILE, OUT_FOLDER, "--parts", &PART_COUNT.to_string()])
        .args(SCHEDULER);
    let mut example = trial.spawn("example", &mut example)?;

    let is_under_way = |part: &usize| trial.has_begun(*part) && !trial.has_ended(*part);
    let under_way: Vec<usize> = poll("two parts under way, one on each worker", || {
        if let Some(status) = example.0.try_wait()? {
            bail!("the example ended with {status}");
        }
        let parts: Vec<usize> = (1..=PART_COUNT).filter(is_under_way).collect();
        Ok((parts.len() == 2).then_some(parts))
    })?;
    kill(&processes_with(
        "environ",
        &format!("{VICTIM}={}", trial.folder.display()),
    )?);
    println!("killed a worker: {}", victim.0.wait()?);
    ensure!(
        under_way.iter().all(is_under_way),
        "a part ended before the worker was killed"
    );
    let status = poll("the end of the example", || Ok(example.0.try_wait()?))?;
    ensure!(status.success(), "the example ended with {status}");
    trial.compare()?;
    Ok(StepOutcome::Passed)
}
