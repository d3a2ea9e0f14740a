//! Records the panels of a run. Each recorded panel is drawn for the recording; a separate thread reads and
//! writes the drawings, so that no schema waits for it.

use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use clap::Args;
use jde_app::Application;
use jde_core::SchemaId;
use jde_host::{Handle, PanelViewGuard, StartError};
use jde_log::Selection;
use jde_recorder::{Recorder, Stamps, Topic};

use crate::failure::Failure;
use crate::quantity;

/// Panels in a recording. The verb has an argument `file`, the recording to write.
#[derive(Args, Clone, Debug)]
pub(crate) struct PanelOptions {
    /// Also record the panels of all schemas, or of the schemas that match.
    #[arg(long, value_name = "SCHEMA", num_args = 0..=1, require_equals = true, default_missing_value = "*",
          value_delimiter = ',', requires = "file")]
    pub(crate) panels: Vec<String>,
    /// The most drawings of each panel per second. A panel is drawn at most 30 times per second.
    #[arg(long, value_name = "HZ", default_value = "5", value_parser = quantity::rate, requires = "panels")]
    pub(crate) panel_rate: f64,
}

/// The schemas that the patterns match.
#[derive(Clone, Debug)]
pub(super) struct PanelSelection {
    schemas: Vec<SchemaId>,
    rate: f64,
}

/// The recording of panels, until it is dropped.
pub(super) struct PanelRecording {
    viewers: Vec<PanelViewGuard>,
    thread: Option<JoinHandle<()>>,
}

/// A panel being recorded.
struct PanelWriter {
    schema: SchemaId,
    topic: Topic,
    /// The sequence number of the drawing that was written last.
    last_sequence: u64,
}

impl PanelOptions {
    /// Selects the panels of an application that has not started.
    ///
    /// # Errors
    /// A pattern matches no panel.
    pub(super) fn select(&self, application: &Application) -> Result<PanelSelection, Failure> {
        let panels = application.panels();
        let names = panels.iter().map(|id| application.instances[*id].name.clone());
        let names: Vec<String> = names.collect();
        let selected = self.select_names(&names)?.into_iter();
        Ok(PanelSelection {
            schemas: selected.map(|selected| panels[selected]).collect(),
            rate: self.panel_rate,
        })
    }

    /// Selects among `names`, the schemas that have a panel. Returns their indices.
    ///
    /// # Errors
    /// There are no panels, or a pattern matches none.
    pub(crate) fn select_names(&self, names: &[String]) -> Result<Vec<usize>, Failure> {
        if names.is_empty() {
            return Err(Failure::usage(
                "no schema of this application has a panel",
                "omit --panels",
            ));
        }
        let selection = Selection::new(self.panels.clone(), names).map_err(|unknown| {
            Failure::unknown("panel", &unknown.pattern, names.iter().map(String::as_str))
        })?;
        let indices = names.iter().enumerate();
        Ok(indices
            .filter(|(_, name)| selection.contains(name))
            .map(|(index, _)| index)
            .collect())
    }
}

impl PanelRecording {
    /// Starts recording the panels of an application that is about to start.
    ///
    /// # Errors
    /// A panel cannot be observed, or the thread cannot be started.
    pub(super) fn start(
        handle: &Handle,
        recorder: &Recorder,
        selected: &PanelSelection,
    ) -> Result<Self, Failure> {
        // One pending notification is enough for any number of drawings.
        let (sender, receiver) = sync_channel(1);
        let mut viewers = Vec::new();
        let mut writers = Vec::new();
        for &schema in &selected.schemas {
            let sender = sender.clone();
            writers.push(PanelWriter {
                schema,
                topic: recorder.panel(&handle.application().instances[schema].name),
                last_sequence: 0,
            });
            let viewer = handle.view_panel(schema, selected.rate, move || {
                // A pending notification covers this drawing too.
                let _ = sender.try_send(());
            });
            viewers.push(viewer.map_err(|refusal| Failure::broken(refusal.to_string()))?);
        }
        drop(sender);
        let handle = handle.clone();
        let thread = std::thread::Builder::new()
            .name("recording-panels".to_owned())
            .spawn(move || write_drawings(&handle, &receiver, writers))
            .map_err(StartError::Thread)?;
        Ok(Self {
            viewers,
            thread: Some(thread),
        })
    }
}

/// Writes new drawings until the last viewer is dropped.
fn write_drawings(handle: &Handle, receiver: &Receiver<()>, mut panels: Vec<PanelWriter>) {
    for () in receiver {
        for panel in &mut panels {
            let newest = handle.panel(panel.schema);
            if let Some(drawn) = newest.filter(|drawn| drawn.sequence != panel.last_sequence) {
                panel.last_sequence = drawn.sequence;
                let stamps = Stamps {
                    published: drawn.time,
                    measured: drawn.time,
                    sequence: drawn.sequence,
                };
                panel.topic.put_panel(&drawn.list, stamps);
            }
        }
    }
}

impl Drop for PanelRecording {
    fn drop(&mut self) {
        // The last viewer drops the last sender, which ends the thread.
        self.viewers.clear();
        if let Some(thread) = self.thread.take() {
            // The panic hook has already reported a panic of the thread.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(patterns: &[&str]) -> PanelOptions {
        PanelOptions {
            panels: patterns.iter().map(|name| (*name).to_owned()).collect(),
            panel_rate: 5.0,
        }
    }

    #[test]
    fn panels_are_selected_among_the_existing_ones() {
        let names = ["example", "goon"].map(str::to_owned);
        let selected = |patterns: &[&str]| {
            let selected = options(patterns).select_names(&names);
            selected.map_err(|failure| match failure {
                Failure::Run(crate::failure::RunFailure::Usage { message, help }) => {
                    format!("{message}; {help}")
                }
                other => other.to_string(),
            })
        };
        assert_eq!(selected(&["*"]), Ok(vec![0, 1]));
        assert_eq!(selected(&["go*"]), Ok(vec![1]));
        assert_eq!(
            selected(&["gon"]),
            Err("there is no panel `gon`; did you mean `goon`?".to_owned())
        );
        let none = options(&["*"]).select_names(&[]).unwrap_err().to_string();
        assert_eq!(none, "no schema of this application has a panel");
    }
}
