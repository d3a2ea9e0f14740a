//! `jde test`: runs the tests of an application.

pub(crate) mod report;
mod watch;

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use clap::{Args, ValueHint};
use jde_core::Nanos;
use jde_experiment::Experiment;
use jde_experiment::folder;
use jde_experiment::pool::{self, PoolExperiment, PoolOptions, Task};
use jde_experiment::result::DriveResult;
use jde_experiment::worker::WorkerArguments;
use jde_terminal::interrupt::SignalListener;

use super::experiment::{processors, read};
use crate::child;
use crate::failure::{Failure, display_path};
use crate::quantity;
use report::Report;

/// Run the tests of an application: files in the form of an experiment, one drive each.
///
/// A test drives the application in virtual time and judges what must hold; its `name` is a sentence. A test
/// that fails prints why, the selections that led to it, and the command that shows it. The exit status is 0
/// if every test passed, 1 if one failed, 2 if a file has faults or there is no such test.
#[derive(Args)]
#[command(after_help = "Examples:
  jde test                                  all of the folder tests
  jde test tests/doors.toml --watch         again after every change of the test, its application or a plugin
  jde test limits --application ana/app.toml       the same tests for another application
  jde test --filter door --shuffle          with new seeds each time; a failure prints its seed")]
pub(crate) struct Test {
    /// Files of tests, or folders of them.
    #[arg(value_name = "PATH", value_hint = ValueHint::AnyPath, default_value = "tests")]
    paths: Vec<PathBuf>,
    /// Test this application instead of the one that each file names.
    #[arg(long, value_name = "APP.toml", value_hint = ValueHint::FilePath)]
    application: Option<PathBuf>,
    /// Run only the tests whose name or file contains this text.
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// Run each test with another seed than its own: chosen anew each time, or from this one.
    #[arg(long, value_name = "SEED", num_args = 0..=1, require_equals = true)]
    shuffle: Option<Option<u64>>,
    /// Run the tests again after every change, until Ctrl-C.
    #[arg(long, conflicts_with = "json")]
    watch: bool,
    /// Processes at a time; one for each processor if left out.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// The longest time of the machine that a test may take.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time,
          default_value = "60s")]
    limit: Nanos,
    /// End standard output with one line of JSON; all other text goes to standard error.
    #[arg(long)]
    json: bool,
}

/// A file of tests.
pub(crate) struct TestFile {
    pub(crate) experiment: Experiment,
    fingerprint: String,
    /// The files on which its results depend.
    files: BTreeSet<PathBuf>,
}

/// The most memory of a test's process, bytes: that of a drive of an experiment.
const MEMORY: u64 = 2_000_000_000;

impl Test {
    /// Runs the verb.
    pub(super) fn run(self) -> Result<(), Failure> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopping = Arc::clone(&stop);
        let _interrupts = SignalListener::on_first(move || stopping.store(true, Ordering::Relaxed))?;
        if !self.watch {
            let tests = read_tests(&find(&self.paths)?, self.application.as_deref())?;
            return self.run_tests(&tests, &stop);
        }
        watch::until(&stop, || {
            // Files that were found and cannot be read are watched too: the author is about to correct them.
            let found = find(&self.paths);
            let mut watched: BTreeSet<PathBuf> = found.iter().flatten().cloned().collect();
            let result = found.and_then(|files| {
                let tests = read_tests(&files, self.application.as_deref())?;
                watched.extend(tests.iter().flat_map(|test| test.files.iter().cloned()));
                self.run_tests(&tests, &stop)
            });
            if let Err(failure) = result {
                let _ = failure.report();
            }
            watched
        })?;
        Ok(())
    }

    fn run_tests(&self, tests: &[TestFile], stop: &AtomicBool) -> Result<(), Failure> {
        let seed = self.shuffle.map(|seed| seed.unwrap_or_else(seed_of_the_clock));
        let tasks = tasks(tests, self.filter.as_deref(), seed)?;
        let options = PoolOptions {
            jobs: self.jobs.map_or_else(processors, usize::from),
            limit: Duration::from_nanos(self.limit),
            stop,
            abort: &AtomicBool::new(false),
        };
        let mut report = Report::begin(tasks.len(), seed, self.application.as_deref(), self.json)?;
        run_tasks(tests, &tasks, &options, |task, result| {
            report.add(&tests[task.experiment].experiment, task, result)
        })?;
        report.finish(tasks.len())
    }
}

