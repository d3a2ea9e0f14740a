//! Inspects plugins in a separate process: a damaged library may end the process that maps it, while the
//! system loads it or while its tables are read. One such process inspects many files; if it dies, a
//! new one is started.
//!
//! ```text
//!   host                           child
//!   Inspector ── file ──────────►  serve ── maps it, reads its tables
//!             ◄── description ───
//!             ── a schema ──────►         ── `create`, `inspect`, `destroy`
//!             ◄─ read ───────────
//!             ◄── problems ──────
//! ```
//! Describing a file calls no function but `ability`; a valid description does not make the plugin safe to
//! run. A schema's functions are called only when an application that names it is checked,
//! and only for types with the ability `jde.inspect`. From then on the process can write no files and reach
//! no network.

mod run;
mod serve;

use std::fs::File;
use std::io::{self, Read, Seek};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_abi::inspect::Problem;
use jde_abi::lists::ListedPort;
use jde_abi::{describe, raw};
use jde_app::Inspection;
use jde_loader::location::as_bytes;
use jde_loader::python::is_python;
use jde_loader::{Inspect, LoadError};
use parking_lot::Mutex;
use serde::{Deserialize, Serialize};

use super::Program;
use super::descendants::{Descendants, end_after};
use super::messages::{Bytes, FromChild, Input, Reply, Stamp, ToChild, Value};
use super::process::describe_exit_status;
use super::python;
use super::wire::Wire;
pub use serve::serve;

/// The time limit for the description of one file. A library is mapped in milliseconds; a constructor that
/// takes longer hangs.
const DESCRIBE_TIMEOUT: Duration = Duration::from_secs(20);
/// The time limit for one inspection, including the values that it reads. Files are read in milliseconds, a
/// recording of gigabytes without an index in seconds.
const INSPECT_TIMEOUT: Duration = Duration::from_secs(5);
/// The longest part of a dying process's last message that is shown, in characters.
const MAX_STDERR_CHARS: usize = 300;

/// A request to the child.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum InspectorRequest {
    /// Describe a plugin.
    Describe {
        /// The file to map.
        #[serde(with = "as_bytes")]
        copy: PathBuf,
        /// The file that the user knows.
        #[serde(with = "as_bytes")]
        path: PathBuf,
    },
    /// List the entry points of plugins.
    EntryPoints,
    /// Inspect the resources that the modulations of a schema name.
    Inspect {
        /// The file that the user knows.
        #[serde(with = "as_bytes")]
        path: PathBuf,
        /// The index of the type in its plugin.
        number: usize,
        /// The name of the instance.
        name: String,
        /// The ports of its lists.
        listed: Vec<ListedPort>,
    },
}

/// The child's reply. After [`InspectorRequest::Inspect`] it follows the messages of a call ([`FromChild`]), the last of which
/// is [`FromChild::Done`].
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum InspectorResponse {
    Plugin(describe::Plugin),
    EntryPoints(Vec<EntryPoint>),
    Inspected {
        /// A status code of the ABI.
        status: i32,
        /// For each problem: whether something is unavailable, the port, and the description.
        found: Result<Vec<(bool, u32, String)>, String>,
    },
    Refused(String),
}

/// The name and the file of a plugin.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct EntryPoint(pub(crate) String, #[serde(with = "as_bytes")] pub(crate) PathBuf);

/// Why there is no reply.
enum RequestError {
    /// No process could be started.
    NotStarted(io::Error),
    /// The process died.
    Died(String),
    /// It did not finish in time.
    Slow(String),
}

/// Inspects plugin files in separate processes: libraries in one, files of Python in another.
#[derive(Debug)]
pub struct Inspector {
    libraries: InspectorSlot,
    python: InspectorSlot,
    /// What Python said when it was asked first. It takes a quarter of a second to start, which a file that names many
    /// missing plugins would pay for each.
    entry_points: Mutex<Option<Result<EntryPoints, String>>>,
}

/// Names and files of plugins.
type EntryPoints = Vec<(String, PathBuf)>;

