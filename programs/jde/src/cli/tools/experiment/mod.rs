//! `jde experiment`: drives an application many times, judges each drive, and reports.

mod merge;
mod progress;
mod results;
mod single;
pub(crate) mod table;

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::{Args, Subcommand, ValueHint};
use jde_core::Nanos;
use jde_experiment::applications::Applications;
use jde_experiment::comparison::Comparison;
use jde_experiment::folder::{Existing, FolderError, FolderState, ResultsFolder};
use jde_experiment::pool::{self, PoolExperiment, PoolOptions, Task};
use jde_experiment::result::{DriveResult, Outcome};
use jde_experiment::worker::WorkerArguments;
use jde_experiment::{Experiment, file};
use jde_session::log::Filter;
use jde_session::paths;
use jde_terminal as terminal;
use jde_terminal::interrupt::SignalListener;

use crate::child;
use crate::extensions::RecordOptions;
use crate::failure::{Failure, display_path};
use crate::quantity;
use progress::Progress;
use results::Results;

/// Drive an application many times, judge and measure each drive, and report.
///
/// The experiment is a file: what varies, what must hold, what is measured. Each drive runs in virtual time,
/// so the same file gives the same results on any number of processors. The results are a table on the
/// terminal, and results.jsonl, results.csv, junit.xml and report.html in the folder of --out. The exit
/// status is 0 if every drive passed, and 1 if one failed.
#[derive(Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Examples:
  jde experiment safe-navigation
  jde experiment tune.toml --out results --jobs 2
  jde experiment tune.toml --out results --resume             after Ctrl-C
  jde experiment tune.toml --drive 17 --record drive.mcap     one drive again; then: jde view drive.mcap
  jde experiment tune.toml --shard 3/16 --out part-3          a sixteenth, on one of several machines
  jde experiment merge part-* --out results"
)]
pub(crate) struct ExperimentVerb {
    #[command(subcommand)]
    action: Option<ExperimentAction>,
    /// The experiment's file, or the name of one in the folder experiments.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath, required = true)]
    file: Option<PathBuf>,
    /// Drive this application instead of the one that the file names, as jde test --application does.
    #[arg(long, value_name = "APP.toml", value_hint = ValueHint::FilePath, requires = "drive")]
    application: Option<PathBuf>,
    /// The folder of the results; results/NAME if left out, whose earlier results are kept in
    /// results/NAME.before.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath, conflicts_with = "drive")]
    out: Option<PathBuf>,
    /// Replace results that the folder holds.
    #[arg(long = "replace", conflicts_with_all = ["resume", "drive"])]
    replace: bool,
    /// Go on where an earlier call was interrupted.
    #[arg(long, conflicts_with = "drive")]
    resume: bool,
    /// Processes at a time; one for each processor if left out.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// The longest time of the machine that a drive may take; a longer one counts as `hung`.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time,
          default_value = "60s")]
    limit: Nanos,
    /// The most memory of a process; a drive that needs more counts as `crashed`.
    #[arg(long, value_name = "SIZE", value_parser = quantity::size, default_value = "2GB")]
    memory: usize,
    /// Run one part of several of the same size.
    #[arg(long, value_name = "K/N", conflicts_with = "drive")]
    shard: Option<Shard>,
    /// Run one drive again, here, and print what happened.
    #[arg(long, value_name = "N")]
    drive: Option<usize>,
    /// The seed of the drive, in place of its own.
    #[arg(long, value_name = "N", allow_negative_numbers = true, requires = "drive")]
    seed: Option<u64>,
    /// End standard output with one line of JSON; all other text goes to standard error.
    #[arg(long)]
    json: bool,
    /// Record the drive to this MCAP file.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, requires = "drive")]
    record: Option<PathBuf>,
    /// Overwrite an existing recording.
    #[arg(long, requires = "record")]
    overwrite: bool,
}

#[derive(Subcommand)]
enum ExperimentAction {
    /// Join the results of the parts of an experiment.
    Merge(merge::Merge),
}

/// One part of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shard([usize; 2]);

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(number, of)| {
            let parts = [number.trim().parse().ok()?, of.trim().parse().ok()?];
            (1 <= parts[0] && parts[0] <= parts[1]).then_some(parts)
        });
        parts.map(Self).ok_or_else(|| {
            format!("`{text}` is not a part; write its number and the number of parts, such as 3/16")
        })
    }
}

