//! Looks at plugins in a process of their own: a damaged library may end whoever maps it, while the system's loader is at it or while
//! its tables are read, and this process is not the one. One such process looks at many files, and a fresh one follows if it dies.
//!
//! ```text
//!   host                           child
//!   Inspector ── file ──────────►  serve ── maps it, reads its tables
//!             ◄── description ───
//!             ── a schema ──────►         ── `create`, `inspect`, `destroy`
//!             ◄─ read ───────────
//!             ◄── problems ──────
//! ```
//! To look at a file nothing of a plugin but `ability` is called, and what is found right is not made safe to run by that. The functions
//! of a schema are called only where an application is checked that names it, of types with the ability `jde.inspect`; from then on the
//! process can write no files and reach no network.

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

/// How long a look at one file may take: a library is mapped in milliseconds, and a constructor that has not returned by then is not
/// going to.
const PATIENCE: Duration = Duration::from_secs(20);
/// How long one inspection may take, with all that it asks: files are read in milliseconds, and a recording of gigabytes without an index in
/// seconds.
const INSPECTION: Duration = Duration::from_secs(5);
/// Most of what a dying process said that is repeated, in bytes.
const MOST_SAID: usize = 300;

/// What is asked of the child.
#[derive(Serialize, Deserialize)]
enum Question {
    /// What does it say of itself?
    Look {
        /// The file that is mapped.
        #[serde(with = "as_bytes")]
        copy: PathBuf,
        /// The file that people know.
        #[serde(with = "as_bytes")]
        path: PathBuf,
    },
    /// What is wrong with what the modulations of a schema name?
    Inspect {
        /// The file that people know.
        #[serde(with = "as_bytes")]
        path: PathBuf,
        /// The place of the type in its plugin.
        number: usize,
        /// The name of the instance.
        name: String,
    },
}

/// What it answers.
#[derive(Serialize, Deserialize)]
enum Answer {
    Plugin(#[serde(with = "description::Plugin")] describe::Plugin),
    Inspected {
        /// As the ABI numbers it.
        status: i32,
        /// Of each problem whether it is of something unavailable, its port and its words.
        found: Result<Vec<(bool, u32, String)>, String>,
    },
    Refused(String),
}

/// Why there is no answer.
enum Silent {
    /// No process could be started.
    Absent(io::Error),
    /// It died, or did not come to an end.
    Died(String),
}

/// Looks at files.
#[derive(Debug)]
pub(super) struct Inspector {
    program: Program,
    child: Mutex<Option<Child>>,
}

/// The process that looks.
#[derive(Debug)]
struct Child {
    process: std::process::Child,
    wire: Wire,
    /// What it writes to standard error: the loader's last words.
    said: File,
    /// It has looked at something before, which may have damaged it.
    used: bool,
}

impl Inspector {
    /// One that has that program look.
    pub(super) fn new(program: Program) -> Self {
        Self {
            program,
            child: Mutex::default(),
        }
    }

    /// What the plugin in `copy` says of itself; `path` is the file that people know.
    ///
    /// # Errors
    /// Why it cannot be loaded, [`LoadError::Deadly`] among others.
    pub(super) fn look(&self, copy: &Path, path: &Path) -> Result<describe::Plugin, LoadError> {
        // What can be told from the file needs no process.
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

    /// What a type of schema of the plugin in the file `path` finds wrong with what its modulations name.
    ///
    /// # Errors
    /// Why there is no answer, or none that makes sense, in words.
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

    /// Asks a process; another one, if it dies of what it was asked before.
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
                // What it looked at before may be to blame, but hardly for taking long.
                Err(error) if child.used && !is_late(&error) => {}
                Err(error) => return Err(Silent::Died(child.last_words(&error, patience))),
            }
        }
    }

    /// Ends the process that looks, if there is one; the next look has another.
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
            // What the terminal sends is for whoever has it to answer.
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

    /// Asks, and answers what the schema asks meanwhile. Also gives the reason for a failure that the schema gave.
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
                // Nobody listens to what it would log.
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

    /// What became of it.
    fn last_words(mut self, error: &io::Error, patience: Duration) -> String {
        if is_late(error) {
            return format!("a look at it has not ended in {} s", patience.as_secs());
        }
        // Whoever is dying already dies of what it dies of.
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

    /// The last line that it wrote to standard error.
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

/// The value of a modulation, as [`Kind::Read`] is answered; nothing else has one.
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
        // Fails only for one that is gone already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
