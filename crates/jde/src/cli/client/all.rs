//! Everything at once: stopped in one application or in all of them, and let go on again (R14). Asks nothing before it says so.

use std::io::{self, Write};

use jde_link::message::{Action, Request};

use super::{Context, Target};
use crate::failure::{Failure, shown};
use crate::terminal::{self, BAD, FAINT, GOOD};

/// Stops everything.
pub(super) fn stop(context: &Context, target: &Target) -> Result<(), Failure> {
    each(
        context,
        target,
        Action::StopAll,
        "stopped, every command is neutral",
        "`jde release --all` lets it go on",
    )
}

/// Lets everything go on.
pub(super) fn release(context: &Context, target: &Target) -> Result<(), Failure> {
    each(
        context,
        target,
        Action::ReleaseAll,
        "released",
        "the hierarchy decides again",
    )
}

/// Has all of them do it at the same time, and tells what came of it as it comes: one that does not answer keeps nobody waiting.
fn each(context: &Context, target: &Target, action: Action, done: &str, then: &str) -> Result<(), Failure> {
    let request = Request {
        by: jde_link::operator(),
        action,
        lease_ms: None,
    };
    let mut out = terminal::out();
    let mut failed = Vec::new();
    let mut told: io::Result<()> = Ok(());
    let (reach, named) = (context.reach(target)?, context.named(target));
    jde_link::everything(&reach, named.as_deref(), &request, &mut |heard| {
        let who = shown(heard.who.as_ref());
        let said = match &heard.outcome {
            Ok(roots) => {
                let roots: Vec<_> = roots.iter().map(|root| shown(root.as_ref())).collect();
                writeln!(out, "{who}: {GOOD}{} {done}{GOOD:#}", roots.join(", "))
            }
            Err(error) => {
                let said = writeln!(out, "{who}: {BAD}{}{BAD:#}", shown(error.to_string().as_ref()));
                failed.push(who);
                said
            }
        };
        // Whether anybody reads it or not, all are waited for.
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
