//! Tools that check applications and drive them in the simulator. They move no robot and write no file.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use jde_app::Override;
use jde_experiment::Experiment;
use jde_experiment::comparison::Comparison;
use jde_experiment::folder;
use jde_experiment::pool::PoolOptions;
use jde_experiment::result::{DriveResult, Outcome};
use jde_session::{load, paths};
use jde_terminal::escape::without_styles;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::Call;
use crate::cli::tools::experiment::{self, table};
use crate::cli::tools::test;
use crate::cli::tools::test::report::test_name;
use crate::failure::{Failure, RunFailure};
use crate::inspect;
use crate::mcp::answer::Answer;

/// The longest time of a drive, of the machine.
const DRIVE_LIMIT: Duration = Duration::from_secs(60);
/// The most memory of the process of a drive, bytes.
const DRIVE_MEMORY: u64 = 2_000_000_000;
/// The most drives that are listed one by one: those that did not pass first.
const MAX_LISTED: usize = 50;

/// An application to check.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Check {
    /// The application's file in the folder of this server, or the name of one that comes with jde.
    file: String,
    /// Other values of modulations: "goon.fast=0.3 m/s".
    #[serde(default)]
    set: Vec<String>,
}

/// Tests to run.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Tests {
    /// Files of tests, or folders of them, in the folder of this server.
    paths: Vec<String>,
    /// Run only the tests whose name or file contains this text.
    filter: Option<String>,
}

/// An experiment to run.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ExperimentFile {
    /// The experiment's file in the folder of this server, or the name of one that comes with jde.
    file: String,
}

pub(super) fn check(call: &Call<'_>, arguments: Check) -> Result<Answer, Failure> {
    let folder = &call.session.folder;
    let file = folder.resolve_named(&arguments.file, paths::find_application)?;
    let set = arguments.set.iter().map(|text| text.parse::<Override>());
    let set = set
        .collect::<Result<Vec<_>, _>>()
        .map_err(|error| Failure::broken(error.to_string()))?;
    let application = match load::check(&file, &set) {
        Ok(application) => application,
        Err(RunFailure::Application { faults, .. }) => {
            return Answer::new(&json!({"is_usable": false, "faults": list(&faults)}));
        }
        Err(other) => return Err(other.into()),
    };
    let mut text = Vec::new();
    inspect::application(&application, &mut text)?;
    let text = without_styles(&String::from_utf8_lossy(&text));
    let absent = application.concerns.as_ref().map(list);
    let warnings = inspect::warnings(&application).as_ref().map(list);
    Answer::new(
        &json!({"is_usable": true, "absent_at_present": absent, "warnings": warnings, "application": text}),
    )
}

/// Returns faults with the lines that have them.
fn list(faults: &jde_app::Faults) -> Vec<String> {
    faults.list().iter().map(|fault| format!("{fault:#}")).collect()
}

pub(super) fn test(call: &Call<'_>, arguments: Tests) -> Result<Answer, Failure> {
    let paths = arguments
        .paths
        .iter()
        .map(|path| call.session.folder.resolve(path));
    let paths = paths.collect::<Result<Vec<PathBuf>, _>>()?;
    let files = test::find(&paths)?;
    call.session
        .folder
        .check_all(files.iter().map(PathBuf::as_path))?;
    let tests = test::read_tests(&files, None)?;
    let tasks = test::tasks(&tests, arguments.filter.as_deref(), None)?;
    let mut listed = Vec::new();
    let (stop, options) = (AtomicBool::new(false), |stop| options(call, stop));
    test::run_tasks(&tests, &tasks, &options(&stop), |task, result| {
        let experiment = &tests[task.experiment].experiment;
        let name = test_name(experiment, &result);
        listed.push((result.outcome, describe(experiment, result, Some(name))));
        Ok(())
    })?;
    let passed = count_passed(&listed);
    let failed = listed.len() - passed;
    Answer::new(&json!({"passed": passed, "failed": failed, "tests": worst_first(listed)}))
}

pub(super) fn experiment(call: &Call<'_>, arguments: ExperimentFile) -> Result<Answer, Failure> {
    let folder = &call.session.folder;
    let file = folder.resolve_named(&arguments.file, paths::find_experiment)?;
    let (experiment, mut applications) = experiment::read(&file, None)?;
    let fingerprint = folder::fingerprint(&experiment, &mut applications)?;
    let drives: Vec<usize> = (0..experiment.drives()).collect();
    let mut results = Vec::new();
    let stop = AtomicBool::new(false);
    let options = options(call, &stop);
    experiment::run_drives(
        &experiment,
        &fingerprint,
        DRIVE_MEMORY,
        &drives,
        &options,
        |result| {
            results.push(result);
            Ok(())
        },
    )?;
    results.sort_by_key(|result: &DriveResult| result.drive);
    let mut text = Vec::new();
    let comparison = Comparison::of(&experiment.columns, &results);
    table::write(&mut text, &experiment.columns, &comparison, None)?;
    let listed = results.into_iter();
    let listed: Vec<_> = listed
        .map(|result| (result.outcome, describe(&experiment, result, None)))
        .collect();
    Answer::new(&json!({
        "experiment": experiment.name,
        "drives": listed.len(),
        "passed": count_passed(&listed),
        "comparison": without_styles(&String::from_utf8_lossy(&text)),
        "listed": worst_first(listed),
    }))
}

fn options<'c>(call: &Call<'c>, stop: &'c AtomicBool) -> PoolOptions<'c> {
    PoolOptions {
        jobs: call.session.jobs,
        limit: DRIVE_LIMIT,
        stop,
        abort: call.abort,
    }
}

/// Returns a result as in `results.jsonl`, without the points of its path, which are many.
fn describe(experiment: &Experiment, mut result: DriveResult, name: Option<String>) -> Value {
    if let Some(failure) = &mut result.failure {
        failure.path.clear();
        failure.winners.clear();
    }
    let line = result.to_line(&experiment.columns);
    let mut described: Value = serde_json::from_str(&line).unwrap_or_default();
    if let Some(name) = name {
        described["test"] = name.into();
    }
    described
}

fn count_passed(listed: &[(Outcome, Value)]) -> usize {
    listed
        .iter()
        .filter(|(outcome, _)| *outcome == Outcome::Passed)
        .count()
}

fn worst_first(mut listed: Vec<(Outcome, Value)>) -> Vec<Value> {
    listed.sort_by_key(|(outcome, _)| *outcome == Outcome::Passed);
    listed.truncate(MAX_LISTED);
    listed.into_iter().map(|(_, described)| described).collect()
}
