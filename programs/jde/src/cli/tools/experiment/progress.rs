//! The progress of an experiment on standard error: one line that is written anew on a terminal, and a plain
//! line every few seconds elsewhere.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use jde_drawing::text::counted;
use jde_experiment::result::{DriveResult, Outcome};
use jde_terminal::escape::without_styles;
use jde_terminal::{self as terminal, BAD, FAINT};

/// The time between two lines: on a terminal the eye follows no more, and in a file a minute has few lines.
const TERMINAL_INTERVAL: Duration = Duration::from_millis(100);
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// The progress so far.
pub(super) struct Progress {
    total: usize,
    done: usize,
    failed: usize,
    /// Drives that were done before.
    before: usize,
    started: Instant,
    shown: Instant,
    /// The length of the line that a terminal shows.
    width: usize,
    is_terminal: bool,
}

impl Progress {
    /// Begins with the results that are known already.
    pub(super) fn new(total: usize, known: &[DriveResult]) -> Self {
        let now = Instant::now();
        Self {
            total,
            done: known.len(),
            failed: known
                .iter()
                .filter(|result| result.outcome != Outcome::Passed)
                .count(),
            before: known.len(),
            started: now,
            shown: now,
            width: 0,
            is_terminal: terminal::err_is_terminal(),
        }
    }

    /// Adds a result, and shows the progress if it is time.
    ///
    /// # Errors
    /// Standard error cannot be written.
    pub(super) fn add(&mut self, result: &DriveResult) -> io::Result<()> {
        self.done += 1;
        self.failed += usize::from(result.outcome != Outcome::Passed);
        let interval = if self.is_terminal {
            TERMINAL_INTERVAL
        } else {
            PLAIN_INTERVAL
        };
        if self.shown.elapsed() < interval {
            return Ok(());
        }
        self.shown = Instant::now();
        self.show()
    }

    /// Shows the end, and leaves the line.
    ///
    /// # Errors
    /// Standard error cannot be written.
    pub(super) fn finish(&mut self) -> io::Result<()> {
        self.show()?;
        if self.is_terminal {
            writeln!(terminal::err())?;
        }
        Ok(())
    }

    fn show(&mut self) -> io::Result<()> {
        let text = self.text();
        let mut output = terminal::err();
        if self.is_terminal {
            let width = without_styles(&text).len();
            // Spaces cover what is left of a longer line.
            output.write_all(b"\r")?;
            write!(output, "{text}{}", " ".repeat(self.width.saturating_sub(width)))?;
            self.width = width;
        } else {
            writeln!(output, "{text}")?;
        }
        output.flush()
    }

    fn text(&self) -> String {
        let seconds = self.started.elapsed().as_secs_f64();
        let rate = (self.done - self.before) as f64 / seconds.max(1e-3);
        let (drives, failed) = (counted(self.total as u64, "drive"), self.failed);
        let style = if failed > 0 { BAD } else { FAINT };
        let mut text = format!("{} of {drives}, {style}{failed} failed{style:#}", self.done);
        if rate > 0.0 {
            text += &format!(", {rate:.1} drives/s");
        }
        match self.total - self.done {
            0 => text += &format!(", took {}", minutes(seconds)),
            left if rate > 0.0 => text += &format!(", {} left", minutes(left as f64 / rate)),
            _ => {}
        }
        text
    }
}

/// "8 s", "2 min 05 s".
fn minutes(seconds: f64) -> String {
    let seconds = seconds.ceil() as u64;
    match seconds / 60 {
        0 => format!("{seconds} s"),
        minutes => format!("{minutes} min {:02} s", seconds % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::minutes;

    #[test]
    fn times_are_whole_seconds_and_minutes() {
        assert_eq!(minutes(0.2), "1 s");
        assert_eq!(minutes(59.0), "59 s");
        assert_eq!(minutes(125.0), "2 min 05 s");
    }
}
