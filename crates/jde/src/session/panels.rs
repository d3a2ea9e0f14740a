//! Records the panels of a run. Each recorded panel is drawn for the recording; a separate thread reads and
//! writes the drawings, so that no schema waits for it.

use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use jde_host::app::Application;
use jde_host::{Handle, Look, StartError};
use jde_log::{Recorder, Selection, Stamps, Topic};

use crate::failure::Failure;

/// Which panels are recorded, and how often.
#[derive(Clone, Debug)]
pub(crate) struct Panels {
    /// Patterns of the names of the schemas with these panels.
    pub(crate) only: Vec<String>,
    /// Most drawings of each panel per second.
    pub(crate) rate: f64,
}

/// The schemas that the patterns match.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    schemas: Vec<usize>,
    rate: f64,
}

/// The recording of panels, until it is dropped.
pub(super) struct Taking {
    looks: Vec<Look>,
    thread: Option<JoinHandle<()>>,
}

/// A panel being recorded.
struct Taken {
    schema: usize,
    topic: Topic,
    /// The sequence number of the drawing that was written last.
    last: u64,
}

impl Panels {
    /// Selects the panels of an application that has not started.
    ///
    /// # Errors
    /// A pattern matches no panel.
    pub(super) fn of(&self, application: &Application) -> Result<Chosen, Failure> {
        let places = application.panels();
        let names = places
            .iter()
            .map(|place| application.instances[*place].name.clone());
        let names: Vec<String> = names.collect();
        let chosen = self.chosen(&names)?.into_iter();
        Ok(Chosen {
            schemas: chosen.map(|chosen| places[chosen]).collect(),
            rate: self.rate,
        })
    }

    /// Selects among `names`, the schemas that have a panel. Returns their indices.
    ///
    /// # Errors
    /// There are no panels, or a pattern matches none.
    pub(crate) fn chosen(&self, names: &[String]) -> Result<Vec<usize>, Failure> {
        if names.is_empty() {
            return Err(Failure::usage(
                "no schema of this application has a panel",
                "leave --panels out",
            ));
        }
        let selection = Selection::new(self.only.clone(), names).map_err(|unknown| {
            Failure::unknown("panel", &unknown.pattern, names.iter().map(String::as_str))
        })?;
        let places = names.iter().enumerate();
        Ok(places
            .filter(|(_, name)| selection.has(name))
            .map(|(place, _)| place)
            .collect())
    }
}

impl Taking {
    /// Starts recording the panels of an application that is about to start.
    ///
    /// # Errors
    /// A panel cannot be observed, or the thread cannot be started.
    pub(super) fn begin(handle: &Handle, recorder: &Recorder, chosen: &Chosen) -> Result<Self, Failure> {
        // One pending notification is enough for any number of drawings.
        let (ring, rung) = sync_channel(1);
        let mut looks = Vec::new();
        let mut taken = Vec::new();
        for &schema in &chosen.schemas {
            let ring = ring.clone();
            taken.push(Taken {
                schema,
                topic: recorder.panel(&handle.application().instances[schema].name),
                last: 0,
            });
            let look = handle.look(schema, chosen.rate, move || {
                // A pending notification covers this drawing too.
                let _ = ring.try_send(());
            });
            looks.push(look.map_err(|refusal| Failure::Broken(refusal.to_string()))?);
        }
        drop(ring);
        let handle = handle.clone();
        let thread = std::thread::Builder::new()
            .name("recording-panels".to_owned())
            .spawn(move || take(&handle, &rung, taken))
            .map_err(StartError::Thread)?;
        Ok(Self {
            looks,
            thread: Some(thread),
        })
    }
}

/// Writes new drawings until the last look is dropped.
fn take(handle: &Handle, rung: &Receiver<()>, mut panels: Vec<Taken>) {
    for () in rung {
        for panel in &mut panels {
            let newest = handle.panel(panel.schema);
            if let Some(drawn) = newest.filter(|drawn| drawn.sequence != panel.last) {
                panel.last = drawn.sequence;
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

impl Drop for Taking {
    fn drop(&mut self) {
        // The last look drops the last sender, which ends the thread.
        self.looks.clear();
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
            let chosen = Panels { only, rate: 5.0 }.chosen(&names);
            chosen.map_err(|failure| match failure {
                Failure::Use { message, help } => format!("{message}; {help}"),
                other => other.to_string(),
            })
        };
        assert_eq!(chosen(&["*"]), Ok(vec![0, 1]));
        assert_eq!(chosen(&["go*"]), Ok(vec![1]));
        assert_eq!(
            chosen(&["gon"]),
            Err("there is no panel `gon`; did you mean `goon`?".to_owned())
        );
        let all = Panels {
            only: vec!["*".to_owned()],
            rate: 5.0,
        };
        let none = all.chosen(&[]).unwrap_err().to_string();
        assert_eq!(none, "no schema of this application has a panel");
    }
}
