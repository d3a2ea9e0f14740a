//! Inspects plugins in a separate process: a damaged library may end the process that maps it, while the
//! system's loader works or while its tables are read. One such process inspects many files; if it dies, a
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
//! Of a file that is only described, no function but `ability` is called; a valid description does not make
//! the plugin safe to run. A schema's functions are called only when an application that names it is checked,
//! and only for types with the ability `jde.inspect`. From then on the process can write no files and reach
//! no network.

mod description;
mod serve;

use std::fs::File;
use std::io::{self, Read, Seek};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use jde_abi::inspect::Problem;
use jde_abi::{describe, raw};
use serde::{Deserialize, Serialize};

use super::LoadError;
use super::load::held;
use crate::apart::{Frame, Kind, Program, Wire, as_bytes, end_in_words};
use crate::app::Inspection;
pub use serve::serve;

/// The time limit for the description of one file. A library is mapped in milliseconds; a constructor that
/// has not returned by then hangs.
const PATIENCE: Duration = Duration::from_secs(20);
/// The time limit for one inspection, including the values that it reads. Files are read in milliseconds, a
/// recording of gigabytes without an index in seconds.
const INSPECTION: Duration = Duration::from_secs(5);
/// The most bytes of a dying process's last message that are repeated.
const MOST_SAID: usize = 300;

/// A request to the child.
#[derive(Serialize, Deserialize)]
enum Question {
    /// Describe a plugin.
    Look {
        /// The file to map.
        #[serde(with = "as_bytes")]
        copy: PathBuf,
        /// The file that the user knows.
        #[serde(with = "as_bytes")]
        path: PathBuf,
    },
    /// Inspect what the modulations of a schema name.
    Inspect {
        /// The file that the user knows.
        #[serde(with = "as_bytes")]
        path: PathBuf,
        /// The place of the type in its plugin.
        number: usize,
        /// The name of the instance.
        name: String,
    },
}

/// The child's answer.
#[derive(Serialize, Deserialize)]
enum Answer {
    Plugin(#[serde(with = "description::Plugin")] describe::Plugin),
    Inspected {
        /// A status code of the ABI.
        status: i32,
        /// For each problem: whether something is unavailable, the port, and the description in words.
        found: Result<Vec<(bool, u32, String)>, String>,
    },
    Refused(String),
}

/// Why there is no answer.
enum Silent {
    /// No process could be started.
    Absent(io::Error),
    /// The process died, or did not finish in time.
    Died(String),
}

/// Inspects files.
#[derive(Debug)]
pub(super) struct Inspector {
    program: Program,
    child: Mutex<Option<Child>>,
}

/// The inspecting process.
#[derive(Debug)]
struct Child {
    process: std::process::Child,
    wire: Wire,
    /// Its standard error, which contains the loader's last message.
    said: File,
    /// It has inspected something before, which may have damaged it.
    used: bool,
}

impl Inspector {
    /// Returns an inspector that runs that program.
    pub(super) fn new(program: Program) -> Self {
        Self {
            program,
            child: Mutex::default(),
        }
    }

    /// Returns the description of the plugin in `copy`; `path` is the file that the user knows.
    ///
    /// # Errors
    /// Why it cannot be loaded, for example [`LoadError::Deadly`].
    pub(super) fn look(&self, copy: &Path, path: &Path) -> Result<describe::Plugin, LoadError> {
        // The checks of the file alone need no process.
        held(copy)?;
        let question = Question::Look {
            copy: copy.to_owned(),
            path: path.to_owned(),
        };
        match self.ask(PATIENCE, |child| child.ask(&question)) {
            Ok(Answer::Plugin(plugin)) => Ok(plugin),
            Ok(Answer::Refused(reason)) => Err(LoadError::Foreign(reason)),
            Ok(Answer::Inspected { .. }) => {
                Err(LoadError::Deadly(String::from("its process answers nonsense")))
            }
            Err(Silent::Absent(error)) => Err(LoadError::NoInspection(error)),
            Err(Silent::Died(words)) => Err(LoadError::Deadly(words)),
        }
    }

