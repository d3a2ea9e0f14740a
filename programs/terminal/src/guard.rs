//! Restores the terminal of a view whose process ends without doing so: it is killed, has no memory, or has a fault that no
//! code survives. A child process waits for that. It holds nothing but the terminal and a pipe, and reads no keys.

use std::io::{self, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};

use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::LeaveAlternateScreen;
use rustix::process::getpgrp;
use rustix::termios::{OptionalActions, tcgetattr, tcgetpgrp, tcsetattr};

use crate::interrupt::SignalListener;

/// The argument that makes this program such a child.
pub const GUARD: &str = "--guard-terminal";

/// The child process, until the terminal is restored.
pub(super) struct TerminalGuard {
    child: Child,
    pipe: ChildStdin,
}

impl TerminalGuard {
    /// Starts the child, before the terminal is changed. `None` if the system refuses it: then the view has no guard.
    pub(super) fn start() -> Option<Self> {
        let mut child = Command::new("/proc/self/exe")
            .arg(GUARD)
            .stdin(Stdio::piped())
            .stdout(Stdio::inherit())
            .stderr(Stdio::piped())
            .spawn()
            .ok()?;
        let (pipe, ready) = (child.stdin.take(), child.stderr.take());
        let guard = Self { child, pipe: pipe? };
        // Until the child knows the terminal as it is now. The pipe ends if it cannot.
        ready?.read_exact(&mut [0]).ok()?;
        Some(guard)
    }
}

/// The terminal is restored, and the child has nothing to do.
impl Drop for TerminalGuard {
    fn drop(&mut self) {
        // It may have been killed.
        let _ = self.pipe.write_all(b"q");
        let _ = self.child.wait();
    }
}

/// Waits as the child for the end of the view, and restores the terminal unless the view has.
///
/// # Errors
/// Standard output is no terminal.
pub fn serve_guard() -> Result<(), io::Error> {
    // The end of the pipe ends this process. A signal to the whole job must not.
    let _listener = SignalListener::on_each(|_, _| {})?;
    let mut terminal = io::stdout();
    let before = tcgetattr(&terminal)?;
    io::stderr().write_all(b"r")?;
    let is_restored = io::stdin().read(&mut [0])? > 0;
    if !is_restored {
        // A shell that has taken its terminal back has set it already, and the system would stop this process for it.
        if tcgetpgrp(&terminal).is_ok_and(|foreground| foreground == getpgrp()) {
            tcsetattr(&terminal, OptionalActions::Now, &before)?;
        }
        execute!(terminal, LeaveAlternateScreen, Show)?;
    }
    Ok(())
}
