//! Runs steps one after another. Prints each step's title, its time and, if it fails, what to do. It
//! does not depend on what the steps do.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use anyhow::Result;

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
    lines: Vec<(&'static str, StepResult, Duration)>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum StepResult {
    Passed,
    Failed { error: String, help: &'static str },
    Skipped(String),
}

/// Runs the chosen steps in their order. Prints the title, the time and the outcome of each.
pub(crate) fn run_all<C>(
    steps: &[TestStep<C>],
    context: &C,
    choice: &StepSelection,
    paint: Paint,
) -> StepReport {
    let chosen: Vec<&TestStep<C>> = steps.iter().filter(|step| choice.includes(step)).collect();
    let mut report = StepReport::default();
    for (index, step) in chosen.iter().enumerate() {
        let title = format!("[{}/{}] {}: {}", index + 1, chosen.len(), step.name, step.title);
        println!("\n{}", paint.bold(&title));
        let start = Instant::now();
        let result = report
            .reason_to_skip(step, choice)
            .map_or_else(|| run(step, context), StepResult::Skipped);
        let time = start.elapsed();
        println!("{}", result.line(step.name, time, paint));
        report.lines.push((step.name, result, time));
    }
    report
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
            .any(|(_, result, _)| matches!(result, StepResult::Failed { .. }))
    }

    /// Returns one line per step, and the counts alone on the last line, for programs that parse them.
    pub(crate) fn summary(&self, paint: Paint) -> String {
        let mut text = format!("\n{}\n", paint.bold("Summary"));
        for (name, result, time) in &self.lines {
            let _ = writeln!(text, "{}", result.line(name, *time, paint));
        }
        let count = |is_counted: fn(&StepResult) -> bool| {
            self.lines.iter().filter(|line| is_counted(&line.1)).count()
        };
        let passed = count(|result| matches!(result, StepResult::Passed));
        let failed = count(|result| matches!(result, StepResult::Failed { .. }));
        let skipped = count(|result| matches!(result, StepResult::Skipped(_)));
        let total = self.lines.iter().map(|line| line.2).sum();
        let _ = writeln!(text, "total time {}", duration(total));
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
        let failed = self.lines.iter().find(|(name, result, _)| {
            step.needs.contains(name) && matches!(result, StepResult::Failed { .. })
        })?;
        Some(format!("{} failed", failed.0))
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
        let report = run_all(&steps(), &trace, choice, Paint::plain());
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
        );
        let summary = report.summary(Paint::plain());
        assert!(summary.contains("s): broken\n        what to do"), "{summary}");
        assert!(summary.contains("skipped test: build failed"), "{summary}");
    }

    #[test]
    fn durations_are_formatted_in_seconds_or_minutes() {
        assert_eq!(duration(Duration::from_millis(1_250)), "1.2 s");
        assert_eq!(duration(Duration::from_secs(125)), "2 min 05 s");
    }
}
