//! `jde plot`: draws a recording as a picture.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use clap_complete::ArgValueCompleter;
use jde_drawing::PictureError;
use jde_log::Recording;
use jde_report::{Size, Wanted, draw_recording};

use crate::analysis::{self, Output, TimeRange};
use crate::complete;
use crate::failure::{Failure, display_path};
use crate::quantity;

/// Draw a recording as a picture: the robot's path, or numbers over time, and the states of the schemas.
///
/// Without names: the path in the colours of the winners, over the walls if the recording has them. With
/// names of variables or of their fields: one chart for each unit. Below, on one time axis, are the states of
/// every schema and a mark at every change of winner. Reads any MCAP file of any writer, and a damaged file
/// up to the damage.
#[derive(Args)]
#[command(after_help = "Examples:
  jde plot drive.mcap
  jde plot drive.mcap pioneer.odometry.twist.twist.linear.x pioneer.velocity.linear.x --from 10s --to 40s
  jde plot drive.mcap --size 2400x1600 -o - | feh -")]
pub(crate) struct Plot {
    /// The recording.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// Numbers to draw: SCHEMA.VARIABLE, followed by .FIELD if needed.
    #[arg(value_name = "VARIABLE.FIELD", add = ArgValueCompleter::new(complete::recorded_fields))]
    variables: Vec<String>,
    /// The PNG file, or - for standard output. By default it is named after the recording and the variables.
    #[arg(short, long = "output", value_name = "FILE.png", value_hint = ValueHint::FilePath)]
    output: Option<PathBuf>,
    #[command(flatten)]
    time_range: TimeRange,
    /// Size of the picture in pixels. A larger picture shows the same with more detail.
    #[arg(long, value_name = "SIZE", value_parser = quantity::pixels, default_value = "1200x800")]
    size: Size,
}

impl Plot {
    pub(super) fn run(self) -> Result<(), Failure> {
        let recording = Recording::open(&self.file)?;
        let output = Output::resolve(self.output, &recording, &self.variables, "png", "picture")?;
        let (picture, losses) = picture(&recording, &self.variables, self.time_range, self.size)?;
        analysis::warn(&recording, &losses)?;
        output.write(&picture)
    }
}

/// Returns the picture of a recording as a PNG file: the path, or the named numbers, and the states. And what of the
/// recording is damaged or lost.
///
/// # Errors
/// The recording cannot be read, does not cover the range, has no such number, or nothing that can be drawn.
pub(crate) fn picture(
    recording: &Recording,
    variables: &[String],
    time_range: TimeRange,
    size: Size,
) -> Result<(Vec<u8>, Vec<String>), Failure> {
    let options = Wanted {
        columns: size.columns(),
        series: analysis::series(recording, variables)?,
        ..Wanted::default()
    };
    let analysis = analysis::read(recording, time_range, options)?;
    if analysis.is_empty() {
        return Err(Failure::usage(
            format!(
                "{} contains nothing that can be drawn: no path, no states, no numbers",
                display_path(recording.path())
            ),
            "`jde info` shows its contents; name numbers of it, such as odom.pose.pose.position.x",
        ));
    }
    let png = draw_recording(&analysis, size).png();
    let png = png.map_err(|error: PictureError| Failure::broken(error.to_string()))?;
    Ok((png, analysis.losses()))
}
