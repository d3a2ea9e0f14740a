//! Runs steps one after another, and some beside the others. Prints each step's title, its time and, if it fails, what to
//! do. It does not depend on what the steps do.

use std::fmt::Write as _;
use std::io::{self, Read as _};
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};

use crate::paint::Paint;

/// One step of a run.
pub(crate) struct TestStep<C> {
    /// The name for `--only` and `--skip`.
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    /// What to do if the step fails.
    pub(crate) help: &'static str,
    /// Whether the step runs only with `--all`, or by its name.
    pub(crate) is_heavy: bool,
    /// Whether the step runs beside those after it, as a process: it measures no time, and none needs it.
    pub(crate) is_beside: bool,
    /// If one of these steps failed, this step is skipped, since it would report nothing new.
    pub(crate) needs: &'static [&'static str],
    pub(crate) run: fn(&C) -> Result<StepOutcome>,
}

/// The outcome of a step that did not fail.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum StepOutcome {
    Passed,
    /// The step could not run on this machine, for this reason.
    Skipped(String),
}

/// The steps to run.
#[derive(Debug, Default)]
pub(crate) struct StepSelection {
    /// Whether to stop after the first failure.
    pub(crate) fail_fast: bool,
    /// Whether heavy steps run too.
    pub(crate) all: bool,
    /// The only steps to run, heavy or not; empty to select by `all`.
    pub(crate) only: Vec<String>,
    pub(crate) skip: Vec<String>,
}

impl StepSelection {
    fn includes<C>(&self, step: &TestStep<C>) -> bool {
        if self.only.is_empty() {
            self.all || !step.is_heavy
        } else {
            self.only.iter().any(|only| only == step.name)
        }
    }
}

/// The results of the chosen steps.
#[derive(Debug, Default)]
pub(crate) struct StepReport {
    lines: Vec<StepLine>,
    /// How long all took together.
    time: Duration,
}