/// A program, and the process that runs it.
#[derive(Debug)]
struct InspectorSlot {
    program: Program,
    process: Mutex<Option<InspectorProcess>>,
}

/// The inspecting process.
#[derive(Debug)]
struct InspectorProcess {
    process: std::process::Child,
    /// Ends what it leaves behind, which may hold its stream open.
    ending: Option<JoinHandle<()>>,
    wire: Wire,
    /// Its standard error, which contains the loader's last message.
    stderr: File,
    /// Whether it has inspected a file before, which may have damaged it.
    has_inspected: bool,
}

impl Inspector {
    /// Returns an inspector of libraries that runs that program, which must call [`serve`] and do nothing else,
    /// and of files of Python, with the package of that program's installation.
    #[must_use]
    pub fn new(program: Program) -> Self {
        Self {
            python: InspectorSlot::new(python::inspector(&program.path)),
            libraries: InspectorSlot::new(program),
            entry_points: Mutex::default(),
        }
    }

    /// Returns the entry points, or why Python cannot be asked. Asks once.
    fn ask_for_entry_points(&self) -> Result<EntryPoints, String> {
        let mut known = self.entry_points.lock();
        let ask = || match self.python.request(DESCRIBE_TIMEOUT, |child| {
            child.request(&InspectorRequest::EntryPoints)
        }) {
            Ok(InspectorResponse::EntryPoints(found)) => Ok(found
                .into_iter()
                .map(|EntryPoint(name, file)| (name, file))
                .collect()),
            Ok(_) => Err(String::from("its process sent an invalid reply")),
            Err(RequestError::NotStarted(error)) => {
                Err(python::describe_start_error(&self.python.program, &error))
            }
            Err(RequestError::Died(text) | RequestError::Slow(text)) => Err(text),
        };
        known.get_or_insert_with(ask).clone()
    }

    /// Returns why Python cannot be asked, if that is known.
    fn unusable_python(&self) -> Option<String> {
        let known = self.entry_points.lock();
        known.as_ref()?.as_ref().err().cloned()
    }

    fn slot(&self, path: &Path) -> &InspectorSlot {
        if is_python(path) {
            &self.python
        } else {
            &self.libraries
        }
    }
}

impl InspectorSlot {
    fn new(program: Program) -> Self {
        Self {
            program,
            process: Mutex::default(),
        }
    }

    /// Sends a request to a process. If a process dies that has inspected a file before, a new one gets the
    /// request.
    fn request<R>(
        &self,
        timeout: Duration,
        mut send: impl FnMut(&mut InspectorProcess) -> io::Result<R>,
    ) -> Result<R, RequestError> {
        let mut current = self.process.lock();
        loop {
            let mut child = match current.take() {
                Some(child) => child,
                None => InspectorProcess::start(&self.program).map_err(RequestError::NotStarted)?,
            };
            let result = child
                .wire
                .set_timeout(Some(timeout))
                .and_then(|()| send(&mut child));
            match result {
                Ok(response) => {
                    child.has_inspected = true;
                    *current = Some(child);
                    return Ok(response);
                }
                // An earlier inspection may have caused this error, unless it is a timeout.
                Err(error) if child.has_inspected && !is_timeout(&error) => {}
                Err(error) if is_timeout(&error) => {
                    return Err(RequestError::Slow(describe_slowness(timeout)));
                }
                Err(_) => return Err(RequestError::Died(child.describe_death())),
            }
        }
    }
}

