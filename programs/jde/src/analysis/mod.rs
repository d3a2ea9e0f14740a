//! Reads a recording for pictures and pages: the time range, the numbers by name, and the output. Layout
//! and drawing belong to `jde-report`.

mod output;
mod series;

use clap::Args;
use jde_core::Nanos;
use jde_log::Recording;
use jde_report::{Analysis, Wanted};
use jde_terminal::escape::escape;
use jde_terminal::{self as terminal, ProgressLine, WARN};

use crate::failure::{Failure, display_path};
use crate::quantity;

pub(crate) use output::Output;
pub(crate) use series::{names, series};

/// A range of application time, ns since the start; the recording's begin or end if not given.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct TimeRange {
    /// Start at this time of the application.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time_offset)]
    from: Option<Nanos>,
    /// End at this time of the application.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time_offset)]
    to: Option<Nanos>,
}

impl TimeRange {
    /// Returns a range of ns since the application's start.
    pub(crate) fn new(from: Option<Nanos>, to: Option<Nanos>) -> Self {
        Self { from, to }
    }

    /// Checks that the range overlaps the recording.
    ///
    /// # Errors
    /// `from` is not before `to`, or the range is outside the recording.
    fn check(self, recording: &Recording) -> Result<(), Failure> {
        if let (Some(from), Some(to)) = (self.from, self.to)
            && from >= to
        {
            return Err(Failure::usage(
                "--from is not before --to",
                "give --from the earlier time of the two",
            ));
        }
        let start = recording.metadata("jde").and_then(|jde| jde.get("start_ns"));
        let Some((first, last)) = recording.times() else {
            return Ok(());
        };
        let start = start.and_then(|start| start.parse().ok()).unwrap_or(first);
        let [first, last] = [first, last].map(|time: u64| time.saturating_sub(start));
        if self.from.is_some_and(|from| from >= last) || self.to.is_some_and(|to| to <= first) {
            return Err(Failure::usage(
                format!("{} contains nothing in that time", display_path(recording.path())),
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

/// Says on standard error what of a recording is damaged or lost.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn warn(recording: &Recording, losses: &[String]) -> Result<(), Failure> {
    let file = display_path(recording.path());
    for loss in losses {
        writeln!(terminal::err(), "{WARN}{file}{WARN:#}: {}", escape(loss))?;
    }
    Ok(())
}

/// Reads a recording, and shows the progress on a terminal.
///
/// # Errors
/// The recording cannot be read, or does not cover the range. Damage is not an error.
pub(crate) fn read(
    recording: &Recording,
    time_range: TimeRange,
    options: Wanted,
) -> Result<Analysis, Failure> {
    time_range.check(recording)?;
    let options = Wanted {
        from: time_range.from,
        to: time_range.to,
        ..options
    };
    let mut progress = ProgressLine::default();
    let file = display_path(recording.path());
    let analysis = Analysis::read(recording, options, &mut |share| {
        progress.update(|| format!("reading {file}: {:.0} %", share * 100.0));
    });
    progress.clear();
    Ok(analysis?)
}
