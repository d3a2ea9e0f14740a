//! `jde top`: the oscilloscope for an application of another process.

use std::sync::atomic::Ordering;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_session::top::{self, ExitReason, ObservedApplication as _};
use jde_terminal as terminal;
use jde_terminal::interrupt::SignalListener;

use super::{Context, Target};
use crate::complete;
use crate::failure::Failure;
use crate::remote::application::RemoteApplication;

/// Watch a running application in the oscilloscope; `q` quits without ending it, `?` shows the keys.
#[derive(Args)]
#[command(after_help = "Examples:
  jde top
  jde top robot2 --at tls/robot2:7447 --key lab.toml
  ssh -t robot2 jde top")]
pub(crate) struct Top {
    /// The application, if several run.
    #[arg(value_name = "APP", add = ArgValueCompleter::new(complete::applications))]
    application: Option<String>,
    #[command(flatten)]
    target: Target,
}

impl Top {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        if !terminal::is_interactive() {
            return Err(Failure::usage(
                "the oscilloscope needs a terminal",
                "`jde ps` prints the hierarchy and `jde events` the events, also to a pipe; over ssh give -t",
            ));
        }
        let remote = context.remote_by_name(&self.target, self.application.as_deref())?;
        let title = remote.about().name.clone();
        let live = RemoteApplication::new(remote, context.log.clone())?;
        let (interrupted, _interrupts) = SignalListener::flag(live.stop_callback())?;
        let keep_lines = |keep| {
            if let Some(log) = &context.log {
                log.set_buffered(keep);
            }
        };
        // Lines of the log would be written over the picture.
        keep_lines(true);
        let exit_reason = top::run(&live, &title);
        keep_lines(false);
        let exit_reason = exit_reason?;
        if exit_reason == ExitReason::Ended
            && !interrupted.load(Ordering::Relaxed)
            && let Some(ending) = live.ending()
        {
            writeln!(terminal::out(), "{title}: {}: {}", ending.word(), ending.reason())?;
        }
        Ok(())
    }
}
