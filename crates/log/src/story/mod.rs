//! What a run decided and went through, as JSON messages with a schema each: names and reasons are texts of any length, which
//! the fixed-size types of variables have no room for, and whoever reads `--decisions` reads the same lines here.

use std::io::{self, Write};
use std::sync::{Arc, Mutex};

use jde_core::{Health, Nanos, Operator};
use jde_host::app::Application;
use jde_host::decisions::{Decisions, state_name};
use jde_host::event::{Event, OperatorAction, Outcome};
use serde::{Deserialize, Serialize};

use crate::lane::lock;

/// What the writing thread is told besides values.
pub(crate) enum Told {
    /// Something happened.
    Event(Event),
    /// The value of a variable was taken back.
    Retracted {
        /// When.
        time: Nanos,
        /// Which, by its full name.
        variable: String,
    },
}

/// The channels of a story: topic, name of the schema, schema.
pub(crate) const CHANNELS: [(&str, &str, &str); 3] = [
    ("/jde/decisions", "jde/Decision", include_str!("decision.json")),
    ("/jde/states", "jde/State", include_str!("state.json")),
    ("/jde/events", "jde/Event", include_str!("event.json")),
];

/// A message of a story.
pub(crate) struct Line {
    /// Its place in [`CHANNELS`].
    pub(crate) channel: usize,
    pub(crate) time: Nanos,
    pub(crate) json: Vec<u8>,
}

/// Turns events into messages.
pub(crate) struct Story {
    schemas: Vec<String>,
    decisions: Decisions<Lines>,
    decided: Lines,
}

/// Lines written by [`Decisions`], to be taken from it.
#[derive(Clone, Default)]
struct Lines(Arc<Mutex<Vec<u8>>>);

/// The time of a line of [`Decisions`].
#[derive(Deserialize)]
struct When {
    time_s: f64,
}

#[derive(Serialize)]
struct StateLine<'a> {
    time_s: f64,
    schema: &'a str,
    from: &'static str,
    to: &'static str,
}

#[derive(Serialize)]
struct EventLine<'a> {
    time_s: f64,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    schema: Option<&'a str>,
    text: String,
}

impl Story {
    pub(crate) fn new(application: &Application) -> Self {
        let decided = Lines::default();
        Self {
            schemas: application
                .instances
                .iter()
                .map(|instance| instance.name.clone())
                .collect(),
            decisions: Decisions::new(application, decided.clone()),
            decided,
        }
    }

    /// The messages that something makes; those of selections come once the time of their takeover is known.
    pub(crate) fn hear(&mut self, told: &Told) -> Vec<Line> {
        match told {
            Told::Event(event) => {
                self.decisions.hear(event);
                let mut lines = self.decided.take();
                lines.extend(self.event(event));
                lines
            }
            Told::Retracted { time, variable } => vec![event_line(
                *time,
                "retracted",
                None,
                format!("the value of {variable} was taken back"),
            )],
        }
    }

    /// Selections whose takeover never came.
    pub(crate) fn finish(self) -> Vec<Line> {
        // Lines in memory cannot fail.
        let _ = self.decisions.finish();
        self.decided.take()
    }

    fn event(&self, event: &Event) -> Option<Line> {
        let name = |schema: &usize| Some(self.schemas[*schema].as_str());
        let ms = |time: Nanos| time as f64 / 1e6;
        Some(match event {
            Event::Decided(_) | Event::Took { .. } => return None,
            Event::Changed {
                time,
                schema,
                from,
                to,
            } => {
                let line = StateLine {
                    time_s: seconds(*time),
                    schema: &self.schemas[*schema],
                    from: state_name(*from),
                    to: state_name(*to),
                };
                Line::new(1, *time, &line)
            }
            Event::Health { time, schema, health } => {
                let (kind, text) = match health {
                    Health::Ok => ("ok", "well again".to_owned()),
                    Health::Overrun => ("overrun", "missed its deadline".to_owned()),
                    Health::ArbitrationFailed(reason) => ("arbitration-failed", reason.clone()),
                    Health::Faulted(reason) => ("faulted", reason.clone()),
                };
                event_line(*time, kind, name(schema), text)
            }
            Event::Overrun {
                time,
                schema,
                took,
                budget,
            } => {
                let text = format!("took {:.3} ms of {:.3} ms", ms(*took), ms(*budget));
                event_line(*time, "overrun", name(schema), text)
            }
            Event::Hung { time, schema, since } => {
                let text = format!(
                    "a call has not returned for {:.3} ms",
                    ms(time.saturating_sub(*since))
                );
                event_line(*time, "hung", name(schema), text)
            }
            Event::Refused { time, schema, what } => event_line(*time, "refused", name(schema), what.clone()),
            Event::Operator { time, action } => {
                let (schema, text) = operator(action);
                event_line(*time, "operator", name(&schema), text)
            }
            Event::Ended { time, outcome } => {
                let text = match outcome {
                    Outcome::Done => "the mission is done",
                    Outcome::Failed => "the mission failed",
                    Outcome::TimeUp => "the time was up",
                    Outcome::Stopped => "it was asked to stop",
                    Outcome::Broken(reason) => reason,
                };
                event_line(*time, "ended", None, text.to_owned())
            }
        })
    }
}

/// Whom an operator acted on, and how.
fn operator(action: &OperatorAction) -> (usize, String) {
    match action {
        OperatorAction::Hierarchy(Operator::Play(id)) => (id.index(), "played".to_owned()),
        OperatorAction::Hierarchy(Operator::Stop(id)) => (id.index(), "stopped".to_owned()),
        OperatorAction::Hierarchy(Operator::Force(id)) => (id.index(), "forced".to_owned()),
        OperatorAction::Hierarchy(Operator::Release(id)) => (id.index(), "released".to_owned()),
        OperatorAction::Period { schema, period } => {
            (*schema, format!("period set to {} s", seconds(*period)))
        }
        OperatorAction::Modulate {
            schema,
            variable,
            value,
        } => (*schema, format!("{variable} set to {value}")),
    }
}

fn event_line(time: Nanos, kind: &'static str, schema: Option<&str>, text: String) -> Line {
    let line = EventLine {
        time_s: seconds(time),
        kind,
        schema,
        text,
    };
    Line::new(2, time, &line)
}

/// Seconds, exact to the nanosecond for the first hundred days.
fn seconds(time: Nanos) -> f64 {
    time as f64 / 1e9
}

impl Line {
    fn new(channel: usize, time: Nanos, line: &impl Serialize) -> Self {
        Self {
            channel,
            time,
            // Numbers and texts always have a form in JSON.
            json: serde_json::to_vec(line).unwrap_or_default(),
        }
    }
}

impl Lines {
    fn take(&self) -> Vec<Line> {
        let text = std::mem::take(&mut *lock(&self.0));
        text.split(|byte| *byte == b'\n')
            .filter(|line| !line.is_empty())
            .map(|line| Line {
                channel: 0,
                time: serde_json::from_slice(line)
                    .map_or(0, |When { time_s }| (time_s * 1e9).round() as Nanos),
                json: line.to_vec(),
            })
            .collect()
    }
}

impl Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        lock(&self.0).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
