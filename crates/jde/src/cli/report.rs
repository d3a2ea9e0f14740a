//! `jde report`: a recording as a page.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_core::Nanos;
use jde_log::{Cast, Recording};
use jde_report::Wanted;

use super::quantity;
use crate::failure::{Failure, shown};
use crate::recorded::{self, Output, Stretch};

/// Tell a recording on a page: path, states, switches with their reasons, how groups and schemas did, and what happened.
///
/// One file of HTML with all in it, to be sent, kept or printed: it fetches nothing, and reads without a script. Reads any MCAP file,
/// also of others: what can be told is told, and what is missing or damaged is said.
#[derive(Args)]
#[command(after_help = "Examples:
  jde report drive.mcap
  jde report drive.mcap --from 10s --to 40s -o failure.html
  ssh robot2 jde report drive.mcap -o - > drive.html")]
pub(super) struct Report {
    /// The recording.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// The HTML file, - for standard output; without it one named after the recording.
    #[arg(short, long = "output", value_name = "FILE.html", value_hint = ValueHint::FilePath)]
    output: Option<PathBuf>,
    /// Begin at this time of the application.
    #[arg(long, value_name = "TIME", value_parser = quantity::place)]
    from: Option<Nanos>,
    /// End at this time of the application.
    #[arg(long, value_name = "TIME", value_parser = quantity::place)]
    to: Option<Nanos>,
}

impl Report {
    pub(super) fn run(self) -> Result<(), Failure> {
        let recording = Recording::open(&self.file)?;
        let output = Output::of(self.output, &recording, "html", "page")?;
        let schemas = Cast::of_recording(&recording).map_or(0, |cast| cast.schemas.len());
        let wanted = Wanted {
            columns: jde_report::columns(schemas),
            ..Wanted::default()
        };
        let stretch = Stretch {
            from: self.from,
            to: self.to,
        };
        let analysis = recorded::read(&recording, stretch, wanted)?;
        output.write(jde_report::page(&analysis, &shown(&self.file)).as_bytes())
    }
}
