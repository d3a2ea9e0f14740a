//! Names for the shell to complete: of applications that run, and of what is in them. Whoever does not answer at once is left
//! out: a key pressed in a shell must not wait.

use std::ffi::OsStr;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use clap_complete::CompletionCandidate;
use jde_link::{Client, Folder, Reach, Remote};

use crate::attached::name::split_application;

/// How long a key pressed in a shell may wait.
const PATIENCE: Duration = Duration::from_millis(700);

/// Applications that run here.
pub(crate) fn applications(current: &OsStr) -> Vec<CompletionCandidate> {
    let begun = current.to_string_lossy().into_owned();
    in_time(|| {
        let client = Client::connect(&Reach::Local(Folder::of_user())).ok()?;
        client.applications().ok()
    })
    .unwrap_or_default()
    .into_iter()
    .filter(|about| about.name.starts_with(&begun))
    .map(|about| CompletionCandidate::new(about.name).help(Some(about.file.into())))
    .collect()
}

/// Schemas of the application that is meant.
pub(crate) fn schemas(current: &OsStr) -> Vec<CompletionCandidate> {
    names(current, |remote| {
        let schemas = remote.schemas().ok()?.schemas;
        Some(
            schemas
                .into_iter()
                .map(|schema| (schema.name, schema.doc))
                .collect(),
        )
    })
}

/// Variables of the application that is meant.
pub(crate) fn variables(current: &OsStr) -> Vec<CompletionCandidate> {
    names(current, |remote| {
        let variables = remote.variables(false).ok()?;
        Some(
            variables
                .into_iter()
                .map(|variable| (variable.name, variable.doc))
                .collect(),
        )
    })
}

/// Modulations of the application that is meant.
pub(crate) fn modulations(current: &OsStr) -> Vec<CompletionCandidate> {
    names(current, |remote| {
        let mut variables = remote.variables(false).ok()?;
        variables.retain(|variable| variable.access == "modulation");
        Some(
            variables
                .into_iter()
                .map(|variable| (variable.name, variable.doc))
                .collect(),
        )
    })
}

/// Names of an application with what they mean.
type Names = Vec<(String, String)>;

fn names(current: &OsStr, list: fn(&Remote) -> Option<Names>) -> Vec<CompletionCandidate> {
    let current = current.to_string_lossy().into_owned();
    let (named, begun) = split_application(&current);
    let (prefix, begun) = (
        named.map_or(String::new(), |name| format!("{name}:")),
        begun.to_owned(),
    );
    let named = named.map(str::to_owned).or_else(|| std::env::var("JDE_APP").ok());
    let known = in_time(move || {
        let client = Client::connect(&Reach::Local(Folder::of_user())).ok()?;
        list(&client.application(named.as_deref()).ok()?)
    });
    let known = known.unwrap_or_default().into_iter();
    known
        .filter(|(name, _)| name.starts_with(&begun))
        .map(|(name, doc)| {
            let doc = doc.lines().next().map(str::to_owned);
            CompletionCandidate::new(format!("{prefix}{name}")).help(doc.map(Into::into))
        })
        .collect()
}

/// What is there in time; the rest is left behind.
fn in_time<T: Send + 'static>(ask: impl FnOnce() -> Option<T> + Send + 'static) -> Option<T> {
    let (tell, told) = channel();
    thread::spawn(move || {
        // Nobody waits any more for what comes too late.
        let _ = tell.send(ask());
    });
    told.recv_timeout(PATIENCE).ok().flatten()
}
