//! Records the panels of a run. Each recorded panel is drawn for the recording; a separate thread reads and
//! writes the drawings, so that no schema waits for it.

use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use jde_app::Application;
use jde_host::{Handle, PanelViewGuard, StartError};
use jde_log::{Recorder, Selection, Stamps, Topic};

use crate::failure::Failure;

/// Which panels are recorded, and how often.
#[derive(Clone, Debug)]
pub(crate) struct PanelOptions {
    /// Patterns of the names of the schemas with these panels.
    pub(crate) patterns: Vec<String>,
    /// Most drawings of each panel per second.
    pub(crate) rate: f64,
}

/// The schemas that the patterns match.
#[derive(Clone, Debug)]
pub(super) struct PanelSelection {
    schemas: Vec<usize>,
    rate: f64,
}

/// The recording of panels, until it is dropped.
pub(super) struct PanelRecording {
    viewers: Vec<PanelViewGuard>,
    thread: Option<JoinHandle<()>>,
}

/// A panel being recorded.
struct PanelWriter {
    schema: usize,
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
        let places = application.panels();
        let names = places
            .iter()
            .map(|place| application.instances[*place].name.clone());
        let names: Vec<String> = names.collect();
        let chosen = self.select_names(&names)?.into_iter();
        Ok(PanelSelection {
            schemas: chosen.map(|chosen| places[chosen]).collect(),
            rate: self.rate,
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
                "leave --panels out",
            ));
        }
        let selection = Selection::new(self.patterns.clone(), names).map_err(|unknown| {
            Failure::unknown("panel", &unknown.pattern, names.iter().map(String::as_str))
        })?;
        let places = names.iter().enumerate();
        Ok(places
            .filter(|(_, name)| selection.contains(name))
            .map(|(place, _)| place)
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
        chosen: &PanelSelection,
    ) -> Result<Self, Failure> {
        // One pending notification is enough for any number of drawings.
        let (ring, rung) = sync_channel(1);
        let mut looks = Vec::new();
        let mut taken = Vec::new();
        for &schema in &chosen.schemas {
            let ring = ring.clone();
            taken.push(PanelWriter {
                schema,
                topic: recorder.panel(&handle.application().instances[schema].name),
                last_sequence: 0,
            });
            let look = handle.view_panel(schema, chosen.rate, move || {
                // A pending notification covers this drawing too.
                let _ = ring.try_send(());
            });
            looks.push(look.map_err(|refusal| Failure::Broken(refusal.to_string()))?);
        }
        drop(ring);
        let handle = handle.clone();
        let thread = std::thread::Builder::new()
            .name("recording-panels".to_owned())
            .spawn(move || write_drawings(&handle, &rung, taken))
            .map_err(StartError::Thread)?;
        Ok(Self {
            viewers: looks,
            thread: Some(thread),
        })
    }
}

/// Writes new drawings until the last look is dropped.
fn write_drawings(handle: &Handle, rung: &Receiver<()>, mut panels: Vec<PanelWriter>) {
    for () in rung {
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
        // The last look drops the last sender, which ends the thread.
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

    #[test]
    fn panels_are_chosen_among_those_there_are() {
        let names = ["example", "goon"].map(str::to_owned);
        let chosen = |only: &[&str]| {
            let only = only.iter().map(|name| (*name).to_owned()).collect();
            let chosen = PanelOptions {
                patterns: only,
                rate: 5.0,
            }
            .select_names(&names);
            chosen.map_err(|failure| match failure {
                Failure::Usage { message, help } => format!("{message}; {help}"),
                other => other.to_string(),
            })
        };
        assert_eq!(chosen(&["*"]), Ok(vec![0, 1]));
        assert_eq!(chosen(&["go*"]), Ok(vec![1]));
        assert_eq!(
            chosen(&["gon"]),
            Err("there is no panel `gon`; did you mean `goon`?".to_owned())
        );
        let all = PanelOptions {
            patterns: vec!["*".to_owned()],
            rate: 5.0,
        };
        let none = all.select_names(&[]).unwrap_err().to_string();
        assert_eq!(none, "no schema of this application has a panel");
    }
}
