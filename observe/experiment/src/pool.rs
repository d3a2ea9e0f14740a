//! Runs drives in processes, several at a time. A process serves one experiment. If it dies or takes too
//! long, that is the result of its drive, and another one continues. The order in which drives end is not
//! determined; their results are.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use jde_isolation::Program;
use jde_isolation::descendants::{Descendants, end_after};
use jde_isolation::lines::Lines;
use parking_lot::Mutex;

use crate::drive::unjudged;
use crate::experiment::Experiment;
use crate::result::{DriveResult, Outcome};

/// How often a waiting job looks whether its drive is aborted.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// The lines of standard error that are kept to explain a death.
const KEPT_LINES: usize = 20;
/// The most bytes of such a line.
const MAX_ERROR: usize = 4 << 10;
/// The most bytes of an answer, which may have the path of a long drive.
const MAX_ANSWER: usize = 64 << 20;

/// An experiment whose drives are run.
pub struct PoolExperiment<'e> {
    /// The experiment.
    pub experiment: &'e Experiment,
    /// The command that serves its drives: [`crate::worker::serve`].
    pub program: Program,
}

/// A drive to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Task {
    /// The place of its experiment.
    pub experiment: usize,
    /// Its number in the experiment.
    pub drive: usize,
    /// The seed in place of its own.
    pub seed: Option<u64>,
}

/// How drives are run.
pub struct PoolOptions<'p> {
    /// Processes at a time, at least 1.
    pub jobs: usize,
    /// The longest time of the machine that a drive may take.
    pub limit: Duration,
    /// Set when no further drive is to begin.
    pub stop: &'p AtomicBool,
    /// Set when the drives under way are of no use any more, and end at once.
    pub abort: &'p AtomicBool,
}

