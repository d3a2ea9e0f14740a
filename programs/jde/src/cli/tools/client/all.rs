//! Stops everything in one application or in all of them at once, and releases it again (R14). It requires no
//! confirmation.

use std::io::{self, Write};

use jde_link::message::Action;
use jde_terminal::{self as terminal, BAD, FAINT, GOOD};

use super::{Context, Target};
use crate::failure::{Failure, display_path};
use crate::remote::request;

/// Stops everything.
pub(super) fn stop(context: &Context, target: &Target) -> Result<(), Failure> {
    send_to_all(
        context,
        target,
        Action::StopAll,
        "stopped, every command is neutral",
        "`jde release --all` lets it continue",
    )
}

/// Releases everything that was stopped at once.
pub(super) fn release(context: &Context, target: &Target) -> Result<(), Failure> {
    send_to_all(
        context,
        target,
        Action::ReleaseAll,
        "released from the stop of everything",
        "`jde ps` shows what operators still stop or force",
    )
}

/// Lets the time of applications that stand still pass again, or only a little.
pub(super) fn pass_time(context: &Context, target: &Target, one_step: bool) -> Result<(), Failure> {
    let (action, effect) = match one_step {
        true => (Action::Step, "made a step"),
        false => (Action::Continue, "go on"),
    };
    send_to_all(context, target, action, effect, "`jde top` shows the time")
}

/// Sends the action to all applications at the same time and prints each reply as it arrives. One that does
/// not reply does not delay the others.
fn send_to_all(
    context: &Context,
    target: &Target,
    action: Action,
    effect: &str,
    hint: &str,
) -> Result<(), Failure> {
    let (is_stop, is_release) = (
        matches!(action, Action::StopAll),
        matches!(action, Action::ReleaseAll),
    );
    let request = request(action);
    let mut out = terminal::out();
    let mut failed = Vec::new();
    let mut printed: io::Result<()> = Ok(());
    let (reach, name) = (context.reach(target)?, context.application_name(target));
    jde_link::broadcast(&reach, name.as_deref(), &request, &mut |reply| {
        let application = display_path(reply.target.as_ref());
        let result = match &reply.outcome {
            Ok(roots) if roots.is_empty() && is_release => {
                writeln!(out, "{application}: nothing was stopped with everything")
            }
            Ok(roots) => {
                let roots: Vec<_> = roots.iter().map(|root| display_path(root.as_ref())).collect();
                writeln!(out, "{application}: {GOOD}{} {effect}{GOOD:#}", roots.join(", "))
            }
            Err(error) => {
                let result = writeln!(
                    out,
                    "{application}: {BAD}{}{BAD:#}",
                    display_path(error.to_string().as_ref())
                );
                failed.push(application);
                result
            }
        };
        // Wait for all replies even if the output is closed.
        let result = result.and_then(|()| out.flush());
        printed = std::mem::replace(&mut printed, Ok(())).and(result);
    })?;
    if failed.is_empty() {
        printed?;
        writeln!(out, "{FAINT}{hint}{FAINT:#}")?;
        return Ok(());
    }
    let help = match is_stop {
        true => "; if it moves something, press the robot's own emergency stop",
        false => "",
    };
    Err(Failure::broken(format!(
        "{} did not do it{help}",
        failed.join(", ")
    )))
}