impl Inspect for Inspector {
    fn describe(&self, copy: &Path, path: &Path) -> Result<describe::Plugin, LoadError> {
        let request = InspectorRequest::Describe {
            copy: copy.to_owned(),
            path: path.to_owned(),
        };
        let is_python = is_python(path);
        if let Some(reason) = self.unusable_python().filter(|_| is_python) {
            return Err(LoadError::Python(reason));
        }
        match self
            .slot(path)
            .request(DESCRIBE_TIMEOUT, |child| child.request(&request))
        {
            Ok(InspectorResponse::Plugin(description)) => Ok(description),
            Ok(InspectorResponse::Refused(reason)) => Err(LoadError::Invalid(reason)),
            Ok(InspectorResponse::Inspected { .. } | InspectorResponse::EntryPoints(_)) => Err(
                LoadError::InspectionFailed(String::from("its process sent an invalid reply")),
            ),
            Err(RequestError::NotStarted(error)) if is_python => {
                let interpreter = &self.python.program;
                Err(LoadError::Python(python::describe_start_error(
                    interpreter,
                    &error,
                )))
            }
            Err(RequestError::NotStarted(error)) => Err(LoadError::InspectorUnavailable(error)),
            Err(RequestError::Died(text) | RequestError::Slow(text)) if is_python => {
                // Is it this file alone, or every one?
                let _ = self.ask_for_entry_points();
                Err(LoadError::Python(text))
            }
            Err(RequestError::Died(text)) => Err(LoadError::InspectionFailed(text)),
            Err(RequestError::Slow(text)) => Err(LoadError::InspectionSlow(text)),
        }
    }

    fn inspect(&self, path: &Path, inspection: &Inspection<'_>) -> Result<Vec<Problem>, String> {
        let request = InspectorRequest::Inspect {
            path: path.to_owned(),
            number: inspection.number,
            name: inspection.name.to_owned(),
            listed: inspection.listed.to_vec(),
        };
        let reason = match self.slot(path).request(INSPECT_TIMEOUT, |child| {
            child.run_inspection(&request, inspection)
        }) {
            Ok((
                InspectorResponse::Inspected {
                    status: raw::OK,
                    found,
                },
                _,
            )) => {
                let problem = |(unavailable, port, words)| Problem {
                    unavailable,
                    port,
                    words,
                };
                match found {
                    Ok(found) => return Ok(found.into_iter().map(problem).collect()),
                    Err(reason) => reason,
                }
            }
            Ok((InspectorResponse::Inspected { status, .. }, failure)) => {
                failure.unwrap_or_else(|| format!("it returned error {status} without a reason"))
            }
            Ok((InspectorResponse::Refused(reason), _)) => reason,
            Ok((InspectorResponse::Plugin(_) | InspectorResponse::EntryPoints(_), _)) => {
                String::from("its process sent an invalid reply")
            }
            Err(RequestError::NotStarted(error)) => {
                return Err(format!("no process can be started for it: {error}"));
            }
            Err(RequestError::Died(text)) => text,
            Err(RequestError::Slow(text)) => return Err(text),
        };
        Err(format!(
            "{reason}; correct the files that it names, or the plugin"
        ))
    }

    fn entry_points(&self) -> Vec<(String, PathBuf)> {
        self.ask_for_entry_points().unwrap_or_default()
    }

    fn stop(&self) {
        for slot in [&self.libraries, &self.python] {
            slot.process.lock().take();
        }
        // Packages may be installed until the next request.
        self.entry_points.lock().take();
    }
}

impl InspectorProcess {
    fn start(program: &Program) -> io::Result<Self> {
        let (host_end, child_end) = UnixStream::pair()?;
        let stderr = tempfile::tempfile()?;
        let mut command = Command::new(&program.path);
        command
            .args(&program.arguments)
            .stdin(Stdio::from(OwnedFd::from(child_end)))
            .stdout(Stdio::null())
            .stderr(stderr.try_clone()?);
        // A group of its own, so that signals from the terminal reach only the host.
        let descendants = Descendants::mark(&mut command, true);
        let mut process = command.spawn()?;
        let ending = end_after(&process, descendants).inspect_err(|_| drop(process.kill()))?;
        Ok(Self {
            process,
            ending: Some(ending),
            wire: Wire::new(host_end),
            stderr,
            has_inspected: false,
        })
    }

    fn request(&mut self, request: &InspectorRequest) -> io::Result<InspectorResponse> {
        self.wire.send(request)?;
        self.wire.receive()
    }