/// Runs these drives, and calls `on_result` with each result on the calling thread, in the order in which
/// they end.
///
/// # Errors
/// A process cannot be started, or refuses its experiment. [`io::ErrorKind::Interrupted`] if a drive was aborted.
pub fn run(
    experiments: &[PoolExperiment<'_>],
    tasks: &[Task],
    options: &PoolOptions<'_>,
    mut on_result: impl FnMut(Task, DriveResult) -> io::Result<()>,
) -> io::Result<()> {
    let waiting = Mutex::new(tasks.iter().copied().collect::<VecDeque<_>>());
    let next = || {
        let mut waiting = waiting.lock();
        waiting
            .pop_front()
            .filter(|_| !options.stop.load(Ordering::Relaxed) && !options.abort.load(Ordering::Relaxed))
    };
    thread::scope(|scope| {
        let (sender, results) = mpsc::channel();
        for _ in 0..options.jobs.clamp(1, tasks.len().max(1)) {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                let mut worker = None;
                while let Some(task) = next() {
                    let result = run_drive(&experiments[task.experiment], task, &mut worker, options);
                    let is_fatal = result.is_err();
                    // The receiver is gone after an error, which ends all jobs.
                    if sender.send((task, result)).is_err() || is_fatal {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let handled = results
            .iter()
            .try_for_each(|(task, result)| on_result(task, result?));
        if handled.is_err() {
            options.stop.store(true, Ordering::Relaxed);
        }
        handled
    })
}

/// Runs a drive in the job's process. If there is none, or it serves another experiment, one is started.
fn run_drive(
    PoolExperiment { experiment, program }: &PoolExperiment<'_>,
    task: Task,
    worker: &mut Option<(usize, Worker)>,
    options: &PoolOptions<'_>,
) -> io::Result<DriveResult> {
    let serving = worker
        .take()
        .filter(|(experiment, _)| *experiment == task.experiment);
    let mut running = match serving {
        Some((_, running)) => running,
        None => Worker::start(program)?,
    };
    let failed = |outcome, why| Ok(unjudged(experiment, task.drive, outcome, why));
    match running.drive(task, options.limit, options.abort) {
        Ok(line) => match DriveResult::from_json(&line, &experiment.columns) {
            Some(result) if result.drive == task.drive => {
                *worker = Some((task.experiment, running));
                Ok(result)
            }
            Some(_) | None => failed(Outcome::Broken, format!("its process answered `{line}`")),
        },
        Err(RecvTimeoutError::Timeout) if options.abort.load(Ordering::Relaxed) => Err(io::Error::new(
            io::ErrorKind::Interrupted,
            "the drives were aborted",
        )),
        Err(RecvTimeoutError::Timeout) => {
            running.kill();
            let seconds = options.limit.as_secs_f64();
            failed(
                Outcome::Hung,
                format!("it took longer than {seconds} s of the machine"),
            )
        }
        Err(RecvTimeoutError::Disconnected) => {
            let (status, last) = running.end()?;
            if status.code() == Some(REFUSED) {
                return Err(io::Error::other(last.unwrap_or_default()));
            }
            let last = last.map_or_else(String::new, |last| format!(": {last}"));
            failed(Outcome::Crashed, format!("{}{last}", describe(status)))
        }
    }
}

/// The exit status of a process that refuses the experiment.
pub const REFUSED: i32 = 2;

/// Describes how a process died.
fn describe(status: ExitStatus) -> String {
    match (status.signal(), status.code()) {
        (Some(signal), _) => format!("its process was killed by signal {signal}{}", signal_name(signal)),
        (None, Some(code)) => format!("its process exited with status {code}"),
        (None, None) => String::from("its process ended"),
    }
}

fn signal_name(signal: i32) -> &'static str {
    match signal {
        4 => " (illegal instruction)",
        6 => " (abort)",
        7 => " (bus error)",
        8 => " (arithmetic error)",
        9 => " (kill)",
        11 => " (invalid memory access)",
        24 => " (processor time)",
        _ => "",
    }
}

/// A process that serves drives.
struct Worker {
    child: Child,
    input: Option<ChildStdin>,
    answers: Receiver<String>,
    /// The last lines of its standard error, and the thread that reads them.
    errors: Arc<Mutex<VecDeque<String>>>,
    error_reader: Option<thread::JoinHandle<()>>,
    /// Ends what the process leaves behind, which may hold its streams open.
    ending: Option<thread::JoinHandle<()>>,
}

impl Worker {
    fn start(program: &Program) -> io::Result<Self> {
        let mut command = Command::new(&program.path);
        command
            .args(&program.arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // The last line of its errors is then the message, and no line of a backtrace.
            .env("RUST_BACKTRACE", "0");
        // Ctrl-C asks the parent alone, which lets the drives under way end.
        let descendants = Descendants::mark(&mut command, true);
        let mut child = command.spawn()?;
        let ending = end_after(&child, descendants).inspect_err(|_| drop(child.kill()))?;
        let (sender, answers) = mpsc::channel();
        let streams = child.stdout.take().zip(child.stderr.take());
        let (output, stream) = streams.ok_or(io::ErrorKind::BrokenPipe)?;
        let mut output = Lines::of(&child, output, MAX_ANSWER)?;
        thread::spawn(move || output.try_for_each(|line| sender.send(line)));
        let errors: Arc<Mutex<VecDeque<String>>> = Arc::default();
        let (kept, printed) = (Arc::clone(&errors), Lines::of(&child, stream, MAX_ERROR)?);
        let error_reader = thread::spawn(move || {
            for line in printed {
                let mut kept = kept.lock();
                if kept.len() == KEPT_LINES {
                    kept.pop_front();
                }
                kept.push_back(line);
            }
        });
        Ok(Self {
            input: child.stdin.take(),
            child,
            answers,
            errors,
            error_reader: Some(error_reader),
            ending: Some(ending),
        })
    }

    /// Requests a drive, and waits for its result, at most for `limit` and until it is aborted.
    fn drive(&mut self, task: Task, limit: Duration, abort: &AtomicBool) -> Result<String, RecvTimeoutError> {
        // If the process is dead already, its answer is missing.
        if let Some(input) = &mut self.input {
            let seed = task.seed.map_or_else(String::new, |seed| format!(" {seed}"));
            let _ = writeln!(input, "{}{seed}", task.drive);
        }
        let begin = Instant::now();
        loop {
            let remaining = limit.saturating_sub(begin.elapsed());
            match self.answers.recv_timeout(remaining.min(POLL_INTERVAL)) {
                Err(RecvTimeoutError::Timeout)
                    if remaining > POLL_INTERVAL && !abort.load(Ordering::Relaxed) => {}
                answer => return answer,
            }
        }
    }

    fn kill(&mut self) {
        // It may have died meanwhile.
        let _ = self.child.kill();
    }

    /// Waits for the process, which is dead or dying, and for the end of what it has left behind.
    fn reap(&mut self) -> io::Result<ExitStatus> {
        if let Some(ending) = self.ending.take() {
            let _ = ending.join();
        }
        self.child.wait()
    }

    /// Waits for the process, which is dead or dying, and returns the last line of its standard error.
    fn end(&mut self) -> io::Result<(ExitStatus, Option<String>)> {
        let status = self.reap()?;
        if let Some(reader) = self.error_reader.take() {
            let _ = reader.join();
        }
        let errors = self.errors.lock();
        // A note says how to get more, not what happened.
        let tells = |line: &&String| !line.trim().is_empty() && !line.starts_with("note:");
        let last = errors.iter().rev().find(tells);
        Ok((status, last.cloned()))
    }
}

impl Drop for Worker {
    /// The end of its input ends the process; the drive that it may still run is of no use.
    fn drop(&mut self) {
        self.input = None;
        self.kill();
        let _ = self.reap();
    }
}

#[cfg(test)]
mod tests {
    use jde_watchdog::Watchdog;
    use rustix::process::{Pid, Signal, kill_process};

    use super::*;

    const TASK: Task = Task {
        experiment: 0,
        drive: 0,
        seed: None,
    };

    fn worker(script: &str) -> Worker {
        let program = Program {
            path: "sh".into(),
            arguments: ["-c", script].map(Into::into).to_vec(),
        };
        Worker::start(&program).expect("a shell")
    }

    #[test]
    fn what_a_process_prints_does_not_change_its_result() {
        let _watchdog = Watchdog::for_test();
        let mut worker =
            worker(r"printf 'caf\351\n' >&2; read -r _; seq 20000 >&2 || exit 9; echo answer; read -r _");
        let abort = AtomicBool::new(false);
        assert_eq!(worker.drive(TASK, Duration::MAX, &abort), Ok("answer".to_owned()));
    }

    #[test]
    fn a_drive_that_is_aborted_ends_although_its_process_does_not_answer() {
        let _watchdog = Watchdog::for_test();
        let mut worker = worker("read -r _; while :; do sleep 1; done");
        let abort = AtomicBool::new(true);
        let answer = worker.drive(TASK, Duration::MAX, &abort);
        assert_eq!(answer, Err(RecvTimeoutError::Timeout));
    }

    #[test]
    fn a_process_is_dead_when_it_has_exited_whoever_holds_its_streams() {
        let _watchdog = Watchdog::for_test();
        // Neither its group nor its environment shows where the other process comes from.
        let mut worker = worker("read -r _; env -i setsid sleep 3600 & echo $! >&2; kill -ABRT $$");
        let answer = worker.drive(TASK, Duration::MAX, &AtomicBool::new(false));
        assert_eq!(answer, Err(RecvTimeoutError::Disconnected));
        let (status, last) = worker.end().expect("it is reaped");
        assert_eq!(status.signal(), Some(6));
        let other = last.and_then(|line| Pid::from_raw(line.parse().ok()?));
        kill_process(other.expect("its number"), Signal::KILL).expect("it still runs");
    }
}
