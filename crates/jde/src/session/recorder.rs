//! Hears and watches a run, and keeps what its summary and its picture need.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use jde_core::Nanos;
use jde_host::Handle;
use jde_host::app::Application;
use jde_host::decisions::Decisions;
use jde_host::event::{Event, Observer};

use super::digest::Digested;
use super::progress::Progress;
use super::sight::{Seen, Sight};
use super::tally::Tally;
use super::trace::Trace;
use crate::queue::{Queue, Taken};
use crate::terminal::Words;

/// Time between two samples of the path: at 0.4 m/s a robot moves 4 cm.
pub(crate) const SAMPLE: Nanos = 100_000_000;

/// Events that may wait to be kept: a minute of an application that changes its mind a hundred times a second.
const WAITING: usize = 8192;

/// Keeps a run.
pub(crate) struct Recorder {
    tally: Tally,
    trace: Option<Trace>,
    seen: Seen,
    progress: Progress,
    decisions: Decisions<Digested>,
    heard: Arc<Queue<Event>>,
    /// Events that came faster than they could be kept.
    missed: u64,
    sight: Option<Sight>,
    ended: Option<Nanos>,
}

/// What is left of a recorder.
pub(crate) struct Kept {
    /// What has been counted.
    pub(crate) tally: Tally,
    /// The drive, if a picture is wanted.
    pub(crate) trace: Option<Trace>,
    /// What was seen last.
    pub(crate) seen: Seen,
    /// When the run ended, ns since its start.
    pub(crate) ended: Nanos,
    /// Where it was told.
    pub(crate) words: Words,
    /// Events that came faster than they could be kept: as many are missing in all that was counted.
    pub(crate) missed: u64,
    /// Decisions that whoever reads them did not take in time.
    pub(crate) unread: u64,
}

/// Hears under the application's lock, so it only passes on.
struct Hearing(Arc<Queue<Event>>);

impl Observer for Hearing {
    fn hear(&mut self, event: &Event) {
        self.0.add(event.clone());
    }
}

impl Drop for Hearing {
    fn drop(&mut self) {
        self.0.close();
    }
}

impl Recorder {
    /// Keeps what the observer hears that it answers with. In lockstep that is heard and kept by one thread, and nothing is missed.
    pub(crate) fn new(
        application: &Application,
        decisions: Digested,
        trace: Option<Trace>,
        progress: Progress,
        lockstep: bool,
    ) -> (Self, Box<dyn Observer>) {
        let heard = Queue::new(if lockstep { usize::MAX } else { WAITING });
        let hearing = Hearing(Arc::clone(&heard));
        let recorder = Self {
            tally: Tally::new(application),
            trace,
            seen: Seen::default(),
            progress,
            decisions: Decisions::new(application, decisions),
            heard,
            missed: 0,
            sight: None,
            ended: None,
        };
        (recorder, Box::new(hearing))
    }

    /// Watches the variables of a running application from now on.
    pub(crate) fn watch(&mut self, handle: &Handle) {
        self.sight = Some(Sight::new(handle));
    }

    /// Hears all that has happened, and looks around once.
    ///
    /// # Errors
    /// What is told cannot be written.
    pub(crate) fn catch_up(&mut self, now: Nanos) -> io::Result<()> {
        while let Taken::Next { what, missed } = self.heard.take_now() {
            self.missed += missed;
            self.hear(&what)?;
        }
        self.look(now)
    }

    /// Keeps a run in real time until it has ended; stops it if that fails.
    ///
    /// # Errors
    /// What is told cannot be written.
    pub(crate) fn keep(&mut self, handle: &Handle, wait: Duration) -> io::Result<()> {
        let mut next = 0;
        let mut result = Ok(());
        while self.ended.is_none() {
            let told = match self.heard.take_within(wait) {
                Taken::Next { what, missed } => {
                    self.missed += missed;
                    self.hear(&what)
                }
                Taken::Nothing => Ok(()),
                Taken::Closed => break,
            };
            let now = handle.now();
            let looked = if now >= next || self.ended.is_some() {
                next = now - now % SAMPLE + SAMPLE;
                self.look(now)
            } else {
                Ok(())
            };
            if let (Ok(()), Err(error)) = (&result, told.and(looked)) {
                result = Err(error);
                handle.stop();
            }
        }
        result
    }

    /// What was kept, and the digest of the decisions or why they could not be written.
    pub(crate) fn finish(self) -> (Kept, io::Result<String>) {
        let decisions = self.decisions.finish();
        let kept = Kept {
            tally: self.tally,
            trace: self.trace,
            seen: self.seen,
            ended: self.ended.unwrap_or_default(),
            words: self.progress.into_words(),
            missed: self.missed,
            unread: decisions.as_ref().map_or(0, Digested::lost),
        };
        (kept, decisions.map(Digested::hex))
    }

    fn hear(&mut self, event: &Event) -> io::Result<()> {
        if let Event::Ended { time, .. } = event {
            self.ended = Some(*time);
        }
        self.decisions.hear(event);
        if let Some(takeover) = self.tally.hear(event) {
            if let Some(trace) = &mut self.trace {
                trace.took_over(&takeover, self.sight.as_ref());
            }
            self.progress.takeover(&takeover)?;
        }
        self.progress.event(event)
    }

    fn look(&mut self, now: Nanos) -> io::Result<()> {
        let Some(sight) = &mut self.sight else {
            return Ok(());
        };
        self.seen = sight.look();
        if let Some(trace) = &mut self.trace {
            trace.add(now, sight, &self.seen, &self.tally.acting());
        }
        self.progress.seen(now, &self.seen, &self.tally)
    }
}
