//! A recording in place of an application that runs, for the verbs that only look.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_terminal as terminal;

use super::Target;
use crate::failure::{Failure, display_path};
use crate::replay::{Asked, Moment, TIME_HELP};

/// The recording that is asked.
#[derive(Args)]
pub(crate) struct Past {
    /// Ask this recording instead of an application: as it was at the time --at, such as --at 12.4s or, in UTC,
    /// --at 19:06:45Z; or at its end.
    #[arg(long = "in", value_name = "FILE.mcap", value_hint = ValueHint::FilePath)]
    recording: Option<PathBuf>,
}

impl Past {
    /// Serves of the recording what is asked, if there is one, and lets the target name it. It can be asked as long as the
    /// result is kept.
    ///
    /// # Errors
    /// It cannot be read, or --at is no time.
    pub(super) fn serve(&self, target: &mut Target, asked: &Asked) -> Result<Option<Moment>, Failure> {
        let Some(file) = &self.recording else {
            return Ok(None);
        };
        let moment = Moment::serve(file, time(target)?, asked)?;
        for note in &moment.notes {
            writeln!(terminal::err(), "{}: {note}", display_path(file))?;
        }
        *target = Target {
            app: Some(moment.name().to_owned()),
            is_recording: true,
            ..Target::default()
        };
        Ok(Some(moment))
    }

    /// Whether a recording is asked.
    pub(super) fn is_asked(&self) -> bool {
        self.recording.is_some()
    }
}

/// Returns the time that `--at` names for a recording, as it was typed.
fn time(target: &Target) -> Result<Option<&str>, Failure> {
    match target.at.as_slice() {
        _ if !target.has_typed_endpoint() => Ok(None),
        [at] => Ok(Some(at)),
        _ => Err(Failure::usage("--at is given several times", TIME_HELP)),
    }
}
