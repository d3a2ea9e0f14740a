//! The progress of long work, on the last line of a terminal. Prints nothing into a pipe.

use std::io::Write;
use std::time::{Duration, Instant};

use super::{FAINT, TextWriter};

/// Time before the line appears, and between two updates of it.
const UPDATE_INTERVAL: Duration = Duration::from_millis(300);

/// The line.
pub struct ProgressLine {
    /// Standard error, if it is a terminal.
    output: Option<TextWriter>,
    next: Instant,
    /// The length of the line that is shown.
    shown: usize,
}

impl Default for ProgressLine {
    /// A line that appears if the work takes long.
    fn default() -> Self {
        Self {
            output: super::err_is_terminal().then(super::err),
            next: Instant::now() + UPDATE_INTERVAL,
            shown: 0,
        }
    }
}

impl ProgressLine {
    /// Shows this text instead of the previous one, once in 300 ms at most.
    pub fn update(&mut self, text: impl FnOnce() -> String) {
        if Instant::now() >= self.next
            && let Some(output) = &mut self.output
        {
            let text = text();
            (self.next, self.shown) = (Instant::now() + UPDATE_INTERVAL, text.chars().count());
            // A closed terminal is not a reason to fail.
            let _ = output
                .write_all(b"\r")
                .and_then(|()| write!(output, "{FAINT}{text}{FAINT:#} "))
                .and_then(|()| output.flush());
        }
    }

    /// Removes the line.
    pub fn clear(&mut self) {
        if let Some(output) = self.output.as_mut().filter(|_| self.shown > 0) {
            let blank = " ".repeat(self.shown + 1);
            let _ = output
                .write_all(format!("\r{blank}\r").as_bytes())
                .and_then(|()| output.flush());
        }
    }
}
