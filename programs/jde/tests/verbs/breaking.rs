//! `jde run --break`: the time of an application stands still, and goes on as it is told.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStderr, Command, Stdio};

use jde_watchdog::Watchdog;

use crate::attached::Sandbox;
use crate::support::{jde_with_plugins, json, pair, signal};

/// A run with breakpoints whose standard input is a pipe.
struct Run {
    child: Child,
    errors: BufReader<ChildStderr>,
    _watchdog: Watchdog,
}

impl Run {
    fn start(args: &[&str]) -> Self {
        Self::spawn(jde_with_plugins(&[&["run"], args].concat()))
    }

    fn spawn(mut command: Command) -> Self {
        let watchdog = Watchdog::for_test();
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let errors = BufReader::new(child.stderr.take().unwrap());
        Self {
            child,
            errors,
            _watchdog: watchdog,
        }
    }

    /// Returns when time stands still next, s.
    fn still(&mut self) -> f64 {
        let mut seen = String::new();
        loop {
            let mut line = String::new();
            assert!(
                self.errors.read_line(&mut line).unwrap() > 0,
                "it never stands still: {seen}"
            );
            if let Some(rest) = line.strip_prefix("stands still at ") {
                return rest.split(' ').next().unwrap().parse().unwrap();
            }
            seen += &line;
        }
    }

    fn type_line(&mut self, line: &str) {
        writeln!(self.child.stdin.as_mut().unwrap(), "{line}").unwrap();
    }

    /// Closes standard input, waits for the end, and returns the exit status and the output.
    fn end(mut self) -> (Option<i32>, String) {
        drop(self.child.stdin.take());
        let out = std::io::read_to_string(self.child.stdout.take().unwrap()).unwrap();
        (self.child.wait().unwrap().code(), out)
    }
}

#[test]
fn lockstep_stands_still_at_the_instant_and_goes_on_step_by_step() {
    let application = pair();
    let args = [
        &application,
        "--lockstep",
        "--for",
        "2s",
        "--json",
        "--break",
        "time > 0.5",
    ];
    let mut run = Run::start(&args);
    let first = run.still();
    assert!((0.5..0.7).contains(&first), "{first}");
    run.type_line("n");
    let second = run.still();
    run.type_line("n");
    let third = run.still();
    assert!(first < second && second < third, "{first}, {second}, {third}");
    run.type_line("c");
    let (status, out) = run.end();
    assert_eq!(status, Some(0));
    assert_eq!(json(&out)["sim_seconds"], 2.0);
}

#[test]
fn real_time_stands_still_on_threads_and_in_a_pool_and_nothing_is_late() {
    let folder = tempfile::tempdir().unwrap();
    for executor in ["threads", "pool"] {
        let text = std::fs::read_to_string(pair()).unwrap();
        let file = folder.path().join(format!("{executor}.toml"));
        std::fs::write(&file, format!("executor = \"{executor}\"\n{text}")).unwrap();
        let file = file.display().to_string();
        let args = [&file, "--plain", "--json", "--break", "time > 0.3"];
        let mut run = Run::start(&args);
        let mut still = run.still();
        // Longer than every period, budget and patience of the application.
        for _ in 0..20 {
            run.type_line("n");
            let next = run.still();
            assert!(next > still);
            still = next;
        }
        signal("INT", &run.child);
        let (status, out) = run.end();
        assert_eq!(status, Some(0), "{executor}: {out}");
        let summary = json(&out);
        // The time of a standstill is printed in milliseconds, rounded.
        assert!(
            summary["sim_seconds"].as_f64() >= Some(still - 0.0005),
            "{still} s: {summary}"
        );
        for schema in summary["schemas"].as_array().unwrap() {
            assert_eq!(schema["faults"], 0, "{summary}");
        }
    }
}

#[test]
fn time_passes_again_when_a_tool_from_outside_says_so() {
    pass_time_from_outside("--plain");
}

#[test]
fn tools_reach_a_run_in_lockstep_that_stands_still() {
    pass_time_from_outside("--lockstep");
}

fn pass_time_from_outside(mode: &str) {
    let sandbox = Sandbox::new();
    let mut run = Run::spawn(sandbox.command(jde_with_plugins(&[
        "run",
        &pair(),
        mode,
        "--json",
        "--break",
        "time > 0.3",
    ])));
    let still = run.still();
    let now = sandbox.json(&["ps"]);
    assert_eq!(now["standstill"], "time > 0.3", "{now}");
    for verb in ["step", "continue"] {
        let output = sandbox.run(&[verb]);
        assert_eq!(output.status, Some(0), "{verb}: {}", output.err);
    }
    let refused = sandbox.run(&["step"]);
    assert_eq!(refused.status, Some(1), "{}", refused.out);
    signal("INT", &run.child);
    let (status, out) = run.end();
    assert_eq!(status, Some(0), "it stood still at {still} s");
    assert!(json(&out)["sim_seconds"].as_f64().unwrap() > still, "{out}");
}

#[test]
fn a_condition_that_cannot_be_read_is_refused_before_the_start() {
    let run = Run::start(&[&pair(), "--lockstep", "--break", "listner.won"]);
    let mut run = run;
    let mut error = String::new();
    std::io::Read::read_to_string(&mut run.errors, &mut error).unwrap();
    assert!(error.contains("did you mean `listener.won`?"), "{error}");
    assert_eq!(run.end().0, Some(2));
}
