//! `jde report`: writes a recording as an HTML page.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_log::{RecordedHierarchy, Recording};
use jde_report::Wanted;

use crate::analysis::{self, Output, TimeRange};
use crate::failure::{Failure, display_path};

/// Write a page about a recording: path, states, switches with their reasons, groups, schemas and events.
///
/// The page is one HTML file to send, keep or print. It fetches nothing and is readable without a script.
/// Reads any MCAP file of any writer, and reports what is missing or damaged.
#[derive(Args)]
#[command(after_help = "Examples:
  jde report drive.mcap
  jde report drive.mcap --from 10s --to 40s -o failure.html
  ssh robot2 jde report drive.mcap -o - > drive.html")]
pub(crate) struct Report {
    /// The recording.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// The HTML file, or - for standard output. By default it is named after the recording.
    #[arg(short, long = "output", value_name = "FILE.html", value_hint = ValueHint::FilePath)]
    output: Option<PathBuf>,
    #[command(flatten)]
    time_range: TimeRange,
}

impl Report {
    pub(super) fn run(self) -> Result<(), Failure> {
        let recording = Recording::open(&self.file)?;
        let output = Output::resolve(self.output, &recording, &[], "html", "page")?;
        let (page, losses) = page(&recording, self.time_range)?;
        analysis::warn(&recording, &losses)?;
        output.write(page.as_bytes())
    }
}

/// Returns the page of a recording, and what of that is damaged or lost.
///
/// # Errors
/// The recording cannot be read, or does not cover the range.
pub(crate) fn page(recording: &Recording, time_range: TimeRange) -> Result<(String, Vec<String>), Failure> {
    let schemas = RecordedHierarchy::of_recording(recording).map_or(0, |cast| cast.schemas.len());
    let options = Wanted {
        columns: jde_report::columns(schemas),
        ..Wanted::default()
    };
    let analysis = analysis::read(recording, time_range, options)?;
    let page = jde_report::page(&analysis, &display_path(recording.path()));
    Ok((page, analysis.losses()))
}
