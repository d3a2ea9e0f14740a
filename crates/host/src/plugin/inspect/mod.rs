//! Looks at plugins in a process of their own: a damaged library may end whoever maps it, while the system's loader is at it or while
//! its tables are read, and this process is not the one. One such process looks at many files, and a fresh one follows if it dies.
//!
//! ```text
//!   host                           child
//!   Inspector ── file ──────────►  serve ── maps it, reads its tables
//!             ◄── description ───
//! ```
//! Nothing of a plugin but `ability` is called there either, and what is found right is not made safe to run by that.

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
use std::time::Duration;

use jde_abi::describe;
use serde::{Deserialize, Serialize};

use super::LoadError;
use super::load::held;
use crate::apart::{Frame, Kind, Program, Wire, as_bytes, end_in_words};
pub use serve::serve;

/// How long a look at one file may take: a library is mapped in milliseconds, and a constructor that has not returned by then is not
/// going to.
const PATIENCE: Duration = Duration::from_secs(20);
/// Most of what a dying process said that is repeated, in bytes.
const MOST_SAID: usize = 300;

/// What is asked of the child.
#[derive(Serialize, Deserialize)]
struct Question {
    /// The file that is mapped.
    #[serde(with = "as_bytes")]
    copy: PathBuf,
    /// The file that people know.
    #[serde(with = "as_bytes")]
    path: PathBuf,
}

/// What it answers.
#[derive(Serialize, Deserialize)]
enum Answer {
    Plugin(#[serde(with = "description::Plugin")] describe::Plugin),
    Refused(String),
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
        let question = Question {
            copy: copy.to_owned(),
            path: path.to_owned(),
        };
        let mut present = self.child.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let mut child = match present.take() {
                Some(child) => child,
                None => Child::start(&self.program).map_err(LoadError::NoInspection)?,
            };
            match child.ask(&question) {
                Ok(answer) => {
                    child.used = true;
                    *present = Some(child);
                    return match answer {
                        Answer::Plugin(plugin) => Ok(plugin),
                        Answer::Refused(reason) => Err(LoadError::Foreign(reason)),
                    };
                }
                // What it looked at before may be to blame.
                Err(_) if child.used => {}
                Err(error) => return Err(LoadError::Deadly(child.last_words(&error))),
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
        let wire = Wire::new(ours);
        wire.set_patience(Some(PATIENCE))?;
        Ok(Self {
            process,
            wire,
            said,
            used: false,
        })
    }

    fn ask(&mut self, question: &Question) -> io::Result<Answer> {
        self.wire.send(&Frame {
            bytes: serde_json::to_vec(question)?,
            ..Frame::new(Kind::Start)
        })?;
        Ok(serde_json::from_slice(&self.wire.receive()?.bytes)?)
    }

    /// What became of it.
    fn last_words(mut self, error: &io::Error) -> String {
        if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) {
            return format!("a look at it has not ended in {} s", PATIENCE.as_secs());
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

impl Drop for Child {
    fn drop(&mut self) {
        // Fails only for one that is gone already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
