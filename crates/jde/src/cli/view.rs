//! `jde view`: windows on a running application or a recording.

use std::path::{Path, PathBuf};
use std::{env, fs};

use clap::{Args, ValueHint};
use jde_view::Opening;

use super::client::{Context, Target};
use crate::failure::Failure;

/// Open windows on a running application, here or across a network, or on a recording.
///
/// The oscilloscope shows who was in which state and why; beside it are sensors and motors with teleoperation, a 3D view,
/// variables, and the panels that schemas have of their own. Without a name the start page lists what runs and what was
/// recorded. Closing the windows, or killing them, does not touch the robot.
#[derive(Args)]
#[command(after_help = "Examples:
  jde view
  jde view safe-navigation
  jde view drive.mcap
  jde view --at tls/robot2:7447 --key me.toml")]
pub(super) struct View {
    /// An application that runs, by its name, or a recording.
    #[arg(value_name = "NAME|FILE", value_hint = ValueHint::AnyPath)]
    what: Option<String>,
    #[command(flatten)]
    target: Target,
}

impl View {
    pub(super) fn run(self, context: &Context) -> Result<(), Failure> {
        let is_file = |what: &str| what.ends_with(".mcap") || Path::new(what).is_file();
        let (recording, name) = match self.what {
            Some(what) if is_file(&what) => (Some(PathBuf::from(what)), None),
            what => (None, what),
        };
        if let Some(file) = &recording {
            // What cannot be read is said here, where it was typed.
            fs::File::open(file).map_err(Failure::file(file))?;
        }
        let reach = context.reach(&self.target)?;
        let program = env::current_exe()
            .map_err(|error| Failure::Broken(format!("this program does not find itself: {error}")))?;
        let opening = Opening {
            reach,
            application: name.or(self.target.app),
            recording,
            player: [
                program.display().to_string().as_str(),
                "replay",
                "--plain",
                "--stay",
            ]
            .map(str::to_owned)
            .to_vec(),
            recordings: env::current_dir().into_iter().collect(),
        };
        jde_view::run(opening).map_err(|error| {
            Failure::usage(
                error.to_string(),
                "without a screen: jde top in this terminal, or jde view --at on a machine that has one",
            )
        })
    }
}
