//! The test programs that a build produces. Lists them from cargo's JSON messages, and runs them.

use std::fs;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use serde::Deserialize;

use crate::paint::Paint;
use crate::shell;
use crate::test::Context;

/// Programs that measure how long their schemas hang: they run first and alone.
const RUN_ALONE: &[&str] = &["conformance"];

/// The programs that take longest start first, each with the number of tests that it runs at once; otherwise
/// the last one would run alone. Those that mostly wait for robots run more tests than there are cores.
const LONGEST_FIRST: &[(&str, usize)] = &[("verbs", 3), ("bases", 8), ("jde_view", 2), ("campaign", 2)];

/// Programs that other steps run too, after the tests: under valgrind, and with schemas in Python.
const RUN_AGAIN: &[&str] = &["conformance", "read", "torture"];

/// How many programs run at once.
const AT_ONCE: usize = 2;

/// Kills a program that hangs outside its watchdogs, so that all others still run. The limit is ten times the
/// slowest program.
const TIMEOUT: &[&str] = &["--foreground", "--verbose", "--kill-after=30s", "20m"];

/// A test program that is ready to run.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Program {
    name: String,
    path: PathBuf,
    /// The folder of the test's package.
    folder: PathBuf,
}

#[derive(Deserialize)]
struct Message {
    executable: Option<PathBuf>,
    manifest_path: PathBuf,
    target: Target,
    profile: Profile,
}

#[derive(Deserialize)]
struct Target {
    name: String,
}

#[derive(Deserialize)]
struct Profile {
    test: bool,
}

/// Builds the tests that the arguments of `cargo test` select.
pub(crate) fn build(context: &Context, selection: &[&str]) -> Result<Vec<Program>> {
    let mut cargo = context.cargo(&["test", "--no-run"]);
    cargo
        .args(selection)
        .args(["--message-format", "json-render-diagnostics"]);
    shell::show(&cargo, context.paint);
    Ok(list(&shell::read(&mut cargo)?))
}

/// Copies the plugins that were built to a folder that no test writes to, and returns that folder. A build in a
/// test program would otherwise replace a plugin while another program loads it.
pub(crate) fn copy_plugins(target: &Path) -> Result<PathBuf> {
    let folder = target.join("test-plugins");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir(&folder)?;
    for entry in fs::read_dir(target.join("debug"))? {
        let file = entry?.path();
        if file.extension().is_some_and(|extension| extension == "so") {
            fs::copy(&file, folder.join(file.file_name().unwrap_or_default()))?;
        }
    }
    Ok(folder)
}

/// Returns a program by the folder of its package and its name.
pub(crate) fn find<'p>(programs: &'p [Program], folder: &str, name: &str) -> Result<&'p Program> {
    let mut found = programs.iter();
    found
        .find(|program| program.name == name && program.folder.ends_with(folder))
        .with_context(|| format!("{folder} has no test called {name} any more"))
}

fn list(messages: &str) -> Vec<Program> {
    let messages = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Message>(line).ok());
    let programs = messages
        .filter(|message| message.profile.test)
        .filter_map(|message| {
            Some(Program {
                name: message.target.name,
                path: message.executable?,
                folder: message.manifest_path.parent()?.to_owned(),
            })
        });
    programs.collect()
}

impl Program {
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether a step after the tests runs it too.
    pub(crate) fn runs_again(&self) -> bool {
        RUN_AGAIN.contains(&self.name.as_str())
    }

    /// Appends the test to a command that runs it as cargo does: in the folder of its package.
    pub(crate) fn run_by(&self, command: &mut Command) {
        command
            .arg(&self.path)
            .current_dir(&self.folder)
            .env("CARGO_MANIFEST_DIR", &self.folder);
    }

    /// Returns the program as a job that is killed if it hangs.
    pub(crate) fn job(&self, root: &Path) -> Job {
        let mut command = Command::new("timeout");
        self.run_by(command.args(TIMEOUT));
        let rank = LONGEST_FIRST.iter().position(|(name, _)| *name == self.name);
        if let Some((_, threads)) = rank.and_then(|rank| LONGEST_FIRST.get(rank)) {
            command.env("RUST_TEST_THREADS", threads.to_string());
        }
        let folder = self.folder.strip_prefix(root).unwrap_or(&self.folder);
        Job {
            title: format!("{} {}", folder.display(), self.name),
            command,
            place: match rank {
                _ if RUN_ALONE.contains(&self.name.as_str()) => Place::First,
                Some(rank) => Place::Ranked(rank),
                None => Place::Unranked,
            },
        }
    }
}

