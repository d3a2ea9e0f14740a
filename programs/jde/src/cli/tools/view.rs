//! `jde view`: opens windows on a running application or a recording.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_core::Nanos;
use jde_session::log::{Filter, Log};

use super::client::{Context, Target};
use crate::failure::Failure;
use crate::quantity;
use crate::windows;

/// Open windows on a running application, on this machine or across a network, or on a recording.
///
/// The oscilloscope shows the state of each schema and its reason. Other windows show sensors and motors with
/// teleoperation, a 3D view, variables, and the schemas' own panels. Without a name it opens the only running
/// application, or a start page that lists running applications and recordings. Closing the windows, or
/// killing them, does not affect the robot.
#[derive(Args)]
#[command(after_help = "Examples:
  jde view
  jde view safe-navigation
  jde view drive.mcap
  jde view drive.mcap --from 66.5s
  jde view --at tls/robot2:7447 --key me.toml")]
pub(crate) struct View {
    /// The name of a running application, or a recording: a file that ends in .mcap, or a path with a /.
    #[arg(value_name = "NAME|FILE", value_hint = ValueHint::AnyPath)]
    source: Option<OsString>,
    /// Show the recording at this time of the drive, and pause it there.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time_offset)]
    from: Option<Nanos>,
    #[command(flatten)]
    target: Target,
}

impl View {
    pub(super) fn run(self, context: &Context, filter: Option<Filter>) -> Result<(), Failure> {
        Log::start(filter.unwrap_or_default());
        let (recording, application) = self.resolve_source()?;
        let reach = context.reach(&self.target)?;
        if let (None, Some(_)) = (&recording, self.from) {
            return Err(Failure::usage(
                "--from is for a recording",
                "name its file: jde view drive.mcap --from 66.5s",
            ));
        }
        windows::open(
            reach,
            application,
            recording,
            self.from,
            &self.target.link_options(),
        )
    }

    /// Returns the recording or the application to open. Neither selects the only running application, or the
    /// start page.
    fn resolve_source(&self) -> Result<(Option<PathBuf>, Option<String>), Failure> {
        let Some(source) = &self.source else {
            return Ok((None, self.target.app.clone()));
        };
        let bytes = source.as_encoded_bytes();
        if bytes.ends_with(b".mcap") || bytes.contains(&b'/') {
            let file = PathBuf::from(source);
            let shown = file.display();
            if let Some(app) = self.target.typed_app() {
                return Err(Failure::usage(
                    format!("{shown} is a recording, and --app {app} names an application"),
                    "give one of the two",
                ));
            }
            if self.target.has_typed_endpoint() {
                return Err(Failure::usage(
                    format!("{shown} is a recording on this machine, and --at is for another machine"),
                    "omit --at, or name an application that runs there",
                ));
            }
            // Open the file here to report an unreadable one on the command line.
            jde_files::open(&file).map_err(Failure::file(&file))?;
            return Ok((Some(file), None));
        }
        let name = source.to_str().ok_or_else(|| {
            Failure::usage(
                format!("no application is called {}", source.display()),
                "jde apps lists the running ones",
            )
        })?;
        match self.target.typed_app() {
            Some(app) if app != name => Err(Failure::usage(
                format!("`{name}` and --app {app} name two applications"),
                "give one of the two",
            )),
            Some(_) | None => Ok((None, Some(name.to_owned()))),
        }
    }
}