/// Returns the files of all tests in files and folders, in order.
///
/// # Errors
/// There is none.
pub(crate) fn find(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for path in paths {
        if path.is_file() {
            files.push(path.clone());
        }
        if !path.is_dir() {
            continue;
        }
        let entries = fs::read_dir(path).map_err(Failure::file(path))?;
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        let mut tests: Vec<_> = paths
            .filter(|path| path.extension().is_some_and(|end| end == "toml"))
            .collect();
        tests.sort();
        files.extend(tests);
    }
    if files.is_empty() {
        let folders: Vec<_> = paths.iter().map(|path| display_path(path)).collect();
        return Err(Failure::usage(
            format!("there is no test in {}", folders.join(", ")),
            "a test is a file tests/NAME.toml; `jde new app` writes two, and docs/testing.md describes them",
        ));
    }
    Ok(files)
}

/// Reads files of tests, of another application if one is given, and inspects their plugins.
///
/// # Errors
/// The faults of the first file that has some.
pub(crate) fn read_tests(files: &[PathBuf], application: Option<&Path>) -> Result<Vec<TestFile>, Failure> {
    files.iter().map(|file| read_test(file, application)).collect()
}

/// Returns the drives of the tests whose name or file contains the text. With a seed, each has another one.
///
/// # Errors
/// No test contains the text.
pub(crate) fn tasks(
    tests: &[TestFile],
    filter: Option<&str>,
    seed: Option<u64>,
) -> Result<Vec<Task>, Failure> {
    let is_wanted = |test: &TestFile| {
        let text = format!("{} {}", test.experiment.name, test.experiment.file.display());
        filter.is_none_or(|filter| text.contains(filter))
    };
    if let Some(filter) = filter
        && !tests.iter().any(is_wanted)
    {
        let names = tests.iter().map(|test| test.experiment.name.as_str());
        return Err(Failure::unknown(
            "test whose name or file contains",
            filter,
            names,
        ));
    }
    let wanted = tests.iter().enumerate().filter(|(_, test)| is_wanted(test));
    let drives =
        wanted.flat_map(|(place, test)| (0..test.experiment.drives()).map(move |drive| (place, drive)));
    let numbered = drives.enumerate().map(|(number, (experiment, drive))| Task {
        experiment,
        drive,
        seed: seed.map(|seed| seed.wrapping_add(number as u64)),
    });
    Ok(numbered.collect())
}

/// Runs drives of tests, and calls `on_result` with each result.
///
/// # Errors
/// As of [`pool::run`].
pub(crate) fn run_tasks(
    tests: &[TestFile],
    tasks: &[Task],
    options: &PoolOptions<'_>,
    on_result: impl FnMut(Task, DriveResult) -> io::Result<()>,
) -> io::Result<()> {
    let experiments: Vec<_> = tests
        .iter()
        .map(|test| PoolExperiment {
            experiment: &test.experiment,
            program: child::drives(&WorkerArguments {
                file: test.experiment.file.clone(),
                application: test.experiment.application.clone(),
                fingerprint: test.fingerprint.clone(),
                memory: MEMORY,
            }),
        })
        .collect();
    pool::run(&experiments, tasks, options, on_result)
}

fn read_test(file: &Path, application: Option<&Path>) -> Result<TestFile, Failure> {
    let (experiment, mut applications) = read(file, application)?;
    Ok(TestFile {
        fingerprint: folder::fingerprint(&experiment, &mut applications)?,
        files: folder::files(&experiment, &mut applications)?,
        experiment,
    })
}

/// Returns a seed that differs from one call to the next.
fn seed_of_the_clock() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    // Few digits, because people type it again.
    (now.as_nanos() / 1000 % 1_000_000) as u64
}
