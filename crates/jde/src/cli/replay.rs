//! `jde replay`: takes a recorded drive again.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_core::Nanos;
use jde_host::app::Override;
use jde_log::replay::Span;

use super::{log, quantity};
use crate::failure::Failure;
use crate::log::Filter;
use crate::replay::{self, How};

/// Take a recorded drive again, and say which selections are not as they were.
///
/// Every schema but the drivers takes the turns it took then, in the order of then, and sees the values it saw then; what the
/// drivers exported comes from the recording, and commands reach nobody. So what is decided otherwise is the doing of what has
/// changed: a new build of a plugin, a constant, a policy. Drives in real time are compared as exactly as those in lockstep.
///
/// The exit status is 0 if every selection is as it was, 1 if not, 2 if the recording cannot be read or lacks something, 3 if a
/// plugin is missing.
#[derive(Args)]
#[command(after_help = "Examples:
  jde run safe-navigation --record drive.mcap
  jde replay --decide drive.mcap                          the application as it was, with the plugins as they are
  jde replay --decide drive.mcap --set stop.ahead=0.9     what if?
  jde replay --decide drive.mcap --app new.toml --json")]
pub(super) struct Replay {
    /// The recording: a whole run, from its start on.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// Have the schemas decide again, and compare.
    #[arg(long, required = true)]
    decide: bool,
    /// The application's file, or the name of one in apps, instead of the one in the recording.
    #[arg(long = "app", value_name = "APP", value_hint = ValueHint::FilePath)]
    application: Option<PathBuf>,
    /// Give a modulation another value at the start (repeatable).
    #[arg(long, value_name = "SCHEMA.VARIABLE=VALUE")]
    set: Vec<Override>,
    /// Compare from this time of the drive on; what was before is taken again too.
    #[arg(long, value_name = "TIME", value_parser = quantity::time)]
    from: Option<Nanos>,
    /// Go no further than this time of the drive.
    #[arg(long, value_name = "TIME", value_parser = quantity::time)]
    to: Option<Nanos>,
    /// End standard output with one line of JSON; all words go to standard error.
    #[arg(long)]
    json: bool,
}

impl Replay {
    /// Runs it.
    pub(super) fn run(self, filter: Option<Filter>) -> Result<(), Failure> {
        let span = Span {
            from: self.from.unwrap_or(0),
            to: self.to.unwrap_or(Nanos::MAX),
        };
        if span.from > span.to {
            return Err(Failure::usage(
                "--from is later than --to",
                "give --from the earlier time of the two",
            ));
        }
        debug_assert!(self.decide, "clap asks for it");
        let how = How {
            file: self.file,
            application: self.application,
            sets: self.set,
            span,
            json: self.json,
        };
        replay::decide(how, |loaded| log(filter, loaded))
    }
}