    /// Sends a request, and serves the reads of the schema meanwhile. Also returns the reason for a failure
    /// that the schema gave.
    fn run_inspection(
        &mut self,
        request: &InspectorRequest,
        inspection: &Inspection<'_>,
    ) -> io::Result<(InspectorResponse, Option<String>)> {
        let end = Instant::now() + INSPECT_TIMEOUT;
        let mut failure = None;
        self.wire.send(request)?;
        loop {
            let reply = match self.wire.receive()? {
                FromChild::Done(_) => return Ok((self.wire.receive()?, failure)),
                FromChild::Fail(reason) => {
                    failure = Some(reason.to_owned());
                    None
                }
                // Log messages of an inspection are not shown.
                FromChild::Log { .. } => None,
                FromChild::Read { port } => Some(Reply::Input(read(inspection, port))),
                FromChild::Loan { .. } => Some(Reply::Loan(Err(raw::REFUSED))),
                FromChild::Child { .. } => Some(Reply::Child(Err(raw::REFUSED))),
                FromChild::Publish { .. }
                | FromChild::Retract { .. }
                | FromChild::Wake { .. }
                | FromChild::PutToSleep { .. }
                | FromChild::SetPolicy { .. }
                | FromChild::Hold(_) => Some(Reply::Status(raw::REFUSED)),
            };
            if let Some(reply) = reply {
                self.wire.send(&ToChild::Reply(reply))?;
            }
            let remaining = end.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                return Err(io::ErrorKind::TimedOut.into());
            }
            self.wire.set_timeout(Some(remaining))?;
        }
    }

    /// Describes why the process died.
    fn describe_death(mut self) -> String {
        // A process that is already dying keeps its own cause of death.
        let _ = self.process.kill();
        let text = match self.reap() {
            Ok(end) => describe_exit_status(end),
            Err(error) => error.to_string(),
        };
        match self.last_stderr_line() {
            Some(line) => format!("{text}, and said: {line}"),
            None => text,
        }
    }

    /// Waits for the process, which is dead or dying, and for the end of what it has left behind.
    fn reap(&mut self) -> io::Result<ExitStatus> {
        if let Some(ending) = self.ending.take() {
            // It does not panic.
            let _ = ending.join();
        }
        self.process.wait()
    }

    /// Returns the last line that it wrote to standard error.
    fn last_stderr_line(&mut self) -> Option<String> {
        self.stderr.rewind().ok()?;
        let mut bytes = Vec::new();
        // A library can write unlimited output.
        Read::by_ref(&mut self.stderr)
            .take(1 << 16)
            .read_to_end(&mut bytes)
            .ok()?;
        let text = String::from_utf8_lossy(&bytes);
        let line = text.lines().rev().map(str::trim).find(|line| !line.is_empty())?;
        let shown = line.chars().filter(|character| !character.is_control());
        Some(shown.take(MAX_STDERR_CHARS).collect())
    }
}

/// Describes an inspection that did not end in time. Whether it would have, nobody knows.
fn describe_slowness(timeout: Duration) -> String {
    format!(
        "its inspection did not end within {} s: the machine is busy, it waits for a file or a device, or it hangs; try again \
         when the machine has less to do",
        timeout.as_secs()
    )
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut)
}

/// Returns the value of a modulation, in reply to [`FromChild::Read`]. No other port has a value; an import is
/// bound or not.
fn read<'a>(inspection: &Inspection<'a>, port: u32) -> Result<Input<'a>, i32> {
    let Some((value, set)) = inspection.value(port) else {
        return Err(if inspection.is_unbound_import(port) {
            raw::UNBOUND
        } else {
            raw::NO_VALUE
        });
    };
    Ok(Input {
        stamp: Stamp {
            time_ns: 0,
            sequence: u64::from(set),
            writer: 0,
            flags: if set { 0 } else { raw::SAMPLE_DEFAULT },
        },
        value: Value::Sent(Bytes(value)),
    })
}

impl Drop for InspectorProcess {
    fn drop(&mut self) {
        // Fails only if the process has already ended.
        let _ = self.process.kill();
        let _ = self.reap();
    }
}
