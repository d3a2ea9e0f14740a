//! `jde events`: prints the events of a running application.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_link::ReceivedEvent;
use jde_records::event::What;
use jde_records::{RecordKind, RunRecord};
use jde_session::cli::print_json;
use jde_session::record_text::record_lines;
use jde_terminal::interrupt::SignalListener;
use jde_terminal::queue::{Popped, Queue};
use jde_terminal::{self as terminal, WARN};
use serde_json::json;

use super::{Context, Past, Target};
use crate::complete;
use crate::failure::Failure;
use crate::replay::Asked;

/// Number of lines of each kind that an application keeps.
const MAX_HISTORY: usize = 1000;
/// The most lines that may wait to be shown: all kept ones, and some that arrive at the same time. Beyond
/// that, the oldest are dropped, counted and reported.
const MAX_QUEUED: usize = 8192;

/// Show events: takeovers with their reasons, faults, overruns and operators' actions; first the last ones,
/// then new ones as they occur.
#[derive(Args)]
#[command(after_help = "Examples:
  jde events
  jde events --last 20 --once
  jde events --in drive.mcap --at 12.4s
  jde events --all --json | jq 'select(.stream == \"decisions\")'")]
pub(crate) struct Events {
    /// The application, if several run.
    #[arg(value_name = "APP", add = ArgValueCompleter::new(complete::applications))]
    application: Option<String>,
    #[command(flatten)]
    past: Past,
    #[command(flatten)]
    target: Target,
    /// Start with this many earlier events of each kind.
    #[arg(long, value_name = "N", default_value_t = 10)]
    last: usize,
    /// End after the earlier events.
    #[arg(long)]
    once: bool,
    /// Also show selections that changed nothing, and changes of state.
    #[arg(long)]
    all: bool,
    /// Print each event as one line of JSON.
    #[arg(long)]
    json: bool,
}

impl Events {
    pub(crate) fn run(mut self, context: &Context) -> Result<(), Failure> {
        let asked = Asked::Records {
            last: self.last.min(MAX_HISTORY),
            all: self.all,
        };
        let _moment = self.past.serve(&mut self.target, &asked)?;
        let remote = context.remote_by_name(&self.target, self.application.as_deref())?;
        let kinds: &[RecordKind] = if self.all {
            &RecordKind::ALL
        } else {
            &[RecordKind::Decision, RecordKind::Event]
        };
        let queue = Queue::new(MAX_QUEUED);
        let (interrupted, _interrupts) = SignalListener::flag({
            let queue = Arc::clone(&queue);
            move || queue.close()
        })?;
        {
            let queue = Arc::clone(&queue);
            remote.on_gone(move || queue.close());
        }
        // Most selections change nothing and are not shown, so the last takeovers may be anywhere among the
        // kept lines.
        let last = if self.all || self.last == 0 {
            self.last
        } else {
            MAX_HISTORY
        };
        let sender = Arc::clone(&queue);
        let _watching = remote.events(kinds, last, move |event| sender.push(event))?;
        let mut earlier = Vec::new();
        while let Popped::Next { item, .. } = queue.try_pop() {
            earlier.push(item);
        }
        self.show_earlier(&earlier)?;
        // Nothing happens in a recording that stands still.
        if self.once || self.past.is_asked() {
            return Ok(());
        }
        let is_end = |event: &ReceivedEvent| matches!(event.record.what(), Some(What::Ended { .. }));
        let mut unread = 0;
        while let Some((event, missed)) = queue.pop() {
            if interrupted.load(Ordering::Relaxed) {
                return Ok(());
            }
            unread += missed;
            if self.is_selected(&event.record) {
                self.show(&event, std::mem::take(&mut unread))?;
            }
            if is_end(&event) {
                return Ok(());
            }
        }
        if remote.is_alive() {
            return Ok(());
        }
        Err(jde_link::Error::Disconnected(remote.about().name.clone()).into())
    }

    /// Shows the last earlier lines of each kind.
    fn show_earlier(&self, event: &[ReceivedEvent]) -> Result<(), Failure> {
        let event = event.iter();
        let selected: Vec<_> = event.filter(|event| self.is_selected(&event.record)).collect();
        let mut skip = RecordKind::ALL.map(|kind| {
            let count = selected
                .iter()
                .filter(|event| event.record.kind() == kind)
                .count();
            count.saturating_sub(self.last)
        });
        for event in &selected {
            let skip = &mut skip[event.record.kind() as usize];
            if *skip == 0 {
                self.show(event, 0)?;
            } else {
                *skip -= 1;
            }
        }
        Ok(())
    }

    fn is_selected(&self, line: &RunRecord) -> bool {
        match line {
            RunRecord::Decision(decision) => self.all || decision.changed,
            RunRecord::State(_) | RunRecord::Other(_) => true,
        }
    }

    /// Shows a line, and how many lines of all kinds were dropped before it.
    fn show(&self, event: &ReceivedEvent, unread: u64) -> Result<(), Failure> {
        if self.json {
            let (stream, line) = match &event.record {
                RunRecord::Decision(decision) => ("decisions", json!(decision)),
                RunRecord::State(change) => ("states", json!(change)),
                RunRecord::Other(event) => ("events", json!(event)),
            };
            let (number, missed) = (event.number, event.missed + unread);
            return Ok(print_json(
                &json!({ "stream": stream, "number": number, "missed": missed, "line": line }),
            )?);
        }
        let mut out = terminal::out();
        if unread > 0 {
            writeln!(
                out,
                "{WARN}{unread} lines were missed{WARN:#}: they were not read in time"
            )?;
        }
        if event.missed > 0 && self.all {
            writeln!(out, "{WARN}{} lines were missed{WARN:#}", event.missed)?;
        }
        for line in record_lines(&event.record) {
            writeln!(out, "{line}")?;
        }
        out.flush()?;
        Ok(())
    }
}
