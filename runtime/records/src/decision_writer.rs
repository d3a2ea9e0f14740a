//! Why-records as lines of JSON, one for each selection (R15), in the order of each group: for files, pipes
//! and scripts.

use std::io::Write;

use jde_app::Application;

use crate::event::{Event, Observer};
use crate::{RecordBuilder, RunRecord};

/// Writes one line, a [`Decision`](crate::Decision), for each selection, once the time to the winner's first iteration is
/// known.
pub struct DecisionWriter<W: Write + Send> {
    records: RecordBuilder,
    out: W,
    failed: Option<std::io::Error>,
}

impl<W: Write + Send> DecisionWriter<W> {
    /// Writes to `out`. A buffered writer is recommended, since it writes line by line.
    pub fn new(application: &Application, out: W) -> Self {
        Self {
            records: RecordBuilder::new(application),
            out,
            failed: None,
        }
    }

    /// Writes the pending lines, and returns the writer.
    ///
    /// # Errors
    /// The first error of writing. The affected lines are lost; the application was not affected.
    pub fn finish(mut self) -> std::io::Result<W> {
        for record in self.records.finish() {
            self.write(&record);
        }
        match self.failed {
            Some(error) => Err(error),
            None => {
                self.out.flush()?;
                Ok(self.out)
            }
        }
    }

    /// Processes one event. Returns its messages, after those that are selections were written.
    pub fn process(&mut self, event: &Event) -> Vec<RunRecord> {
        let records = self.records.process(event);
        for record in &records {
            self.write(record);
        }
        records
    }

    fn write(&mut self, record: &RunRecord) {
        let RunRecord::Decision(decision) = record else {
            return;
        };
        let result = serde_json::to_writer(&mut self.out, decision).map_err(std::io::Error::from);
        if let Err(error) = result.and_then(|()| self.out.write_all(b"\n")) {
            self.failed.get_or_insert(error);
        }
    }
}

impl<W: Write + Send> Observer for DecisionWriter<W> {
    fn on_event(&mut self, event: &Event) {
        self.process(event);
    }
}