    /// Returns the problems that a type of the plugin in the file `path` finds in what its modulations name.
    ///
    /// # Errors
    /// Why there is no answer, or no valid one, in words.
    pub(super) fn inspect(&self, path: &Path, asked: &Inspection<'_>) -> Result<Vec<Problem>, String> {
        let question = Question::Inspect {
            path: path.to_owned(),
            number: asked.number,
            name: asked.name.to_owned(),
        };
        match self.ask(INSPECTION, |child| child.converse(&question, asked)) {
            Ok((
                Answer::Inspected {
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
                found.map(|found| found.into_iter().map(problem).collect())
            }
            Ok((Answer::Inspected { status, .. }, failure)) => {
                Err(failure.unwrap_or_else(|| format!("it returned error {status} without a reason")))
            }
            Ok((Answer::Refused(reason), _)) => Err(reason),
            Ok((Answer::Plugin(_), _)) => Err(String::from("its process answers nonsense")),
            Err(Silent::Absent(error)) => Err(format!("no process can be started for it: {error}")),
            Err(Silent::Died(words)) => Err(words),
        }
    }

    /// Sends a request to a process. If a process dies that has inspected something before, a new one gets
    /// the request.
    fn ask<R>(
        &self,
        patience: Duration,
        mut ask: impl FnMut(&mut Child) -> io::Result<R>,
    ) -> Result<R, Silent> {
        let mut present = self.child.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let mut child = match present.take() {
                Some(child) => child,
                None => Child::start(&self.program).map_err(Silent::Absent)?,
            };
            let asked = child
                .wire
                .set_patience(Some(patience))
                .and_then(|()| ask(&mut child));
            match asked {
                Ok(answer) => {
                    child.used = true;
                    *present = Some(child);
                    return Ok(answer);
                }
                // An earlier inspection may have caused this, but hardly a time-out.
                Err(error) if child.used && !is_late(&error) => {}
                Err(error) => return Err(Silent::Died(child.last_words(&error, patience))),
            }
        }
    }

    /// Ends the inspecting process, if there is one; the next request starts another.
    pub(super) fn dismiss(&self) {
        self.child.lock().unwrap_or_else(PoisonError::into_inner).take();
    }
}

impl Child {
    fn start(program: &Program) -> io::Result<Self> {
        let (ours, theirs) = UnixStream::pair()?;
        let said = tempfile::tempfile()?;
        let process = Command::new(&program.path)
            .args(&program.arguments)
            // A group of its own, so that signals from the terminal reach only the host.
            .process_group(0)
            .stdin(Stdio::from(OwnedFd::from(theirs)))
            .stdout(Stdio::null())
            .stderr(said.try_clone()?)
            .spawn()?;
        Ok(Self {
            process,
            wire: Wire::new(ours),
            said,
            used: false,
        })
    }

    fn ask(&mut self, question: &Question) -> io::Result<Answer> {
        self.say(question)?;
        Ok(serde_json::from_slice(&self.wire.receive()?.bytes)?)
    }

    fn say(&mut self, question: &Question) -> io::Result<()> {
        self.wire.send(&Frame {
            bytes: serde_json::to_vec(question)?,
            ..Frame::new(Kind::Start)
        })
    }

    /// Sends a request, and serves the reads of the schema meanwhile. Also returns the reason for a failure
    /// that the schema gave.
    fn converse(
        &mut self,
        question: &Question,
        asked: &Inspection<'_>,
    ) -> io::Result<(Answer, Option<String>)> {
        let end = Instant::now() + INSPECTION;
        let mut failure = None;
        self.say(question)?;
        loop {
            let frame = self.wire.receive()?;
            match frame.kind {
                Kind::Done => return Ok((serde_json::from_slice(&frame.bytes)?, failure)),
                Kind::Fail => failure = Some(String::from_utf8_lossy(&frame.bytes).into_owned()),
                // Log messages of an inspection are not shown.
                Kind::Log => {}
                kind => self.wire.send(&match kind {
                    Kind::Read => value_of(asked, frame.number),
                    _ => answer(raw::REFUSED),
                })?,
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(io::ErrorKind::TimedOut.into());
            }
            self.wire.set_patience(Some(left))?;
        }
    }

    /// Describes why the process failed.
    fn last_words(mut self, error: &io::Error, patience: Duration) -> String {
        if is_late(error) {
            return format!("a look at it has not ended in {} s", patience.as_secs());
        }
        // A process that is already dying keeps its own cause of death.
        let _ = self.process.kill();
        let words = match self.process.wait() {
            Ok(end) => end_in_words(end),
            Err(error) => error.to_string(),
        };
        match self.said() {
            Some(said) => format!("{words}, and said: {said}"),
            None => words,
        }
    }

    /// Returns the last line that it wrote to standard error.
    fn said(&mut self) -> Option<String> {
        self.said.rewind().ok()?;
        let mut bytes = Vec::new();
        // A library can write without end.
        Read::by_ref(&mut self.said)
            .take(1 << 16)
            .read_to_end(&mut bytes)
            .ok()?;
        let text = String::from_utf8_lossy(&bytes);
        let line = text.lines().rev().map(str::trim).find(|line| !line.is_empty())?;
        let shown = line.chars().filter(|character| !character.is_control());
        Some(shown.take(MOST_SAID).collect())
    }
}

fn is_late(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut)
}

/// Returns the value of a modulation, in answer to [`Kind::Read`]; no other port has a value here.
fn value_of(asked: &Inspection<'_>, port: u32) -> Frame {
    let Some((value, set)) = asked.value(port) else {
        return answer(raw::NO_VALUE);
    };
    Frame {
        flags: if set { 0 } else { raw::SAMPLE_DEFAULT },
        words: [0, u64::from(set), 0, value.len() as u64],
        bytes: value.to_vec(),
        ..answer(raw::OK)
    }
}

fn answer(status: i32) -> Frame {
    Frame {
        status,
        ..Frame::new(Kind::Answer)
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // Fails only if the process has already ended.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
