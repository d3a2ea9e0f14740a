//! Observes a run, and keeps what its summary and its picture need.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use jde_app::Application;
use jde_core::{Id, Nanos};
use jde_host::Handle;
use jde_records::decision_writer::DecisionWriter;
use jde_records::event::{Event, Observer, Occurrence, What};
use jde_terminal::TextWriter;
use jde_terminal::queue::{Popped, Queue};
use jde_timeline::{DriveTimeline, Hierarchy, Keep, Timeline};

use super::digest::DigestWriter;
use super::progress::ProgressPrinter;
use super::sampler::Sampler;

/// Time between two samples of the path, ns: at 0.4 m/s a robot moves 4 cm.
pub(crate) const SAMPLE_INTERVAL: Nanos = 100_000_000;

/// Most events in the queue: a minute of an application with a hundred selections per second.
const MAX_QUEUED: usize = 8192;

/// Collects the data of a run.
pub(crate) struct Collector {
    timeline: Timeline,
    progress: ProgressPrinter,
    decisions: DecisionWriter<DigestWriter>,
    events: Arc<Queue<Event>>,
    /// Events that were dropped because they occurred faster than they were processed.
    missed: u64,
    has_scans: bool,
    sampler: Option<Sampler>,
    /// The schemas that took over since the last sample, which shows where.
    took_over: Vec<usize>,
    end_time: Option<Nanos>,
}

/// The data of a finished run.
pub struct RunData {
    /// What happened in it: the sums, and the state at the end.
    pub timeline: Timeline,
    /// The drive; without robots if the application did not start.
    pub drive: DriveTimeline,
    /// The time at which the run ended, ns since its start.
    pub end_time: Nanos,
    /// The stream for text output.
    pub output: TextWriter,
    /// Events that were dropped because they occurred faster than they were processed. All sums lack them.
    pub missed: u64,
    /// Decisions that the reader of their file did not read in time.
    pub unread: u64,
}

/// The observer. It is called under the application's lock, so it only appends to the queue.
struct QueueObserver(Arc<Queue<Event>>);

impl Observer for QueueObserver {
    fn on_event(&mut self, event: &Event) {
        self.0.push(event.clone());
    }
}

impl Drop for QueueObserver {
    fn drop(&mut self) {
        self.0.close();
    }
}

impl Collector {
    /// Creates a collector, and the observer that feeds its queue. In lockstep one thread fills and empties
    /// the queue, which has no bound there, so no event is dropped.
    pub(crate) fn new(
        application: &Application,
        decisions: DigestWriter,
        has_scans: bool,
        progress: ProgressPrinter,
        lockstep: bool,
    ) -> (Self, Box<dyn Observer>) {
        let queue = Queue::new(if lockstep { usize::MAX } else { MAX_QUEUED });
        let observer = QueueObserver(Arc::clone(&queue));
        let collector = Self {
            timeline: Timeline::new(Hierarchy::of_application(application), Keep::PRESENT),
            progress,
            decisions: DecisionWriter::new(application, decisions),
            events: queue,
            missed: 0,
            has_scans,
            sampler: None,
            took_over: Vec::new(),
            end_time: None,
        };
        (collector, Box::new(observer))
    }

    /// Samples the variables of a running application from now on.
    pub(crate) fn start_sampling(&mut self, handle: &Handle) {
        self.sampler = Some(Sampler::new(handle, self.has_scans));
    }

    /// Processes all pending events, and samples the variables once.
    ///
    /// # Errors
    /// Output cannot be written.
    pub(crate) fn process_pending(&mut self, now: Nanos) -> io::Result<()> {
        while let Popped::Next { item: event, dropped } = self.events.try_pop() {
            self.missed += dropped;
            self.handle_event(&event)?;
        }
        self.sample(now)
    }

    /// Processes the events of a run in real time until it has ended. If output fails, it stops the
    /// application, continues to the end and returns the first error.
    ///
    /// # Errors
    /// Output cannot be written.
    pub(crate) fn process_until_end(&mut self, handle: &Handle, wait: Duration) -> io::Result<()> {
        let mut next = 0;
        let mut result = Ok(());
        while self.end_time.is_none() {
            let handled = match self.events.pop_timeout(wait) {
                Popped::Next { item: event, dropped } => {
                    self.missed += dropped;
                    self.handle_event(&event)
                }
                Popped::Empty => Ok(()),
                Popped::Closed => break,
            };
            let now = handle.now();
            let sampled = if now >= next || self.end_time.is_some() {
                next = now - now % SAMPLE_INTERVAL + SAMPLE_INTERVAL;
                self.sample(now)
            } else {
                Ok(())
            };
            if let (Ok(()), Err(error)) = (&result, handled.and(sampled)) {
                result = Err(error);
                handle.stop();
            }
        }
        result
    }

    /// Returns the data and the digest of the decisions, and the error that kept them from being written.
    ///
    /// # Errors
    /// The decisions have no lines.
    pub(crate) fn finish(self) -> io::Result<(RunData, String, Option<io::Error>)> {
        let decisions = self.decisions.finish()?;
        let data = RunData {
            timeline: self.timeline,
            drive: self.sampler.map_or_else(
                || DriveTimeline::new(Vec::new(), None, 0),
                |sampler| sampler.drive,
            ),
            end_time: self.end_time.unwrap_or_default(),
            output: self.progress.into_output(),
            missed: self.missed,
            unread: decisions.lost(),
        };
        let (digest, failed) = decisions.finish();
        Ok((data, digest, failed))
    }

    fn handle_event(&mut self, event: &Event) -> io::Result<()> {
        if let Event::Other(Occurrence { time, what }) = event {
            if matches!(what, What::Ended { .. }) {
                self.end_time = Some(*time);
            }
            if let What::TookOver { schema, .. } = what {
                self.took_over.push(schema.index());
            }
        }
        self.timeline.add_event(event);
        for record in self.decisions.process(event) {
            self.progress.print_record(&record)?;
        }
        Ok(())
    }

    fn sample(&mut self, now: Nanos) -> io::Result<()> {
        let Some(sampler) = &mut self.sampler else {
            return Ok(());
        };
        sampler.sample(now, &self.timeline);
        for schema in self.took_over.drain(..) {
            sampler.drive.add_takeover(schema, self.timeline.hierarchy());
        }
        self.progress.update(now, &sampler.drive, &self.timeline)
    }
}
