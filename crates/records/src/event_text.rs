//! The texts of events in records.

use jde_core::{Health, Nanos};

use super::{
    EventRecord, GestureRecord, RecordBuilder, RunRecord, StateRecord, event_record, seconds, state_name,
};
use crate::event::{Event, Loss, OperatorAction};

impl RecordBuilder {
    /// Returns the message of a single event, if it has one. Selections and takeovers in time have none.
    pub(super) fn describe_event(&self, event: &Event) -> Option<RunRecord> {
        let name = |schema: &usize| Some(self.schemas[*schema].clone());
        let ms = |time: Nanos| time as f64 / 1e6;
        Some(match event {
            Event::Decided(_) => return None,
            Event::StateChanged {
                time,
                schema,
                from,
                to,
            } => RunRecord::State(StateRecord {
                time_s: seconds(*time),
                schema: self.schemas[*schema].clone(),
                from: state_name(*from),
                to: state_name(*to),
            }),
            Event::HealthChanged { time, schema, health } => {
                let (kind, text) = match health {
                    Health::Ok => ("ok", "well again".to_owned()),
                    Health::Overrun => ("overrun", "missed its deadline".to_owned()),
                    Health::ArbitrationFailed(reason) => ("arbitration-failed", reason.clone()),
                    Health::Faulted(reason) => ("faulted", reason.clone()),
                };
                event_record(*time, kind, name(schema), text)
            }
            Event::Overrun {
                time,
                schema,
                took,
                budget,
            } => {
                let text = format!("took {:.3} ms of {:.3} ms", ms(*took), ms(*budget));
                event_record(*time, "overrun", name(schema), text)
            }
            Event::Hung { time, schema, since } => {
                let text = format!(
                    "a call has not returned for {:.3} ms",
                    ms(time.saturating_sub(*since))
                );
                event_record(*time, "hung", name(schema), text)
            }
            Event::CallAbandoned {
                time,
                schema,
                since,
                abandoned: count,
                retained_bytes: bytes,
                process,
            } => {
                let text = format!(
                    "the call that began {:.3} s ago is left behind, {count} in all; it keeps {bytes} bytes of shared values; the process \
                     has {process}",
                    seconds(time.saturating_sub(*since)),
                );
                event_record(*time, "left-behind", name(schema), text)
            }
            Event::AbandonedCallReturned {
                time,
                schema,
                since,
                abandoned: count,
                process,
            } => {
                let text = format!(
                    "a call that was left behind returned after {:.3} s, and its instance ended; {count} have not returned; the process \
                     has {process}",
                    seconds(time.saturating_sub(*since)),
                );
                event_record(*time, "came-back", name(schema), text)
            }
            Event::TookOver { latency, allowed, .. } if latency <= allowed => return None,
            Event::TookOver {
                time,
                group,
                schema,
                latency,
                allowed,
                machine,
                ..
            } => {
                let mut text = format!(
                    "took over in {} after {:.3} ms, and its contract allows {:.3} ms",
                    self.groups[*group],
                    ms(*latency),
                    ms(*allowed)
                );
                if *machine > 0 {
                    text += &format!("; the machine began turns {:.3} ms late", ms(*machine));
                }
                let kind = if event.is_late() { "late" } else { "delayed" };
                event_record(*time, kind, name(schema), text)
            }
            Event::ChatteringStarted {
                time,
                group,
                between,
                switches,
            } => {
                let [first, second] =
                    between.map(|schema| schema.map_or("nobody", |schema| self.schemas[schema].as_str()));
                let text = format!(
                    "{} chatters between {first} and {second}: {switches} switches within a second",
                    self.groups[*group]
                );
                event_record(*time, "chatters", None, text)
            }
            Event::ChatteringEnded {
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
                event_record(*time, "calmed", None, text)
            }
            Event::StoodStill { time, reason } => event_record(
                *time,
                "stands-still",
                None,
                format!("time stands still: {reason}"),
            ),
            Event::WentOn { time, by, one_step } => {
                let what = if *one_step {
                    "made a step"
                } else {
                    "let time pass again"
                };
                RunRecord::Event(EventRecord {
                    time_s: seconds(*time),
                    kind: "operator".to_owned(),
                    schema: None,
                    by: Some(by.clone()),
                    text: format!("{by} {what}"),
                    touched: None,
                })
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
                event_record(*time, "stalled", name(schema), text)
            }
            Event::Refused {
                time,
                schema,
                description,
            } => event_record(*time, "refused", name(schema), description.clone()),
            Event::Limited {
                time,
                schema,
                description,
            } => event_record(*time, "limited", name(schema), description.clone()),
            Event::Operator {
                time,
                by,
                action,
                losses,
            } => {
                let touched = match action {
                    OperatorAction::Touch { number, gesture, .. } => Some(GestureRecord {
                        number: *number,
                        gesture: gesture.clone(),
                    }),
                    OperatorAction::Hierarchy(_)
                    | OperatorAction::Unload { .. }
                    | OperatorAction::Load { .. }
                    | OperatorAction::Reload { .. }
                    | OperatorAction::Period { .. }
                    | OperatorAction::Modulate { .. }
                    | OperatorAction::Fail { .. }
                    | OperatorAction::Repair { .. } => None,
                };
                let goes_on = touched.as_ref().is_some_and(|touched| touched.gesture.goes_on());
                if goes_on && !self.all_drags {
                    return None;
                }
                let mut text = format!("{by} {}", action.description(&self.schemas[action.schema()]));
                for Loss { reader, import } in losses {
                    text += &format!("; {} loses its {import}", self.schemas[*reader]);
                }
                RunRecord::Event(EventRecord {
                    time_s: seconds(*time),
                    kind: if goes_on { "drag" } else { "operator" }.to_owned(),
                    schema: name(&action.schema()),
                    by: Some(by.clone()),
                    text,
                    touched,
                })
            }
            Event::Reloaded {
                time,
                schema,
                takeover,
            } => event_record(*time, "reloaded", name(schema), takeover.summary()),
            Event::ReloadRolledBack {
                time,
                schema,
                build,
                reason,
            } => {
                let text = format!("goes on with the build before {build}: {reason}");
                event_record(*time, "reload-undone", name(schema), text)
            }
            Event::Ended { time, outcome } => {
                event_record(*time, "ended", None, outcome.message().to_owned())
            }
        })
    }
}
