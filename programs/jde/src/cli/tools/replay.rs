//! `jde replay`: plays a recorded drive, or decides it again.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_app::Override;
use jde_core::Nanos;
use jde_decide::{Span, ToleranceEntry};
use jde_session::cli::start_log;
use jde_session::load::Trust;
use jde_session::log::Filter;

use crate::decide::{self, DecideOptions};
use crate::failure::Failure;
use crate::quantity;
use crate::replay::{self, PlayOptions};

/// Play a recording, or with --decide let the schemas decide again and report every difference.
///
/// A recording that plays can be inspected like a running application: by jde top, vars, watch, events, why.
/// On a terminal, keys pause it, step to the next takeover, seek and change its speed. `jde set replay.paused
/// true` and the other modulations of `replay` do the same from elsewhere.
///
/// With --decide every schema except the drivers runs its recorded turns in the recorded order and reads the
/// recorded values. The drivers' exports come from the recording, and commands reach no driver. Every
/// selection is compared, and every value that schemas export, command or write to their children. A
/// difference is therefore the effect of a change: a new build of a plugin, a constant, a policy. Drives in
/// real time are compared as exactly as those in lockstep.
///
/// The exit status is 0 if everything is equal, 1 if not, 2 if the recording cannot be read or lacks
/// something, 3 if a plugin is missing.
#[derive(Args)]
#[command(after_help = "Examples:
  jde run safe-navigation --record drive.mcap
  jde replay drive.mcap --speed 2x --from 30s
  jde replay drive.mcap --plain --loop &
  jde replay --decide drive.mcap                          the application as it was, with the plugins as they are
  jde replay --decide drive.mcap --set stop.ahead=0.9     what if?
  jde replay --decide drive.mcap --tolerance geometry_msgs/msg/Twist=1e-9
  jde replay --decide drive.mcap --app new.toml --json
  jde replay --decide drive.mcap --trust                  with the plugins that stand beside its application")]
pub(crate) struct Replay {
    /// The recording; with --decide, a whole run from its start.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// Let the schemas decide again, and compare.
    #[arg(long)]
    decide: bool,
    /// Use this application's file, or the name of one in the folder apps, instead of the one in the
    /// recording.
    #[arg(long = "app", value_name = "APP", value_hint = ValueHint::FilePath, requires = "decide")]
    application: Option<PathBuf>,
    /// Also search the plugin folders of the recording: the folder of its application's file, and the folders
    /// which that file names. Plugins there run with your rights, so use this only if you trust the
    /// recording.
    #[arg(long, requires = "decide", conflicts_with = "application")]
    trust: bool,
    /// Give a modulation another value at the start (repeatable).
    #[arg(long, value_name = "SCHEMA.VARIABLE=VALUE", requires = "decide")]
    set: Vec<Override>,
    /// Accept numbers that differ by at most this, in their own unit: in all values, or in values of one type
    /// (repeatable). By default they are compared to the bit.
    #[arg(long, value_name = "[TYPE=]NUMBER", requires = "decide")]
    tolerance: Vec<ToleranceEntry>,
    /// Start at this time of the drive; with --decide, compare from there on.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time_offset)]
    from: Option<Nanos>,
    /// Stop at this time of the drive.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time_offset,
          requires = "decide")]
    to: Option<Nanos>,
    /// End standard output with one line of JSON; all other text goes to standard error.
    #[arg(long, requires = "decide")]
    json: bool,
    #[command(flatten)]
    play: PlayOptions,
}

impl Replay {
    /// Whether the schemas decide again.
    pub(super) const fn decides(&self) -> bool {
        self.decide
    }

    /// Plays the recording, or decides it again.
    pub(super) fn run(self, filter: Option<Filter>) -> Result<(), Failure> {
        if !self.decide {
            return replay::play(&self.file, self.from.unwrap_or(0), self.play);
        }
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
        let options = DecideOptions {
            file: self.file,
            application: self.application,
            trust: if self.trust {
                Trust::Trusted
            } else {
                Trust::Untrusted
            },
            sets: self.set,
            span,
            tolerance: self.tolerance,
            json: self.json,
        };
        decide::run(options, |loaded| Ok(start_log(filter, loaded)?))
    }
}
