//! Stops everything in one application or in all of them at once, and releases it again (R14). Asks for no
//! confirmation.

use std::io::{self, Write};

use jde_link::message::{Action, Request};

use super::{Context, Target};
use crate::failure::{Failure, display_path};
use crate::terminal::{self, BAD, FAINT, GOOD};

/// Stops everything.
pub(super) fn stop(context: &Context, target: &Target) -> Result<(), Failure> {
    send_to_all(
        context,
        target,
        Action::StopAll,
        "stopped, every command is neutral",
        "`jde release --all` lets it go on",
    )
}

/// Releases everything that was stopped at once.
pub(super) fn release(context: &Context, target: &Target) -> Result<(), Failure> {
    send_to_all(
        context,
        target,
        Action::ReleaseAll,
        "released",
        "the hierarchy decides again",
    )
}

/// Sends the action to all applications at the same time and prints each answer as it arrives. One that does
/// not answer does not delay the others.
fn send_to_all(
    context: &Context,
    target: &Target,
    action: Action,
    done: &str,
    then: &str,
) -> Result<(), Failure> {
    let request = Request {
        by: jde_link::operator(),
        action,
        lease_ms: None,
    };
    let mut out = terminal::out();
    let mut failed = Vec::new();
    let mut told: io::Result<()> = Ok(());
    let (reach, named) = (context.reach(target)?, context.application_name(target));
    jde_link::broadcast(&reach, named.as_deref(), &request, &mut |heard| {
        let who = display_path(heard.target.as_ref());
        let said = match &heard.outcome {
            Ok(roots) => {
                let roots: Vec<_> = roots.iter().map(|root| display_path(root.as_ref())).collect();
                writeln!(out, "{who}: {GOOD}{} {done}{GOOD:#}", roots.join(", "))
            }
            Err(error) => {
                let said = writeln!(
                    out,
                    "{who}: {BAD}{}{BAD:#}",
                    display_path(error.to_string().as_ref())
                );
                failed.push(who);
                said
            }
        };
        // Wait for all answers even if the output is closed.
        let said = said.and_then(|()| out.flush());
        told = std::mem::replace(&mut told, Ok(())).and(said);
    })?;
    if failed.is_empty() {
        told?;
        writeln!(out, "{FAINT}{then}{FAINT:#}")?;
        return Ok(());
    }
    Err(Failure::Broken(format!(
        "{} did not do it; if it moves something, press the robot's own emergency stop",
        failed.join(", ")
    )))
}
