//! Hears and watches a run, and keeps what its summary and its picture need.

use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use jde_core::Nanos;
use jde_host::Handle;
use jde_host::app::Application;
use jde_host::decisions::Decisions;
use jde_host::event::Event;

use super::digest::Digested;
use super::progress::Progress;
use super::sight::{Seen, Sight};
use super::tally::Tally;
use super::trace::Trace;
use crate::terminal::Words;

/// Time between two samples of the path: at 0.4 m/s a robot moves 4 cm.
pub(crate) const SAMPLE: Nanos = 100_000_000;

/// Keeps a run.
pub(crate) struct Recorder {
    tally: Tally,
    trace: Option<Trace>,
    seen: Seen,
    progress: Progress,
    decisions: Decisions<Digested>,
    heard: Receiver<Event>,
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
}

impl Recorder {
    /// Hears what is sent on the channel it answers with.
    pub(crate) fn new(
        application: &Application,
        decisions: Digested,
        trace: Option<Trace>,
        progress: Progress,
    ) -> (Self, Sender<Event>) {
        let (tell, heard) = channel();
        let recorder = Self {
            tally: Tally::new(application),
            trace,
            seen: Seen::default(),
            progress,
            decisions: Decisions::new(application, decisions),
            heard,
            sight: None,
            ended: None,
        };
        (recorder, tell)
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
        while let Ok(event) = self.heard.try_recv() {
            self.hear(&event)?;
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
            let told = match self.heard.recv_timeout(wait) {
                Ok(event) => self.hear(&event),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break,
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
        let kept = Kept {
            tally: self.tally,
            trace: self.trace,
            seen: self.seen,
            ended: self.ended.unwrap_or_default(),
            words: self.progress.into_words(),
        };
        (kept, self.decisions.finish().map(Digested::hex))
    }

    fn hear(&mut self, event: &Event) -> io::Result<()> {
        if let Event::Ended { time, .. } = event {
            self.ended = Some(*time);
        }
        self.decisions.hear(event);
        if let Some(takeover) = self.tally.hear(event) {
            if let Some(trace) = &mut self.trace {
                trace.took_over(&takeover);
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
            trace.add(now, sight, &self.seen, self.tally.acting());
        }
        self.progress.seen(now, &self.seen, &self.tally)
    }
}
