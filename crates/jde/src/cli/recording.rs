//! The options of whatever records a run: what, where to, and when.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_core::Nanos;
use jde_log::{Every, Split};

use super::quantity;
use crate::failure::Failure;
use crate::session::{Around, Panels, Record};

/// What is recorded.
#[derive(Args)]
pub(super) struct Recording {
    /// Record every variable, selection, change of state and fault to this MCAP file, for Foxglove, Rerun and PlotJuggler.
    #[arg(long = "record", value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: Option<PathBuf>,
    /// Record only variables like these: full names with * for any letters, as in `pioneer.*` and `*.laser`.
    #[arg(long = "record-only", value_name = "PATTERN", num_args = 1.., requires = "file")]
    only: Vec<String>,
    /// Write over a recording that is there.
    #[arg(long, requires = "file")]
    overwrite: bool,
    #[command(flatten)]
    panels: RecordedPanels,
    #[command(flatten)]
    waiting: Waiting,
    #[command(flatten)]
    splitting: Splitting,
}

/// Panels in a recording. Of a verb whose `file` is where it is recorded to.
#[derive(Args)]
pub(super) struct RecordedPanels {
    /// Record the panels that schemas draw of themselves as well: all of them, or those of schemas like these.
    #[arg(long, value_name = "SCHEMA", num_args = 0..=1, require_equals = true, default_missing_value = "*",
          value_delimiter = ',', requires = "file")]
    panels: Vec<String>,
    /// Most drawings of each in a second; a panel is drawn 30 times a second at most.
    #[arg(long, value_name = "HZ", default_value = "5", value_parser = quantity::rate, requires = "panels")]
    panel_rate: f64,
}

/// Recording only around the moments that matter. Of a verb whose `file` is where it is recorded to.
#[derive(Args)]
pub(super) struct Waiting {
    /// Write nothing until this comes true, and then what was before and comes after, to FILE-001, FILE-002 and so on
    /// (repeatable): collision, absence or chatter>N, each also with :GROUP; overrun or fault, each also with :SCHEMA; refused;
    /// operator; or an expression over variables, as in 'pioneer.odometry.twist.twist.linear.x > 0.4'.
    #[arg(long, value_name = "CONDITION", requires = "file")]
    when: Vec<String>,
    /// How much of what was before.
    #[arg(long, value_name = "TIME", value_parser = quantity::time, default_value = "60s", requires = "when")]
    before: Nanos,
    /// How much of what comes after a condition last came true.
    #[arg(long, value_name = "TIME", value_parser = quantity::time, default_value = "10s", requires = "when")]
    after: Nanos,
    /// Most memory for what was before; the oldest goes when it is full.
    #[arg(long, value_name = "SIZE", value_parser = quantity::size, default_value = "256MB", requires = "when")]
    memory: usize,
}

/// Recording for ever. Of a verb whose `file` is where it is recorded to.
#[derive(Args)]
pub(super) struct Splitting {
    /// Write one file after the other, FILE-001, FILE-002 and so on, each of this size or time, such as 1GB or 10min. Each can be
    /// read alone, and what reads recordings reads all of them as one.
    #[arg(long, value_name = "SIZE|TIME", value_parser = quantity::every, requires = "file", conflicts_with = "when")]
    split: Option<Every>,
    /// Delete the oldest of these files when all together are larger, also those that earlier recordings to FILE have left.
    #[arg(long, value_name = "SIZE", value_parser = quantity::size, requires = "split")]
    keep: Option<usize>,
}

impl Recording {
    /// What is asked for, if anything is.
    ///
    /// # Errors
    /// It is nonsense.
    pub(super) fn wanted(self) -> Result<Option<Record>, Failure> {
        let (panels, around) = (self.panels.wanted(), self.waiting.wanted());
        let (only, overwrite, split) = (self.only, self.overwrite, self.splitting.wanted()?);
        Ok(self.file.map(|file| Record {
            file,
            only,
            overwrite,
            panels,
            around,
            split,
        }))
    }
}

impl Splitting {
    /// Which files are asked for, if one is not enough.
    ///
    /// # Errors
    /// Less is to be kept than two of them are.
    pub(super) fn wanted(self) -> Result<Option<Split>, Failure> {
        let keep = self.keep.map(|keep| keep as u64);
        if let (Some(Every::Bytes(each)), Some(keep)) = (self.split, keep)
            && keep < each.saturating_mul(2)
        {
            return Err(Failure::usage(
                "--keep is less than two files of --split",
                "keep more, or split into smaller files: the one that is written counts as well",
            ));
        }
        Ok(self.split.map(|every| Split { every, keep }))
    }
}

impl RecordedPanels {
    /// Which are asked for, if any are.
    pub(super) fn wanted(self) -> Option<Panels> {
        (!self.panels.is_empty()).then_some(Panels {
            only: self.panels,
            rate: self.panel_rate,
        })
    }
}

impl Waiting {
    /// Which moments are asked for, if any are.
    pub(super) fn wanted(self) -> Option<Around> {
        (!self.when.is_empty()).then_some(Around {
            conditions: self.when,
            before: self.before,
            after: self.after,
            memory: self.memory,
        })
    }
}
