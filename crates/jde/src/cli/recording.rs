//! The options of whatever records a run: what, where to, and when.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_core::Nanos;

use super::quantity;
use crate::session::{Around, Record};

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

impl Recording {
    /// What is asked for, if anything is.
    pub(super) fn wanted(self) -> Option<Record> {
        let around = (!self.when.is_empty()).then_some(Around {
            conditions: self.when,
            before: self.before,
            after: self.after,
            memory: self.memory,
        });
        let (only, overwrite) = (self.only, self.overwrite);
        self.file.map(|file| Record {
            file,
            only,
            overwrite,
            around,
        })
    }
}
