//! `jde apps`: lists the running applications.

use std::sync::mpsc::channel;
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use clap::Args;
use jde_link::message::{About, Network};
use jde_link::{Client, Error, Remote, Unanswered};
use jde_records::RecordKind;
use jde_records::event::{Outcome, What};
use jde_records::snapshot::{SchemaView, Snapshot};
use jde_session::cli::print_json;
use jde_terminal::{self as terminal, BAD, FAINT, GOOD, TITLE, WARN};
use jde_timeline::{Ending, Severity, acting};
use serde::Serialize;

use super::{Context, Target};
use crate::failure::{Failure, display_path};
use crate::remote::table::{Alignment, Cell, Table};

/// Events among which the end of an application is searched.
const MAX_EVENTS: usize = 20;

/// List the running applications.
#[derive(Args)]
#[command(after_help = "Examples:
  jde apps
  jde apps --at tcp/robot2:7447 --json")]
pub(crate) struct Apps {
    #[command(flatten)]
    target: Target,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

/// The running applications, and what gave no answer.
pub(crate) struct Listing {
    /// In the order of their start.
    pub(crate) entries: Vec<ApplicationEntry>,
    /// The endpoints and applications without an answer.
    unanswered: Vec<Unanswered>,
}

/// A running application.
#[derive(Serialize)]
pub(crate) struct ApplicationEntry {
    #[serde(flatten)]
    pub(crate) about: About,
    /// The winners, from the roots down; `None` if the application gives no answer that makes sense.
    acting: Option<Vec<String>>,
    /// The operator who stopped everything, until it is released.
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped_by: Option<String>,
    /// How it ended, if it stays only to be looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    outcome: Option<Outcome>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
}

impl Apps {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let listing = Listing::request(&context.client(&self.target)?)?;
        let Listing { entries, unanswered } = &listing;
        if self.json {
            print_json(entries)?;
        } else if entries.is_empty() && unanswered.is_empty() {
            let mut out = terminal::out();
            writeln!(out, "no application runs; start one with `jde run` or `jde demo`")?;
        } else {
            let mut out = terminal::out();
            table(entries, unanswered).write(&mut out)?;
            out.flush()?;
        }
        let problems = listing.problems();
        if problems.is_empty() {
            return Ok(());
        }
        Err(Failure::broken(problems.join("; ")))
    }
}

impl Listing {
    /// Asks all applications that the client finds.
    ///
    /// # Errors
    /// They cannot be looked for. One that gives no answer is no error.
    pub(crate) fn request(client: &Client) -> Result<Self, Failure> {
        let abouts = client.applications()?;
        let unanswered = client.unanswered();
        // Query in parallel: a suspended application must not delay the others.
        let mut entries: Vec<ApplicationEntry> = thread::scope(|scope| {
            let threads: Vec<_> = abouts
                .into_iter()
                .map(|about| {
                    scope.spawn(move || {
                        let name = format!("{}@{}", about.name, about.id);
                        let found = client.application(Some(&name));
                        let mut entry = ApplicationEntry {
                            about,
                            acting: None,
                            stopped_by: None,
                            outcome: None,
                            problem: None,
                        };
                        match found.and_then(|remote| present(&remote)) {
                            Ok((snapshot, outcome)) => {
                                entry.acting = Some(acting(&snapshot));
                                entry.stopped_by = stopped_by(&snapshot);
                                entry.outcome = outcome;
                            }
                            Err(error) => entry.problem = Some(error.to_string()),
                        }
                        entry
                    })
                })
                .collect();
            let joined = threads.into_iter().map(|thread| {
                thread
                    .join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            });
            joined.collect()
        });
        // One that has ended meanwhile is neither running nor silent.
        let running = client.applications()?;
        let is_running = |entry: &ApplicationEntry| running.iter().any(|about| about.id == entry.about.id);
        entries.retain(|entry| entry.problem.is_none() || is_running(entry));
        Ok(Self { entries, unanswered })
    }

    /// Returns what gave no answer, in words.
    pub(crate) fn problems(&self) -> Vec<&str> {
        let problems = self.entries.iter().filter_map(|entry| entry.problem.as_deref());
        let unanswered = self.unanswered.iter().map(|one| one.reason.as_str());
        let mut problems: Vec<_> = problems.chain(unanswered).collect();
        problems.dedup();
        problems
    }
}

