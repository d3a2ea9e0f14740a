//! A recording read for pictures and pages: which stretch of it, which of its numbers by name, and where what comes of it goes.
//! How it looks is the business of `jde-report`.

mod output;
mod series;

use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_log::Recording;
use jde_report::{Analysis, Wanted};

use crate::failure::{Failure, shown};
use crate::terminal::{self, FAINT};

pub(crate) use output::Output;
pub(crate) use series::{names, series};

/// What takes no longer than this needs no word on how far it is, and between two words there is as much time.
const TELL: Duration = Duration::from_millis(300);

/// A stretch of the application's time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Stretch {
    /// Without it from the beginning.
    pub(crate) from: Option<Nanos>,
    /// Without it to the end.
    pub(crate) to: Option<Nanos>,
}

impl Stretch {
    /// Whether it is one of this recording.
    ///
    /// # Errors
    /// It ends before it begins, or begins when the recording has ended.
    fn check(self, recording: &Recording) -> Result<(), Failure> {
        if let (Some(from), Some(to)) = (self.from, self.to)
            && from >= to
        {
            return Err(Failure::usage(
                "--from is not before --to",
                "give --from the earlier time of the two",
            ));
        }
        let said = recording.metadata("jde").and_then(|jde| jde.get("start_ns"));
        let Some((first, last)) = recording.times() else {
            return Ok(());
        };
        let start = said.and_then(|start| start.parse().ok()).unwrap_or(first);
        let [first, last] = [first, last].map(|time: u64| time.saturating_sub(start));
        if self.from.is_some_and(|from| from >= last) || self.to.is_some_and(|to| to <= first) {
            return Err(Failure::usage(
                format!("there is nothing of {} in that time", shown(recording.path())),
                format!(
                    "it goes from {:.3} s to {:.3} s",
                    first as f64 / 1e9,
                    last as f64 / 1e9
                ),
            ));
        }
        Ok(())
    }
}

/// Reads a recording, and says on a terminal how far it is.
///
/// # Errors
/// It cannot be read, or has no such time. Damage is no error.
pub(crate) fn read(recording: &Recording, stretch: Stretch, wanted: Wanted) -> Result<Analysis, Failure> {
    stretch.check(recording)?;
    let wanted = Wanted {
        from: stretch.from,
        to: stretch.to,
        ..wanted
    };
    let mut progress = Progress::new(recording.path());
    let analysis = Analysis::read(recording, wanted, &mut |share| progress.tell(share));
    progress.clear();
    Ok(analysis?)
}

/// A line on the terminal that tells how far it is.
struct Progress {
    file: String,
    wanted: bool,
    next: Instant,
    told: bool,
}

impl Progress {
    fn new(file: &Path) -> Self {
        Self {
            file: shown(file),
            wanted: terminal::err_is_terminal(),
            next: Instant::now() + TELL,
            told: false,
        }
    }

    fn tell(&mut self, share: f64) {
        if self.wanted && Instant::now() >= self.next {
            (self.next, self.told) = (Instant::now() + TELL, true);
            let (file, percent) = (&self.file, share * 100.0);
            // Who closed standard error does not want to hear of it.
            let _ = write!(
                terminal::err(),
                "\r{FAINT}reading {file}: {percent:.0} %{FAINT:#} "
            );
        }
    }

    fn clear(&self) {
        if self.told {
            let blank = " ".repeat(self.file.chars().count() + 20);
            let _ = write!(terminal::err(), "\r{blank}\r");
        }
    }
}
