//! Observes a run, and keeps what its summary and its picture need.

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

/// Time between two samples of the path, ns: at 0.4 m/s a robot moves 4 cm.
pub(crate) const SAMPLE: Nanos = 100_000_000;

/// Most events in the queue: a minute of an application with a hundred selections per second.
const WAITING: usize = 8192;

/// Collects the data of a run.
pub(crate) struct Recorder {
    tally: Tally,
    trace: Option<Trace>,
    seen: Seen,
    progress: Progress,
    decisions: Decisions<Digested>,
    heard: Arc<Queue<Event>>,
    /// Events that were dropped because they occurred faster than they were processed.
    missed: u64,
    sight: Option<Sight>,
    ended: Option<Nanos>,
}

/// The data of a finished run.
pub(crate) struct Kept {
    /// The sums.
    pub(crate) tally: Tally,
    /// The drive, if a picture is wanted.
    pub(crate) trace: Option<Trace>,
    /// The last sample of the variables.
    pub(crate) seen: Seen,
    /// The time at which the run ended, ns since its start.
    pub(crate) ended: Nanos,
    /// The stream for text output.
    pub(crate) words: Words,
    /// Events that were dropped because they occurred faster than they were processed. All sums lack them.
    pub(crate) missed: u64,
    /// Decisions that the reader of their file did not read in time.
    pub(crate) unread: u64,
}

/// The observer. It is called under the application's lock, so it only appends to the queue.
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
    /// Creates a recorder, and the observer that feeds its queue. In lockstep one thread fills and empties the
    /// queue, which has no bound there, so no event is dropped.
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

    /// Samples the variables of a running application from now on.
    pub(crate) fn watch(&mut self, handle: &Handle) {
        self.sight = Some(Sight::new(handle));
    }

    /// Processes all pending events, and samples the variables once.
    ///
    /// # Errors
    /// Output cannot be written.
    pub(crate) fn catch_up(&mut self, now: Nanos) -> io::Result<()> {
        while let Taken::Next { what, missed } = self.heard.take_now() {
            self.missed += missed;
            self.hear(&what)?;
        }
        self.look(now)
    }

    /// Processes the events of a run in real time until it has ended. If output fails, it stops the
    /// application, continues to the end and returns the first error.
    ///
    /// # Errors
    /// Output cannot be written.
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

    /// Returns the data, and the digest of the decisions or the error that kept them from being written.
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