impl ExperimentVerb {
    /// Runs the verb.
    pub(super) fn run(self, filter: Option<Filter>) -> Result<(), Failure> {
        if let Some(ExperimentAction::Merge(merge)) = self.action {
            return merge.run();
        }
        let given = self.file.as_deref().unwrap_or(Path::new(""));
        let path = paths::find_experiment(given)?;
        let (experiment, mut applications) = read(&path, self.application.as_deref())?;
        if let Some(drive) = self.drive {
            let record = self.record.map(|file| RecordOptions {
                file,
                patterns: Vec::new(),
                overwrite: self.overwrite,
                panels: None,
                trigger: None,
                split: None,
                log: None,
            });
            return single::run(
                &experiment,
                (drive, self.seed),
                &mut applications,
                record,
                filter,
                self.json,
            );
        }
        let shards: BTreeSet<_> = self.shard.into_iter().map(|Shard(shard)| shard).collect();
        let state = FolderState::new(&experiment, &mut applications, shards)?;
        let existing = match (&self.out, self.resume, self.replace) {
            (_, true, _) => Existing::Resume,
            (_, _, true) => Existing::Replace,
            (None, false, false) => Existing::SetAside,
            (Some(_), false, false) => Existing::Refuse,
        };
        let folder = self
            .out
            .clone()
            .unwrap_or_else(|| Path::new("results").join(&experiment.name));
        let (folder, results) =
            ResultsFolder::prepare(&folder, &state, &experiment, existing).map_err(folder_failure)?;
        if let Some(before) = &folder.before {
            writeln!(
                terminal::err(),
                "the results of before are in {}",
                display_path(before)
            )?;
        }
        let done: BTreeSet<_> = results.iter().map(|result| result.drive).collect();
        let own = state.own_drives();
        let drives: Vec<_> = own
            .iter()
            .copied()
            .filter(|drive| !done.contains(drive))
            .collect();
        let results = self.run_drives(&experiment, &state, folder, results, &drives)?;
        let missing = own.len() - results.results.len();
        conclude(&results, &path, self.json, missing)
    }

    fn run_drives<'e>(
        &self,
        experiment: &'e Experiment,
        state: &FolderState,
        mut folder: ResultsFolder,
        mut results: Vec<DriveResult>,
        drives: &[usize],
    ) -> Result<Results<'e>, Failure> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopping = Arc::clone(&stop);
        let _interrupts = SignalListener::on_first(move || stopping.store(true, Ordering::Relaxed))?;
        let options = PoolOptions {
            jobs: self.jobs.map_or_else(processors, usize::from),
            limit: Duration::from_nanos(self.limit),
            stop: &stop,
            abort: &AtomicBool::new(false),
        };
        let mut progress = Progress::new(results.len() + drives.len(), &results);
        let (fingerprint, memory) = (&state.fingerprint, self.memory as u64);
        let ran = run_drives(experiment, fingerprint, memory, drives, &options, |result| {
            folder.add(&result, experiment)?;
            progress.add(&result)?;
            results.push(result);
            Ok(())
        });
        progress.finish()?;
        let results = Results::new(experiment, folder.path(), results);
        // What is known is kept, whatever happened.
        results.write().map_err(Failure::file(folder.path()))?;
        ran?;
        Ok(results)
    }
}

/// Runs drives of an experiment in processes with at most so many bytes of memory, and calls `on_result` with each result.
///
/// # Errors
/// As of [`pool::run`].
pub(crate) fn run_drives(
    experiment: &Experiment,
    fingerprint: &str,
    memory: u64,
    drives: &[usize],
    options: &PoolOptions<'_>,
    mut on_result: impl FnMut(DriveResult) -> io::Result<()>,
) -> io::Result<()> {
    let arguments = WorkerArguments {
        file: experiment.file.clone(),
        application: experiment.application.clone(),
        fingerprint: fingerprint.to_owned(),
        memory,
    };
    let experiments = [PoolExperiment {
        experiment,
        program: child::drives(&arguments),
    }];
    let task = |drive: &usize| Task {
        experiment: 0,
        drive: *drive,
        seed: None,
    };
    let tasks: Vec<_> = drives.iter().map(task).collect();
    pool::run(&experiments, &tasks, options, |_, result| on_result(result))
}

/// Reads an experiment for its drives, of another application if one is given, and inspects its plugins.
pub(crate) fn read(path: &Path, application: Option<&Path>) -> Result<(Experiment, Applications), Failure> {
    let with_inspector = |application| Applications::new(application, Some(jde_session::child::inspector()));
    let read = file::read(path, application, with_inspector).map_err(Failure::faults)?;
    if let Some(concerns) = &read.0.concerns {
        jde_session::failure::warn(concerns);
    }
    Ok(read)
}

pub(crate) fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn folder_failure(error: FolderError) -> Failure {
    let help = match &error {
        FolderError::Occupied(_) => {
            "go on with --resume, replace them with --replace, or name another folder with --out"
        }
        FolderError::Other { .. } => "name another folder with --out, or replace the results with --replace",
        FolderError::Empty(_) => "name the folder that `jde experiment` wrote with --out",
        FolderError::File { .. } | FolderError::Damaged(_) => return Failure::broken(error.to_string()),
    };
    Failure::usage(error.to_string(), help)
}

/// Prints the tables and where the results are. Fails unless every drive passed.
fn conclude(results: &Results<'_>, file: &Path, json: bool, missing: usize) -> Result<(), Failure> {
    let mut output = terminal::text_out(json);
    let columns = &results.experiment.columns;
    let comparison = Comparison::of(columns, &results.results);
    table::write(&mut *output, columns, &comparison, terminal::width())?;
    writeln!(output)?;
    writeln!(output, "{}", display_path(&results.folder.join("report.html")))?;
    output.flush()?;
    if json {
        jde_session::cli::print_json(&results.counts())?;
    }
    if missing > 0 {
        return Err(Failure::broken(format!(
            "interrupted with {missing} drives left; go on with: jde experiment {} --out {} --resume",
            display_path(file),
            display_path(&results.folder),
        )));
    }
    let all_passed = results
        .results
        .iter()
        .all(|result| result.outcome == Outcome::Passed);
    if all_passed {
        Ok(())
    } else {
        Err(Failure::mission())
    }
}
