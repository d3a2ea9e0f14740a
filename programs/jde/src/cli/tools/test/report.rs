//! The output of `jde test`: a line for each test, and what is known about each failure.

use std::io::{self, Write};
use std::path::Path;

use jde_drawing::text::counted;
use jde_experiment::Experiment;
use jde_experiment::pool::Task;
use jde_experiment::result::{DriveResult, Outcome};
use jde_session::cli::print_json;
use jde_terminal::escape::escape;
use jde_terminal::{self as terminal, BAD, FAINT, GOOD, TITLE, TextWriter};
use serde::Serialize;

use crate::failure::{Failure, display_path};

/// The tests so far.
pub(super) struct Report {
    output: TextWriter,
    json: bool,
    counts: Counts,
    failures: Vec<String>,
    /// The options that repeat a test, beside its file, drive and seed.
    options: String,
}

/// The object that `--json` prints.
#[derive(Default, Serialize)]
struct Counts {
    passed: usize,
    failed: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
}

impl Report {
    /// Prints the beginning.
    pub(super) fn begin(
        tests: usize,
        seed: Option<u64>,
        application: Option<&Path>,
        json: bool,
    ) -> io::Result<Self> {
        let mut output = terminal::text_out(json);
        write!(output, "{}", counted(tests as u64, "test"))?;
        match seed {
            Some(seed) => writeln!(output, ", --shuffle={seed}")?,
            None => writeln!(output)?,
        }
        output.flush()?;
        Ok(Self {
            output,
            json,
            counts: Counts {
                seed,
                ..Counts::default()
            },
            failures: Vec::new(),
            options: application.map_or_else(String::new, |application| {
                format!(" --application {}", display_path(application))
            }),
        })
    }

    /// Prints the line of a test.
    pub(super) fn add(&mut self, experiment: &Experiment, task: Task, result: DriveResult) -> io::Result<()> {
        let name = test_name(experiment, &result);
        let passed = result.outcome == Outcome::Passed;
        let (style, word) = match passed {
            true => (GOOD, "ok"),
            false => (BAD, result.outcome.word()),
        };
        let seconds = result.seconds;
        writeln!(
            self.output,
            "{style}{word:<8}{style:#} {name} {FAINT}{seconds:.1} s{FAINT:#}"
        )?;
        self.output.flush()?;
        if passed {
            self.counts.passed += 1;
        } else {
            self.counts.failed += 1;
            self.failures
                .push(failure(experiment, task, &name, &result, &self.options));
        }
        Ok(())
    }

    /// Prints the failures and the sum. Fails unless all of so many tests passed.
    pub(super) fn finish(mut self, tests: usize) -> Result<(), Failure> {
        for failure in &self.failures {
            writeln!(self.output)?;
            self.output.write_all(failure.as_bytes())?;
        }
        let Counts { passed, failed, .. } = self.counts;
        let style = if failed == 0 { GOOD } else { BAD };
        writeln!(self.output)?;
        writeln!(self.output, "{style}{passed} passed, {failed} failed{style:#}")?;
        self.output.flush()?;
        if self.json {
            print_json(&self.counts)?;
        }
        match tests - passed - failed {
            0 if failed == 0 => Ok(()),
            0 => Err(Failure::mission()),
            missing => Err(Failure::broken(format!("interrupted with {missing} tests left"))),
        }
    }
}

/// The name of the test, with the values of its axes if it has any.
pub(crate) fn test_name(experiment: &Experiment, result: &DriveResult) -> String {
    let axes = experiment.columns.axes.iter().zip(&result.axes);
    let axes: Vec<_> = axes.map(|(name, value)| format!("{name} = {value}")).collect();
    match axes.as_slice() {
        [] => experiment.name.clone(),
        axes => format!("{} [{}]", experiment.name, axes.join(", ")),
    }
}

/// What is known about a failure.
fn failure(experiment: &Experiment, task: Task, name: &str, result: &DriveResult, options: &str) -> String {
    let mut text = format!(
        "{TITLE}{}{TITLE:#}\n  {BAD}{}{BAD:#}\n",
        escape(name),
        escape(&result.why)
    );
    if let Some(failure) = &result.failure {
        if let Some([x, y, heading]) = failure.pose {
            let degrees = heading.to_degrees();
            text += &format!(
                "  at {:.3} s the robot was at {x:.2}, {y:.2} m, {degrees:.0}°\n",
                failure.at
            );
        }
        for selection in &failure.selections {
            text += &format!("  {FAINT}{}{FAINT:#}\n", escape(selection));
        }
    }
    let view = match &result.failure {
        Some(failure) => jde_report::view_command("failure.mcap", failure.at),
        None => "jde view failure.mcap".to_owned(),
    };
    let file = escape(&display_path(&experiment.file));
    let seed = task
        .seed
        .map_or_else(String::new, |seed| format!(" --seed {seed}"));
    let number = task.drive;
    text + &format!(
        "  see it: jde experiment {file} --drive {number}{seed}{options} --record failure.mcap; {view}\n"
    )
}
