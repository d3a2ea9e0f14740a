//! `jde continue` and `jde step`: the time of an application that stands still at a breakpoint.

use clap::Args;

use super::{Context, Target, all};
use crate::failure::Failure;

/// Let time go on after a breakpoint of `jde run --break`.
#[derive(Args)]
pub(crate) struct Continue {
    #[command(flatten)]
    target: Target,
}

/// Make a step at a breakpoint: 10 ms, or to the next instant in lockstep.
#[derive(Args)]
pub(crate) struct SingleStep {
    #[command(flatten)]
    target: Target,
}

impl Continue {
    /// Runs the verb.
    pub(super) fn run(self, context: &Context) -> Result<(), Failure> {
        all::pass_time(context, &self.target, false)
    }
}

impl SingleStep {
    /// Runs the verb.
    pub(super) fn run(self, context: &Context) -> Result<(), Failure> {
        all::pass_time(context, &self.target, true)
    }
}
