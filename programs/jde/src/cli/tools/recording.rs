//! The options of verbs that record a run: what to record, the file, and when.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_recorder::{PartSize, SplitOptions};

use crate::extensions::{PanelOptions, RecordOptions, TriggerWindow};
use crate::failure::Failure;
use crate::quantity;

/// What to record.
#[derive(Args)]
pub(super) struct RecordingArgs {
    /// Record every variable, selection, change of state and fault to this MCAP file, for Foxglove, Rerun and
    /// PlotJuggler.
    #[arg(long = "record", value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: Option<PathBuf>,
    /// Record only the variables that match: full names with * for any text, as in `pioneer.*` and
    /// `*.laser`.
    #[arg(long = "record-only", value_name = "PATTERN", num_args = 1.., requires = "file")]
    only: Vec<String>,
    /// Overwrite an existing recording.
    #[arg(long, requires = "file")]
    overwrite: bool,
    #[command(flatten)]
    panels: Option<PanelOptions>,
    #[command(flatten)]
    trigger: Option<TriggerWindow>,
    #[command(flatten)]
    splitting: SplitArgs,
}

/// Recording without end. The verb has an argument `file`, the recording to write.
#[derive(Args)]
pub(super) struct SplitArgs {
    /// Write consecutive files FILE-001, FILE-002 and so on, each of this size or time, such as 1GB or 10min.
    /// Each can be read alone. All verbs that read recordings read them as one.
    #[arg(long, value_name = "SIZE|TIME", value_parser = quantity::part_limit, requires = "file", conflicts_with = "when")]
    split: Option<PartSize>,
    /// Delete the oldest of these files when their total size is larger, including files of earlier
    /// recordings to FILE.
    #[arg(long, value_name = "SIZE", value_parser = quantity::size, requires = "split")]
    keep: Option<usize>,
}

impl RecordingArgs {
    /// Returns the recording to make, or `None` if none is requested.
    ///
    /// # Errors
    /// The options contradict each other.
    pub(super) fn into_settings(self) -> Result<Option<RecordOptions>, Failure> {
        let split = self.splitting.into_split()?;
        Ok(self.file.map(|file| RecordOptions {
            file,
            patterns: self.only,
            overwrite: self.overwrite,
            panels: self.panels,
            trigger: self.trigger,
            split,
            log: None,
        }))
    }
}

impl SplitArgs {
    /// Returns how to split the recording, or `None` for one file.
    ///
    /// # Errors
    /// `--keep` is less than two files.
    pub(super) fn into_split(self) -> Result<Option<SplitOptions>, Failure> {
        let keep = self.keep.map(|keep| keep as u64);
        if let (Some(PartSize::Bytes(each)), Some(keep)) = (self.split, keep)
            && keep < each.saturating_mul(2)
        {
            return Err(Failure::usage(
                "--keep is less than two files of --split",
                "keep more, or split into smaller files: the file being written counts as well",
            ));
        }
        Ok(self.split.map(|every| SplitOptions {
            part_size: every,
            max_total_bytes: keep,
        }))
    }
}