/// A command that runs tests.
pub(crate) struct Job {
    title: String,
    pub(crate) command: Command,
    place: Place,
}

/// When a job runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    /// Before all others, alone.
    First,
    /// Beside others; the lowest rank starts first.
    Ranked(usize),
    /// Beside others, once those with a rank have started.
    Unranked,
    /// After all others, alone.
    Last,
}

impl Job {
    /// Returns a job that runs after all others, alone.
    pub(crate) fn last(title: &str, command: Command) -> Self {
        Self {
            title: title.to_owned(),
            command,
            place: Place::Last,
        }
    }
}

/// Runs the jobs, [`AT_ONCE`] side by side. Prints a line for each job that passes and the output of each job
/// that fails, which is an error.
pub(crate) fn run_all(mut jobs: Vec<Job>, paint: Paint) -> Result<()> {
    jobs.sort_by_key(|job| job.place);
    let last = jobs.split_off(jobs.partition_point(|job| job.place < Place::Last));
    let together = jobs.split_off(jobs.partition_point(|job| job.place == Place::First));
    let mut failed = Vec::new();
    for (jobs, at_once) in [(jobs, 1), (together, AT_ONCE), (last, 1)] {
        failed.extend(run_side_by_side(jobs, at_once, paint));
    }
    if !failed.is_empty() {
        bail!("{}", failed.join("; "));
    }
    Ok(())
}

/// Runs jobs in their order, several at once. Returns a line for each job that fails.
fn run_side_by_side(jobs: Vec<Job>, at_once: usize, paint: Paint) -> Vec<String> {
    let queue = Mutex::new(jobs.into_iter());
    let worker = || {
        // The lock is free again while the job runs.
        let next = || queue.lock().expect("no worker panics").next();
        std::iter::from_fn(next)
            .filter_map(|job| run(job, paint))
            .collect::<Vec<_>>()
    };
    thread::scope(|scope| {
        let workers: Vec<_> = (0..at_once).map(|_| scope.spawn(worker)).collect();
        let failed = workers
            .into_iter()
            .flat_map(|worker| worker.join().expect("no worker panics"));
        failed.collect()
    })
}

/// Runs a job and prints its result. Returns a line if it fails.
fn run(mut job: Job, paint: Paint) -> Option<String> {
    let start = Instant::now();
    let (output, passed) = output(&mut job.command).unwrap_or_else(|error| (format!("{error:#}"), false));
    println!("{}", report(&job.title, &output, passed, start.elapsed(), paint));
    (!passed).then(|| format!("{} ({})", job.title, failed_tests(&output).join(", ")))
}

