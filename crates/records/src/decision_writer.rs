//! Why-records as lines of JSON, one for each selection (R15), in the order of each group: for files, pipes
//! and scripts.

use std::io::Write;

use jde_app::Application;

use crate::event::{Event, Observer};
use crate::{Decision, DecisionTracker};

/// Writes one line, a [`Decision`], for each selection, once the time to the winner's first iteration is
/// known.
pub struct DecisionWriter<W: Write + Send> {
    tracker: DecisionTracker,
    out: W,
    failed: Option<std::io::Error>,
}

impl<W: Write + Send> DecisionWriter<W> {
    /// Writes to `out`. A buffered writer is recommended, since it writes line by line.
    pub fn new(application: &Application, out: W) -> Self {
        Self {
            tracker: DecisionTracker::new(application),
            out,
            failed: None,
        }
    }

    /// Writes the pending lines, and returns the writer.
    ///
    /// # Errors
    /// The first error of writing. The affected lines are lost; the application was not affected.
    pub fn finish(mut self) -> std::io::Result<W> {
        for decision in self.tracker.drain() {
            self.write(&decision);
        }
        match self.failed {
            Some(error) => Err(error),
            None => {
                self.out.flush()?;
                Ok(self.out)
            }
        }
    }

    /// Processes one event.
    pub fn on_event(&mut self, event: &Event) {
        for decision in self.tracker.process(event) {
            self.write(&decision);
        }
    }

    fn write(&mut self, decision: &Decision) {
        let result = serde_json::to_writer(&mut self.out, decision).map_err(std::io::Error::from);
        if let Err(error) = result.and_then(|()| self.out.write_all(b"\n")) {
            self.failed.get_or_insert(error);
        }
    }
}

impl<W: Write + Send> Observer for DecisionWriter<W> {
    fn on_event(&mut self, event: &Event) {
        DecisionWriter::on_event(self, event);
    }
}
