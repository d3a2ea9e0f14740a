//! Runs checks, each in a process of its own, and judges how that process ended.

use std::fs::File;
use std::io::{self, Read};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use jde_isolation::Program;
use jde_isolation::descendants::{Descendants, end_after};
use jde_isolation::process::describe_exit_status;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};

use crate::checks::{CHECKS, Check, LOADS, RETURNS, STAYS, SURVIVES};
use crate::serve::CheckReport;
use crate::{CheckResult, Finding};

/// The check of what is printed.
const SILENT: &str = "silent";

/// Why no plugin was checked.
#[derive(Debug)]
pub enum ValidationError {
    /// No process can be started.
    NotStarted(io::Error),
    /// There is no such check.
    UnknownCheck(String),
}

/// How the process of a check ended.
enum End {
    Reported(CheckReport),
    Ended(ExitStatus),
    Lasted,
}

/// Checks the plugin in `file`, with all checks or those of these names. `program` calls [`serve`](crate::serve)
/// with the arguments that follow its own. A check in which the life of one instance takes longer than `timeout`
/// counts as one that does not return.
///
/// # Errors
/// [`ValidationError`].
pub fn validate(
    file: &Path,
    program: &Program,
    only: &[String],
    timeout: Duration,
) -> Result<Vec<Finding>, ValidationError> {
    if let Some(unknown) = only
        .iter()
        .find(|name| !CHECKS.iter().any(|check| check.name == **name))
    {
        return Err(ValidationError::UnknownCheck(unknown.clone()));
    }
    let is_chosen = |name: &str| only.is_empty() || only.iter().any(|chosen| chosen == name);
    let run = |name: &str, number: usize| {
        run(file, program, name, number, timeout).map_err(ValidationError::NotStarted)
    };
    let mut findings = Vec::new();
    let (end, _) = run(LOADS, 0)?;
    let (verdict, types) = match end {
        End::Reported(report) => (report.verdict, report.types),
        end => (CheckResult::Failed(describe(&end, timeout)), Vec::new()),
    };
    findings.push(Finding {
        check: LOADS,
        schema: None,
        verdict,
    });
    for (number, name) in types.iter().enumerate() {
        // How calls end in general, for checks whose process ends without a report.
        let mut general: Option<String> = None;
        for check in CHECKS.iter().filter(|check| check.name != LOADS) {
            let decides = [RETURNS, SURVIVES, STAYS].contains(&check.name);
            if !decides && !is_chosen(check.name) {
                continue;
            }
            if let Some(words) = general.as_ref().filter(|_| !decides) {
                findings.push(finding(check, name, CheckResult::Skipped(words.clone())));
                continue;
            }
            let (end, printed) = run(check.name, number)?;
            let verdict = match end {
                End::Reported(_) if check.name == SILENT && !printed.is_empty() => {
                    CheckResult::Failed(format!("it printed {printed:?}"))
                }
                End::Reported(report) => report.verdict,
                end if !decides || culprit(&end) == check.name => {
                    CheckResult::Failed(describe(&end, timeout))
                }
                end => CheckResult::Skipped(describe(&end, timeout)),
            };
            if decides && verdict != CheckResult::Ok {
                general.get_or_insert_with(|| String::from("see `survives`, `stays` and `returns`"));
            }
            if is_chosen(check.name) {
                findings.push(finding(check, name, verdict));
            }
        }
    }
    findings.retain(|finding| is_chosen(finding.check));
    Ok(findings)
}

fn finding(check: &Check, schema: &str, verdict: CheckResult) -> Finding {
    Finding {
        check: check.name,
        schema: Some(schema.to_owned()),
        verdict,
    }
}

/// Returns the check that is meant for such an end.
fn culprit(end: &End) -> &'static str {
    match end {
        End::Lasted => RETURNS,
        End::Ended(status) if status.signal().is_some() => SURVIVES,
        End::Reported(_) | End::Ended(_) => STAYS,
    }
}

fn describe(end: &End, timeout: Duration) -> String {
    match end {
        End::Reported(_) => String::new(),
        End::Ended(status) => describe_exit_status(*status),
        End::Lasted => {
            format!("the life of an instance, or the end of its process, took longer than {timeout:?}")
        }
    }
}

/// Runs one check. Also returns what its process printed.
fn run(
    file: &Path,
    program: &Program,
    check: &str,
    number: usize,
    timeout: Duration,
) -> io::Result<(End, String)> {
    let (stream, child_end) = UnixStream::pair()?;
    stream.set_read_timeout(Some(timeout))?;
    // Appended to, so that the process can empty it.
    let printed = tempfile::Builder::new().append(true).tempfile()?;
    let mut command = Command::new(&program.path);
    command
        .args(&program.arguments)
        .arg(file)
        .args([check, &number.to_string()])
        .stdin(Stdio::from(OwnedFd::from(child_end)))
        .stdout(printed.as_file().try_clone()?)
        .stderr(printed.as_file().try_clone()?);
    // What the plugin has started ends with it, and holds none of its streams.
    let descendants = Descendants::mark(&mut command, true);
    let mut child = command.spawn()?;
    let ending = end_after(&child, descendants).inspect_err(|_| drop(child.kill()))?;
    // It holds the child's end, whose closing shows the child's end.
    drop(command);
    let mut text = Vec::new();
    // The timeout begins again with each life.
    let read = (&stream).read_to_end(&mut text);
    let lasts = match read {
        Err(error) => matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut),
        // A destructor of the plugin may not return.
        Ok(_) => !ends_within(&child, timeout)?,
    };
    if lasts {
        child.kill()?;
    }
    // It does not panic.
    let _ = ending.join();
    let status = child.wait()?;
    let end = if lasts {
        End::Lasted
    } else {
        match serde_json::from_slice(&text) {
            Ok(report) => End::Reported(report),
            Err(_) => End::Ended(status),
        }
    };
    Ok((end, first_line(printed.reopen()?)?))
}

/// Waits for the end of a process, and returns whether it came in time.
fn ends_within(child: &Child, timeout: Duration) -> io::Result<bool> {
    let handle = pidfd_open(Pid::from_child(child), PidfdFlags::empty())?;
    let timeout = Timespec::try_from(timeout).map_err(io::Error::other)?;
    let mut end = [PollFd::from_borrowed_fd(handle.as_fd(), PollFlags::IN)];
    Ok(poll(&mut end, Some(&timeout))? > 0)
}

/// Returns the first line of what was printed.
fn first_line(printed: File) -> io::Result<String> {
    let mut bytes = Vec::new();
    printed.take(200).read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    Ok(text
        .lines()
        .find(|line| !line.is_empty())
        .unwrap_or_default()
        .to_owned())
}