/// Runs a command. Returns what it writes, and whether it succeeds.
fn output(command: &mut Command) -> Result<(String, bool)> {
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

fn report(title: &str, output: &str, passed: bool, time: Duration, paint: Paint) -> String {
    let time = time.as_secs_f64();
    if passed {
        let tests: usize = output.lines().filter_map(passed_tests).sum();
        format!("{} {title}: {tests} passed in {time:.1} s", paint.green("ok"))
    } else {
        format!("{output}\n{} {title} after {time:.1} s", paint.red("failed"))
    }
}

/// Reads the number of tests from a line such as `test result: ok. 12 passed; 0 failed; ...`.
fn passed_tests(line: &str) -> Option<usize> {
    let counts = line.strip_prefix("test result: ok. ")?;
    counts.split_once(" passed")?.0.parse().ok()
}

/// Reads the names of the tests from lines such as `test a_schema_wins ... FAILED`.
fn failed_tests(output: &str) -> Vec<&str> {
    let lines = output.lines().filter_map(|line| line.strip_suffix(" ... FAILED"));
    lines.filter_map(|line| line.strip_prefix("test ")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MESSAGES: &str = r#"
{"reason":"compiler-artifact","target":{"name":"it"},"executable":null,"manifest_path":"b/Cargo.toml","profile":{"test":true}}
{"reason":"compiler-artifact","target":{"name":"b"},"executable":"x/tool","manifest_path":"b/Cargo.toml","profile":{"test":false}}
{"reason":"compiler-artifact","target":{"name":"it"},"executable":"x/a","manifest_path":"a/Cargo.toml","profile":{"test":true}}
{"reason":"compiler-artifact","target":{"name":"it"},"executable":"x/b","manifest_path":"b/Cargo.toml","profile":{"test":true}}
{"reason":"build-finished","success":true}
"#;

    fn job(script: &str) -> Job {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        Job {
            title: script.to_owned(),
            command,
            place: Place::Unranked,
        }
    }

    #[test]
    fn a_test_program_is_found_and_runs_in_the_folder_of_its_package() {
        let programs = list(MESSAGES);
        assert_eq!(programs.len(), 2);
        let mut command = Command::new("valgrind");
        find(&programs, "b", "it").unwrap().run_by(&mut command);
        assert_eq!(command.get_args().collect::<Vec<_>>(), ["x/b"]);
        assert_eq!(command.get_current_dir(), Some("b".as_ref()));
    }

    #[test]
    fn what_valgrind_runs_is_kept() {
        for (_, name) in crate::valgrind::TESTS {
            assert!(RUN_AGAIN.contains(name), "{name}");
        }
    }

    #[test]
    fn a_test_that_does_not_exist_is_an_error() {
        let error = find(&list(MESSAGES), "b", "gone").unwrap_err().to_string();
        assert_eq!(error, "b has no test called gone any more");
        assert!(find(&list(MESSAGES), "c", "it").is_err());
    }

    #[test]
    fn every_job_runs_and_failed_jobs_are_reported() {
        assert!(run_all(vec![job("true"), job("echo hello")], Paint::plain()).is_ok());
        let failing = "echo 'test a ... ok'; echo 'test b ... FAILED'; exit 1";
        let jobs = vec![job("true"), job(failing), job("true"), job("kill -9 $$")];
        let error = run_all(jobs, Paint::plain()).unwrap_err().to_string();
        assert!(
            error.contains("exit 1 (b)") && error.contains("kill -9"),
            "{error}"
        );
    }

    #[test]
    fn long_jobs_start_first_and_some_run_alone() {
        let files = tempfile::tempdir().unwrap();
        let file = files.path().join("order");
        let note = |text: &str, place| Job {
            place,
            ..job(&format!("echo {text} >> {}", file.display()))
        };
        let mut jobs = vec![note("last", Place::Last), note("first", Place::First)];
        // Each waits for the other at a pipe, so both must run at once.
        let pipe = files.path().join("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let pipe = pipe.display();
        let long = format!(
            "timeout 60 cat {pipe} > /dev/null && echo long >> {}",
            file.display()
        );
        let side = format!(
            "echo side >> {}; timeout 60 sh -c 'echo go > {pipe}'",
            file.display()
        );
        jobs.extend([
            job(&side),
            Job {
                place: Place::Ranked(0),
                ..job(&long)
            },
        ]);
        run_all(jobs, Paint::plain()).unwrap();
        assert_eq!(fs::read_to_string(file).unwrap(), "first\nside\nlong\nlast\n");
    }

    #[test]
    fn standard_output_and_standard_error_are_read() {
        let (text, passed) = output(&mut job("echo one; echo two >&2; exit 3").command).unwrap();
        assert_eq!((text.as_str(), passed), ("one\ntwo\n", false));
    }

    #[test]
    fn passed_tests_are_counted() {
        let output = "test result: ok. 12 passed; 0 failed\nx\ntest result: ok. 3 passed; 0 failed\n";
        let line = report("a", output, true, Duration::from_millis(1500), Paint::plain());
        assert_eq!(line, "ok a: 15 passed in 1.5 s");
        let text = report("a", "it broke", false, Duration::ZERO, Paint::plain());
        assert_eq!(text, "it broke\nfailed a after 0.0 s");
    }
}
