//! What a run decided and went through, as messages of JSON with a schema each: names and reasons are texts of any length, which
//! the fixed-size types of variables have no room for. Whoever reads `--decisions`, a recording or the link reads the same lines.

mod decided;
mod lines;

use jde_core::{Health, Nanos};

use crate::app::Application;
use crate::event::{Event, OperatorAction};
pub use decided::{Decided, state_name};
pub use lines::{Candidate, Change, Decision, Happening, Touched};

/// One message of a story.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// A selection.
    Decision(Decision),
    /// A change of state.
    Change(Change),
    /// Whatever else.
    Happening(Happening),
}

/// The kinds of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// [`Line::Decision`].
    Decision,
    /// [`Line::Change`].
    Change,
    /// [`Line::Happening`].
    Happening,
}

/// Turns events into messages.
pub struct Story {
    schemas: Vec<String>,
    groups: Vec<String>,
    decided: Decided,
    /// Tells also of drags that go on.
    whole: bool,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Decision, Self::Change, Self::Happening];

    /// Where messages of this kind are found: `/jde/decisions`.
    #[must_use]
    pub fn topic(self) -> &'static str {
        match self {
            Self::Decision => "/jde/decisions",
            Self::Change => "/jde/states",
            Self::Happening => "/jde/events",
        }
    }

    /// Name of their JSON schema, and the schema.
    #[must_use]
    pub fn schema(self) -> (&'static str, &'static str) {
        match self {
            Self::Decision => ("jde/Decision", include_str!("decision.json")),
            Self::Change => ("jde/State", include_str!("state.json")),
            Self::Happening => ("jde/Event", include_str!("event.json")),
        }
    }
}

impl Story {
    /// Of an application.
    #[must_use]
    pub fn new(application: &Application) -> Self {
        Self {
            schemas: application
                .instances
                .iter()
                .map(|instance| instance.name.clone())
                .collect(),
            groups: application
                .groups
                .iter()
                .map(|group| group.name.clone())
                .collect(),
            decided: Decided::new(application),
            whole: false,
        }
    }

    /// Of an application, with every place of every drag: what it takes to have all turns taken again.
    #[must_use]
    pub fn whole(application: &Application) -> Self {
        Self {
            whole: true,
            ..Self::new(application)
        }
    }

    /// The messages that an event makes; those of selections come once the time of their takeover is known.
    pub fn hear(&mut self, event: &Event) -> Vec<Line> {
        let decided = self.decided.hear(event);
        let mut lines: Vec<_> = decided.into_iter().map(Line::Decision).collect();
        lines.extend(self.event(event));
        lines
    }

    /// Selections whose takeover never came.
    #[must_use]
    pub fn finish(mut self) -> Vec<Line> {
        self.decided.rest().into_iter().map(Line::Decision).collect()
    }

