//! The wording of events in a story.

use jde_core::{Health, Nanos};

use super::{Change, Happening, Line, Story, Touched, happening, seconds, state_name};
use crate::event::{Event, OperatorAction};

impl Story {
    /// Returns the message of a single event, if it has one. Selections and takeovers have none here.
    pub(super) fn event(&self, event: &Event) -> Option<Line> {
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
            Event::Stalled {
                time,
                schema,
                since,
                distance,
                reached,
            } => {
                let text = format!(
                    "the mission has come no nearer for {:.0} s: {distance:.2} m from its target, {reached} reached",
                    seconds(time.saturating_sub(*since))
                );
                happening(*time, "stalled", name(schema), text)
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