fn table(listed: &[ApplicationEntry], unanswered: &[Unanswered]) -> Table {
    let mut table = Table::new([
        ("name", Alignment::Left),
        ("up", Alignment::Right),
        ("acting", Alignment::Left),
        ("where", Alignment::Left),
        ("pid", Alignment::Right),
        ("network", Alignment::Left),
        ("file", Alignment::Left),
    ]);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    for ApplicationEntry {
        about,
        acting,
        stopped_by,
        outcome,
        ..
    } in listed
    {
        let same_name = listed
            .iter()
            .filter(|other| other.about.name == about.name)
            .count();
        let name = match same_name {
            1 => about.name.clone(),
            _ => format!("{}@{:.6}", about.name, about.id),
        };
        let up = now.saturating_sub(Duration::from_nanos(about.started_ns));
        let ending = outcome.clone().map(Ending::Known);
        let acting = match (acting.as_deref(), &ending) {
            (None, _) => Cell::from("no answer").styled(WARN),
            (Some(_), Some(ending)) => Cell::from(ending.word()).styled(match ending.severity() {
                Severity::Good => GOOD,
                Severity::Warning => WARN,
                Severity::Bad => BAD,
            }),
            (Some([]), None) => match stopped_by {
                Some(by) => Cell::from(format!("nobody: all stopped by {by}")).styled(WARN),
                None => Cell::from("nobody").styled(FAINT),
            },
            (Some(names), None) => Cell::from(names.join(" > ")).styled(GOOD),
        };
        table.add_row([
            Cell::from(name).styled(TITLE),
            format_span(up).into(),
            acting,
            format!("{}@{}", about.user, about.host).into(),
            about.pid.into(),
            Cell::from(match about.network {
                Network::Closed => "closed",
                Network::Read => "read",
                Network::Operate => "operate",
            })
            .styled(FAINT),
            Cell::from(display_path(about.file.as_ref())).styled(FAINT),
        ]);
    }
    for Unanswered { target, .. } in unanswered {
        table.add_row([
            Cell::from(target).styled(TITLE),
            "".into(),
            Cell::from("no answer").styled(WARN),
        ]);
    }
    table
}

/// Returns the state of an application, and how it ended.
pub(super) fn present(remote: &Remote) -> Result<(Snapshot, Option<Outcome>), Error> {
    let (sender, receiver) = channel();
    // All earlier events have arrived when this returns. The end is the last, but for what operators asked since.
    drop(remote.events(&[RecordKind::Event], MAX_EVENTS, move |event| {
        let _ = sender.send(event.record);
    })?);
    let outcome = receiver.try_iter().find_map(|record| match record.what() {
        Some(What::Ended { outcome }) => Some(outcome.clone()),
        Some(_) | None => None,
    });
    Ok((remote.hierarchy()?, outcome))
}

/// Returns the operator who stopped everything.
fn stopped_by(snapshot: &Snapshot) -> Option<String> {
    let mut holds = snapshot.schemas.iter().flat_map(SchemaView::holds);
    Some(holds.find(|hold| hold.with_everything)?.by.clone())
}

/// Formats a duration: "45s", "2m 14s", "3h 20m", "2d 4h".
pub(super) fn format_span(time: Duration) -> String {
    let seconds = time.as_secs();
    let (minutes, hours, days) = (seconds / 60, seconds / 3600, seconds / 86_400);
    match (days, hours, minutes) {
        (0, 0, 0) => format!("{seconds}s"),
        (0, 0, _) => format!("{minutes}m {}s", seconds % 60),
        (0, _, _) => format!("{hours}h {}m", minutes % 60),
        _ => format!("{days}d {}h", hours % 24),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snapshots::navigation;

    #[test]
    fn winners_are_listed_from_the_roots_down() {
        assert_eq!(acting(&navigation()), ["example", "vff"]);
    }

    #[test]
    fn times_have_two_units_at_most() {
        let texts = [45, 134, 12_000, 187_200].map(|seconds| format_span(Duration::from_secs(seconds)));
        assert_eq!(texts, ["45s", "2m 14s", "3h 20m", "2d 4h"]);
    }
}
