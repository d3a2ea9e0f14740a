//! Everything at once: stopped in one application or in all of them, and let go on again (R14).

use std::io::Write;
use std::thread;

use jde_host::snapshot::Snapshot;
use jde_link::message::{About, Action, Request};
use jde_link::{Client, Error};

use super::{Context, Target};
use crate::failure::Failure;
use crate::terminal::{self, BAD, FAINT, GOOD};

/// What was done in one application: its name, and who was meant.
type Done = (String, Result<Vec<String>, Error>);

/// Stops everything.
pub(super) fn stop(context: &Context, target: &Target) -> Result<(), Failure> {
    tell(
        each(context, target, &Action::StopAll)?,
        "stopped, every command is neutral",
        "`jde release --all` lets it go on",
    )
}

/// Lets everything go on.
pub(super) fn release(context: &Context, target: &Target) -> Result<(), Failure> {
    tell(
        each(context, target, &Action::ReleaseAll)?,
        "released",
        "the hierarchy decides again",
    )
}

/// Has all of them do it at the same time: one that does not answer must not keep the others waiting.
fn each(context: &Context, target: &Target, action: &Action) -> Result<Vec<Done>, Failure> {
    let client = context.client(target)?;
    let named = context.named(target);
    let meant = |about: &About| {
        named.as_ref().is_none_or(|named| match named.split_once('@') {
            Some((name, id)) => name == about.name && about.id.starts_with(id),
            None => *named == about.name,
        })
    };
    let all: Vec<About> = client
        .applications()?
        .into_iter()
        .filter(|about| about.executor != "replay" && meant(about))
        .collect();
    if all.is_empty() {
        // Says which there are, if another was meant.
        client.application(named.as_deref())?;
        return Err(Failure::Broken(
            "only recordings play; they move nothing".to_owned(),
        ));
    }
    Ok(thread::scope(|scope| {
        let asked: Vec<_> = all
            .into_iter()
            .map(|about| {
                let client = &client;
                scope.spawn(move || {
                    let done = one(client, &format!("{}@{}", about.name, about.id), action);
                    (about.name, done)
                })
            })
            .collect();
        let joined = asked.into_iter().map(|thread| {
            thread
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        joined.collect()
    }))
}

/// Has one do it first, and then asks whom that meant.
fn one(client: &Client, name: &str, action: &Action) -> Result<Vec<String>, Error> {
    let remote = client.application(Some(name))?;
    remote.operate(&Request {
        by: jde_link::operator(),
        action: action.clone(),
        lease_ms: None,
    })?;
    Ok(roots(&remote.hierarchy()?))
}

fn roots(snapshot: &Snapshot) -> Vec<String> {
    let tops = snapshot.groups.iter().filter(|group| group.father.is_none());
    let places = tops.flat_map(|group| &group.members);
    places
        .map(|place| snapshot.schemas[*place].name.clone())
        .collect()
}

fn tell(all: Vec<Done>, done: &str, then: &str) -> Result<(), Failure> {
    let mut out = terminal::out();
    let mut failed = Vec::new();
    for (name, roots) in all {
        match roots {
            Ok(roots) => writeln!(out, "{name}: {GOOD}{} {done}{GOOD:#}", roots.join(", "))?,
            Err(error) => {
                writeln!(out, "{name}: {BAD}{error}{BAD:#}")?;
                failed.push(name);
            }
        }
    }
    if failed.is_empty() {
        writeln!(out, "{FAINT}{then}{FAINT:#}")?;
        return Ok(());
    }
    out.flush()?;
    Err(Failure::Broken(format!(
        "{} did not do it; if it moves something, press the robot's own emergency stop",
        failed.join(", ")
    )))
}