/// The result of one step.
#[derive(Debug)]
struct StepLine {
    /// Its place among the chosen steps.
    place: usize,
    name: &'static str,
    result: StepResult,
    time: Duration,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum StepResult {
    Passed,
    Failed { error: String, help: &'static str },
    Skipped(String),
}

/// A step that runs beside others.
struct StepBeside {
    place: usize,
    name: &'static str,
    title: String,
    help: &'static str,
    command: Command,
}

/// Runs the chosen steps in their order. Prints the title, the time and the outcome of each. Those that run beside others
/// begin at their place, one after another, as the commands that `beside` returns for their names; without it all steps
/// run one after another.
pub(crate) fn run_all<C>(
    steps: &[TestStep<C>],
    context: &C,
    choice: &StepSelection,
    paint: Paint,
    beside: Option<&dyn Fn(&str) -> Command>,
) -> StepReport {
    let begun = Instant::now();
    let chosen: Vec<&TestStep<C>> = steps.iter().filter(|step| choice.includes(step)).collect();
    // Alone it needs no other process.
    let beside = beside.filter(|_| chosen.iter().any(|step| !step.is_beside));
    let report = Mutex::new(StepReport::default());
    thread::scope(|scope| {
        let (sender, queue) = channel();
        let queued = scope.spawn(|| run_queued(queue, &report, choice, paint));
        for (place, step) in chosen.iter().enumerate() {
            let title = format!("[{}/{}] {}: {}", place + 1, chosen.len(), step.name, step.title);
            println!("\n{}", paint.bold(&title));
            let start = Instant::now();
            let skipped = locked(&report).reason_to_skip(step, choice);
            if let Some(beside) = beside.filter(|_| step.is_beside && skipped.is_none()) {
                println!("it runs beside the steps that follow; its output comes when it ends");
                let step = StepBeside {
                    place,
                    name: step.name,
                    title,
                    help: step.help,
                    command: beside(step.name),
                };
                sender.send(step).expect("the thread takes all steps");
                continue;
            }
            let result = skipped.map_or_else(|| run(step, context), StepResult::Skipped);
            locked(&report).add(place, step.name, result, start.elapsed(), paint);
        }
        drop(sender);
        queued.join().expect("the thread does not panic");
    });
    let mut report = report.into_inner().unwrap_or_else(PoisonError::into_inner);
    report.lines.sort_by_key(|line| line.place);
    report.time = begun.elapsed();
    report
}

/// Runs the steps of a queue until it closes, and prints what each writes when it ends.
fn run_queued(queue: Receiver<StepBeside>, report: &Mutex<StepReport>, choice: &StepSelection, paint: Paint) {
    for mut step in queue {
        let start = Instant::now();
        let result = if choice.fail_fast && locked(report).has_failed() {
            StepResult::Skipped("an earlier step failed".to_owned())
        } else {
            let (output, passed) = output(&mut step.command)
                .unwrap_or_else(|error| (format!("it cannot be started: {error:#}"), false));
            println!("\n{}\n{}", paint.bold(&step.title), output.trim());
            if passed {
                skipped_in(&output, step.name).map_or(StepResult::Passed, StepResult::Skipped)
            } else {
                StepResult::Failed {
                    error: "see its output above".to_owned(),
                    help: step.help,
                }
            }
        };
        locked(report).add(step.place, step.name, result, start.elapsed(), paint);
    }
}

/// Returns why a process skipped its only step, by the summary at the end of its output.
fn skipped_in(output: &str, name: &str) -> Option<String> {
    let (_, summary) = output.rsplit_once("\nSummary\n")?;
    let mut lines = summary.lines();
    let line = lines.find_map(|line| {
        line.strip_prefix("skipped ")?
            .strip_prefix(name)?
            .strip_prefix(": ")
    })?;
    Some(line.to_owned())
}

fn locked(report: &Mutex<StepReport>) -> MutexGuard<'_, StepReport> {
    report.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs a command. Returns what it writes, and whether it succeeds.
pub(crate) fn output(command: &mut Command) -> Result<(String, bool)> {
    let (mut reader, writer) = io::pipe()?;
    command
        .stdin(Stdio::null())
        .stdout(writer.try_clone()?)
        .stderr(writer);
    let mut child = command.spawn().context("cannot start it")?;
    // The command keeps a copy of the pipe's end that writes.
    *command = Command::new("true");
    let mut output = Vec::new();
    reader.read_to_end(&mut output)?;
    Ok((
        String::from_utf8_lossy(&output).into_owned(),
        child.wait()?.success(),
    ))
}

fn run<C>(step: &TestStep<C>, context: &C) -> StepResult {
    match (step.run)(context) {
        Ok(StepOutcome::Passed) => StepResult::Passed,
        Ok(StepOutcome::Skipped(why)) => StepResult::Skipped(why),
        Err(error) => StepResult::Failed {
            error: format!("{error:#}"),
            help: step.help,
        },
    }
}

impl StepReport {
    pub(crate) fn has_failed(&self) -> bool {
        self.lines
            .iter()
            .any(|line| matches!(line.result, StepResult::Failed { .. }))
    }

    /// Adds a result, and prints it.
    fn add(&mut self, place: usize, name: &'static str, result: StepResult, time: Duration, paint: Paint) {
        println!("{}", result.line(name, time, paint));
        self.lines.push(StepLine {
            place,
            name,
            result,
            time,
        });
    }

    /// Returns one line per step, and the counts alone on the last line, for programs that parse them.
    pub(crate) fn summary(&self, paint: Paint) -> String {
        let mut text = format!("\n{}\n", paint.bold("Summary"));
        for line in &self.lines {
            let _ = writeln!(text, "{}", line.result.line(line.name, line.time, paint));
        }
        let count = |is_counted: fn(&StepResult) -> bool| {
            self.lines.iter().filter(|line| is_counted(&line.result)).count()
        };
        let passed = count(|result| matches!(result, StepResult::Passed));
        let failed = count(|result| matches!(result, StepResult::Failed { .. }));
        let skipped = count(|result| matches!(result, StepResult::Skipped(_)));
        let _ = writeln!(text, "total time {}", duration(self.time));
        let _ = write!(text, "\n{passed} passed, {failed} failed, {skipped} skipped");
        text
    }

    fn reason_to_skip<C>(&self, step: &TestStep<C>, choice: &StepSelection) -> Option<String> {
        if choice.skip.iter().any(|skip| skip == step.name) {
            return Some("by --skip".to_owned());
        }
        if choice.fail_fast && self.has_failed() {
            return Some("an earlier step failed".to_owned());
        }
        let failed = self.lines.iter().find(|line| {
            step.needs.contains(&line.name) && matches!(line.result, StepResult::Failed { .. })
        })?;
        Some(format!("{} failed", failed.name))
    }
}

impl StepResult {
    fn line(&self, name: &str, time: Duration, paint: Paint) -> String {
        let took = duration(time);
        match self {
            StepResult::Passed => format!("{} {name} ({took})", paint.green("passed ")),
            StepResult::Failed { error, help } => {
                format!(
                    "{} {name} ({took}): {error}\n        {help}",
                    paint.red("failed ")
                )
            }
            StepResult::Skipped(why) => format!("{} {name}: {why}", paint.yellow("skipped")),
        }
    }
}

fn duration(time: Duration) -> String {
    let seconds = time.as_secs();
    if seconds < 60 {
        format!("{:.1} s", time.as_secs_f64())
    } else {
        format!("{} min {:02} s", seconds / 60, seconds % 60)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use anyhow::bail;

    use super::*;

    type Trace = RefCell<Vec<&'static str>>;

    fn steps() -> Vec<TestStep<Trace>> {
        fn step(
            name: &'static str,
            needs: &'static [&'static str],
            run: fn(&Trace) -> Result<StepOutcome>,
        ) -> TestStep<Trace> {
            TestStep {
                name,
                title: "a title",
                help: "what to do",
                is_heavy: name == "grind",
                is_beside: name == "tidy",
                needs,
                run,
            }
        }
        vec![
            step("build", &[], |trace| {
                trace.borrow_mut().push("build");
                bail!("broken")
            }),
            step("test", &["build"], |trace| {
                trace.borrow_mut().push("test");
                Ok(StepOutcome::Passed)
            }),
            step("tidy", &[], |trace| {
                trace.borrow_mut().push("tidy");
                Ok(StepOutcome::Passed)
            }),
            step("grind", &[], |trace| {
                trace.borrow_mut().push("grind");
                Ok(StepOutcome::Skipped("no valgrind".to_owned()))
            }),
        ]
    }

    fn outcome(choice: &StepSelection) -> (Vec<&'static str>, String, bool) {
        let trace = Trace::default();
        let report = run_all(&steps(), &trace, choice, Paint::plain(), None);
        let summary = report.summary(Paint::plain());
        let counts = summary.lines().last().unwrap_or_default().to_owned();
        (trace.into_inner(), counts, report.has_failed())
    }

    #[test]
    fn independent_steps_run_after_a_failure() {
        let (ran, counts, failed) = outcome(&StepSelection {
            all: true,
            ..StepSelection::default()
        });
        assert_eq!(ran, ["build", "tidy", "grind"]);
        assert_eq!(counts, "1 passed, 1 failed, 2 skipped");
        assert!(failed);
    }

    #[test]
    fn no_step_runs_after_a_failure_with_fail_fast() {
        let (ran, counts, _) = outcome(&StepSelection {
            fail_fast: true,
            all: true,
            ..StepSelection::default()
        });
        assert_eq!(ran, ["build"]);
        assert_eq!(counts, "0 passed, 1 failed, 3 skipped");
    }

    #[test]
    fn a_step_selected_by_name_runs_without_the_steps_that_it_needs() {
        let (ran, counts, failed) = outcome(&StepSelection {
            only: vec!["test".to_owned()],
            ..StepSelection::default()
        });
        assert_eq!(ran, ["test"]);
        assert_eq!(counts, "1 passed, 0 failed, 0 skipped");
        assert!(!failed);
    }

    #[test]
    fn a_heavy_step_runs_only_by_name_or_with_all() {
        let (ran, _, _) = outcome(&StepSelection::default());
        assert_eq!(ran, ["build", "tidy"]);
        let (ran, counts, _) = outcome(&StepSelection {
            only: vec!["grind".to_owned()],
            ..StepSelection::default()
        });
        assert_eq!(
            (ran, counts.as_str()),
            (vec!["grind"], "0 passed, 0 failed, 1 skipped")
        );
    }

    #[test]
    fn a_skipped_step_is_shown() {
        let (ran, counts, failed) = outcome(&StepSelection {
            all: true,
            skip: vec!["build".to_owned()],
            ..StepSelection::default()
        });
        assert_eq!(ran, ["test", "tidy", "grind"]);
        assert_eq!(counts, "2 passed, 0 failed, 2 skipped");
        assert!(!failed);
    }

    #[test]
    fn a_failure_shows_its_help() {
        let report = run_all(
            &steps(),
            &Trace::default(),
            &StepSelection::default(),
            Paint::plain(),
            None,
        );
        let summary = report.summary(Paint::plain());
        assert!(summary.contains("s): broken\n        what to do"), "{summary}");
        assert!(summary.contains("skipped test: build failed"), "{summary}");
    }

    /// Runs all steps, one of them beside the others as that script.
    fn outcome_beside(script: &'static str, choice: &StepSelection) -> (Vec<&'static str>, String) {
        let trace = Trace::default();
        let beside = |name: &str| {
            let mut command = Command::new("sh");
            command.args(["-c", script, name]);
            command
        };
        let report = run_all(&steps(), &trace, choice, Paint::plain(), Some(&beside));
        (trace.into_inner(), report.summary(Paint::plain()))
    }

    #[test]
    fn a_step_beside_others_is_a_process_and_its_result_has_its_place() {
        let all = StepSelection {
            all: true,
            ..StepSelection::default()
        };
        let (ran, summary) = outcome_beside("test $0 = tidy", &all);
        assert_eq!(ran, ["build", "grind"]);
        let names = ["build", "test", "tidy", "grind"];
        let places = names.map(|name| summary.find(&format!(" {name}")).expect("each has a line"));
        assert!(places.is_sorted(), "{summary}");
        assert!(summary.ends_with("\n1 passed, 1 failed, 2 skipped"), "{summary}");
        let (_, summary) = outcome_beside("echo broken; exit 1", &all);
        assert!(summary.ends_with("\n0 passed, 2 failed, 2 skipped"), "{summary}");
        let (_, summary) = outcome_beside("printf '\\nSummary\\nskipped tidy: no tidy\\n'", &all);
        assert!(summary.contains("skipped tidy: no tidy\n"), "{summary}");
    }

    #[test]
    fn a_step_that_is_chosen_alone_runs_in_this_process() {
        let (ran, _) = outcome_beside(
            "exit 1",
            &StepSelection {
                only: vec!["tidy".to_owned()],
                ..StepSelection::default()
            },
        );
        assert_eq!(ran, ["tidy"]);
    }

    #[test]
    fn standard_output_and_standard_error_are_read() {
        let mut command = Command::new("sh");
        command.args(["-c", "echo one; echo two >&2; exit 3"]);
        let (text, passed) = output(&mut command).unwrap();
        assert_eq!((text.as_str(), passed), ("one\ntwo\n", false));
    }

    #[test]
    fn durations_are_formatted_in_seconds_or_minutes() {
        assert_eq!(duration(Duration::from_millis(1_250)), "1.2 s");
        assert_eq!(duration(Duration::from_secs(125)), "2 min 05 s");
    }
}
