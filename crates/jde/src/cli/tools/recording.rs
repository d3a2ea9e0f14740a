//! The options of verbs that record a run: what to record, the file, and when.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_core::Nanos;
use jde_log::{PartSize, SplitOptions};

use super::quantity;
use crate::failure::Failure;
use crate::session::{PanelOptions, RecordOptions, TriggerWindow};

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
    panels: PanelArgs,
    #[command(flatten)]
    trigger: TriggerArgs,
    #[command(flatten)]
    splitting: SplitArgs,
}

/// Panels in a recording. The verb has an argument `file`, the recording to write.
#[derive(Args)]
pub(super) struct PanelArgs {
    /// Also record the panels of all schemas, or of the schemas that match.
    #[arg(long, value_name = "SCHEMA", num_args = 0..=1, require_equals = true, default_missing_value = "*",
          value_delimiter = ',', requires = "file")]
    panels: Vec<String>,
    /// The most drawings of each panel per second. A panel is drawn at most 30 times per second.
    #[arg(long, value_name = "HZ", default_value = "5", value_parser = quantity::rate, requires = "panels")]
    panel_rate: f64,
}

/// Recording around chosen moments only. The verb has an argument `file`, the recording to write.
#[derive(Args)]
pub(super) struct TriggerArgs {
    /// Record only around the moments at which this condition becomes true, to FILE-001, FILE-002 and so on
    /// (repeatable). Conditions: collision, absence or chatter>N, each also with :GROUP; overrun or fault,
    /// each also with :SCHEMA; refused; operator; or an expression over variables, as in
    /// 'pioneer.odometry.twist.twist.linear.x > 0.4'.
    #[arg(long, value_name = "CONDITION", requires = "file")]
    when: Vec<String>,
    /// The time to keep before the condition.
    #[arg(long, value_name = "TIME", value_parser = quantity::time, default_value = "60s", requires = "when")]
    before: Nanos,
    /// The time to record after a condition last became true.
    #[arg(long, value_name = "TIME", value_parser = quantity::time, default_value = "10s", requires = "when")]
    after: Nanos,
    /// The most memory for the time before the condition. When it is full, the oldest data is dropped.
    #[arg(long, value_name = "SIZE", value_parser = quantity::size, default_value = "256MB", requires = "when")]
    memory: usize,
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
        let (panels, around) = (self.panels.into_panels(), self.trigger.into_trigger());
        let (only, overwrite, split) = (self.only, self.overwrite, self.splitting.into_split()?);
        Ok(self.file.map(|file| RecordOptions {
            file,
            patterns: only,
            overwrite,
            panels,
            trigger: around,
            split,
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
                "keep more, or split into smaller files: the one that is written counts as well",
            ));
        }
        Ok(self.split.map(|every| SplitOptions {
            part_size: every,
            max_total_bytes: keep,
        }))
    }
}

impl PanelArgs {
    /// Returns the panels to record, or `None` if none are requested.
    pub(super) fn into_panels(self) -> Option<PanelOptions> {
        (!self.panels.is_empty()).then_some(PanelOptions {
            patterns: self.panels,
            rate: self.panel_rate,
        })
    }
}

impl TriggerArgs {
    /// Returns the moments to record, or `None` if none are requested.
    pub(super) fn into_trigger(self) -> Option<TriggerWindow> {
        (!self.when.is_empty()).then_some(TriggerWindow {
            conditions: self.when,
            before: self.before,
            after: self.after,
            memory: self.memory,
        })
    }
}