    fn event(&self, event: &Event) -> Option<Line> {
        let name = |schema: &usize| Some(self.schemas[*schema].clone());
        let ms = |time: Nanos| time as f64 / 1e6;
        Some(match event {
            Event::Decided(_) | Event::Took { .. } => return None,
            Event::Changed {
                time,
                schema,
                from,
                to,
            } => Line::Change(Change {
                time_s: seconds(*time),
                schema: self.schemas[*schema].clone(),
                from: state_name(*from).to_owned(),
                to: state_name(*to).to_owned(),
            }),
            Event::Health { time, schema, health } => {
                let (kind, text) = match health {
                    Health::Ok => ("ok", "well again".to_owned()),
                    Health::Overrun => ("overrun", "missed its deadline".to_owned()),
                    Health::ArbitrationFailed(reason) => ("arbitration-failed", reason.clone()),
                    Health::Faulted(reason) => ("faulted", reason.clone()),
                };
                happening(*time, kind, name(schema), text)
            }
            Event::Overrun {
                time,
                schema,
                took,
                budget,
            } => {
                let text = format!("took {:.3} ms of {:.3} ms", ms(*took), ms(*budget));
                happening(*time, "overrun", name(schema), text)
            }
            Event::Hung { time, schema, since } => {
                let text = format!(
                    "a call has not returned for {:.3} ms",
                    ms(time.saturating_sub(*since))
                );
                happening(*time, "hung", name(schema), text)
            }
            Event::LeftBehind {
                time,
                schema,
                since,
                left,
                kept,
                process,
            } => {
                let text = format!(
                    "the call that began {:.3} s ago is left behind, {left} in all; it keeps {kept} bytes of shared values; the process \
                     has {process}",
                    seconds(time.saturating_sub(*since)),
                );
                happening(*time, "left-behind", name(schema), text)
            }
            Event::CameBack {
                time,
                schema,
                since,
                left,
                process,
            } => {
                let text = format!(
                    "a call that was left behind returned after {:.3} s, and its instance ended; {left} have not returned; the process \
                     has {process}",
                    seconds(time.saturating_sub(*since)),
                );
                happening(*time, "came-back", name(schema), text)
            }
            Event::Late {
                time,
                group,
                schema,
                latency,
                allowed,
                ..
            } => {
                let text = format!(
                    "took over in {} after {:.3} ms, and its contract allows {:.3} ms",
                    self.groups[*group],
                    ms(*latency),
                    ms(*allowed)
                );
                happening(*time, "late", name(schema), text)
            }
            Event::Chatters {
                time,
                group,
                between,
                switches,
            } => {
                let [one, other] =
                    between.map(|schema| schema.map_or("nobody", |schema| self.schemas[schema].as_str()));
                let text = format!(
                    "{} chatters between {one} and {other}: {switches} switches within a second",
                    self.groups[*group]
                );
                happening(*time, "chatters", None, text)
            }
            Event::Calmed {
                time,
                group,
                since,
                switches,
            } => {
                let text = format!(
                    "{} has calmed down after {:.1} s and {switches} more switches",
                    self.groups[*group],
                    seconds(time.saturating_sub(*since))
                );
                happening(*time, "calmed", None, text)
            }
            Event::Refused { time, schema, what } => happening(*time, "refused", name(schema), what.clone()),
            Event::Operator { time, by, action } => {
                let touched = match action {
                    OperatorAction::Touch { number, gesture, .. } => Some(Touched {
                        number: *number,
                        gesture: gesture.clone(),
                    }),
                    OperatorAction::Hierarchy(_)
                    | OperatorAction::Unload { .. }
                    | OperatorAction::Load { .. }
                    | OperatorAction::Reload { .. }
                    | OperatorAction::Period { .. }
                    | OperatorAction::Modulate { .. } => None,
                };
                let goes_on = touched.as_ref().is_some_and(|touched| touched.gesture.goes_on());
                if goes_on && !self.whole {
                    return None;
                }
                Line::Happening(Happening {
                    time_s: seconds(*time),
                    kind: if goes_on { "drag" } else { "operator" }.to_owned(),
                    schema: name(&action.schema()),
                    by: Some(by.clone()),
                    text: format!("{by} {}", action.words(&self.schemas[action.schema()])),
                    touched,
                })
            }
            Event::Reloaded {
                time,
                schema,
                takeover,
            } => happening(*time, "reloaded", name(schema), takeover.words()),
            Event::ReloadUndone {
                time,
                schema,
                build,
                reason,
            } => {
                let text = format!("goes on with the build before {build}: {reason}");
                happening(*time, "reload-undone", name(schema), text)
            }
            Event::Ended { time, outcome } => happening(*time, "ended", None, outcome.words().to_owned()),
        })
    }
}

fn happening(time: Nanos, kind: &str, schema: Option<String>, text: String) -> Line {
    Line::Happening(Happening {
        time_s: seconds(time),
        kind: kind.to_owned(),
        schema,
        text,
        ..Happening::default()
    })
}

/// Seconds, exact to the nanosecond for the first hundred days.
pub(crate) fn seconds(time: Nanos) -> f64 {
    time as f64 / 1e9
}

impl Line {
    /// That the value of a variable was taken back.
    #[must_use]
    pub fn retracted(time: Nanos, variable: &str) -> Self {
        happening(
            time,
            "retracted",
            None,
            format!("the value of {variable} was taken back"),
        )
    }

    /// The variable whose value was taken back, if it says that.
    #[must_use]
    pub fn retracted_variable(&self) -> Option<&str> {
        match self {
            Self::Happening(happening) if happening.kind == "retracted" => happening
                .text
                .strip_prefix("the value of ")?
                .strip_suffix(" was taken back"),
            Self::Happening(_) | Self::Decision(_) | Self::Change(_) => None,
        }
    }

    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::Decision(_) => Kind::Decision,
            Self::Change(_) => Kind::Change,
            Self::Happening(_) => Kind::Happening,
        }
    }

    /// When, ns since the application's start.
    #[must_use]
    pub fn time(&self) -> Nanos {
        let time_s = match self {
            Self::Decision(decision) => decision.time_s,
            Self::Change(change) => change.time_s,
            Self::Happening(happening) => happening.time_s,
        };
        (time_s * 1e9).round() as Nanos
    }

    /// The message.
    #[must_use]
    pub fn json(&self) -> Vec<u8> {
        let json = match self {
            Self::Decision(decision) => serde_json::to_vec(decision),
            Self::Change(change) => serde_json::to_vec(change),
            Self::Happening(happening) => serde_json::to_vec(happening),
        };
        // Numbers and texts always have a form in JSON.
        json.unwrap_or_default()
    }

    /// Reads a message of a kind back.
    ///
    /// # Errors
    /// It is no such message.
    pub fn read(kind: Kind, json: &[u8]) -> serde_json::Result<Self> {
        Ok(match kind {
            Kind::Decision => Self::Decision(serde_json::from_slice(json)?),
            Kind::Change => Self::Change(serde_json::from_slice(json)?),
            Kind::Happening => Self::Happening(serde_json::from_slice(json)?),
        })
    }
}
