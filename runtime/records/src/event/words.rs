//! The names of events, and their description in English. Nothing reads these words, except of records of earlier versions:
//! see `earlier`.

use std::fmt;

use jde_core::{Health, Nanos};

use super::{Loss, Naming, Occurrence, What};
use crate::seconds;

impl<N: Naming> What<N> {
    /// The name of its kind: those of docs/recordings.md.
    #[must_use]
    pub fn kind(&self) -> &str {
        match self {
            Self::HealthChanged { health, .. } => match health {
                Health::Ok => "ok",
                Health::Overrun => "overrun",
                Health::ArbitrationFailed(_) => "arbitration-failed",
                Health::Faulted(_) => "faulted",
            },
            Self::TookOver { .. } if self.is_late() => "late",
            Self::TookOver { .. } => "delayed",
            Self::ChatteringStarted { .. } => "chatters",
            Self::ChatteringEnded { .. } => "calmed",
            Self::StoodStill { .. } => "stands-still",
            Self::WentOn { .. } => "operator",
            Self::Stalled { .. } => "stalled",
            Self::Overrun { .. } => "overrun",
            Self::Hung { .. } => "hung",
            Self::CallAbandoned { .. } => "left-behind",
            Self::AbandonedCallReturned { .. } => "came-back",
            Self::Refused { .. } => "refused",
            Self::Limited { .. } => "limited",
            Self::Operator { action, .. } if action.goes_on() => "drag",
            Self::Operator { .. } => "operator",
            Self::Reloaded { .. } => "reloaded",
            Self::ReloadRolledBack { .. } => "reload-undone",
            Self::Retracted { .. } => "retracted",
            Self::Triggered { .. } => "trigger",
            Self::Ended { .. } => "ended",
            Self::Unknown { kind, .. } => kind,
        }
    }

    /// The schema concerned, if any.
    #[must_use]
    pub fn schema(&self) -> Option<&N> {
        match self {
            Self::HealthChanged { schema, .. }
            | Self::TookOver { schema, .. }
            | Self::Stalled { schema, .. }
            | Self::Overrun { schema, .. }
            | Self::Hung { schema, .. }
            | Self::CallAbandoned { schema, .. }
            | Self::AbandonedCallReturned { schema, .. }
            | Self::Refused { schema, .. }
            | Self::Limited { schema, .. }
            | Self::Reloaded { schema, .. }
            | Self::ReloadRolledBack { schema, .. } => Some(schema),
            Self::Operator { action, .. } => Some(action.schema()),
            Self::Unknown { schema, .. } => schema.as_ref(),
            Self::ChatteringStarted { .. }
            | Self::ChatteringEnded { .. }
            | Self::StoodStill { .. }
            | Self::WentOn { .. }
            | Self::Retracted { .. }
            | Self::Triggered { .. }
            | Self::Ended { .. } => None,
        }
    }

    /// The operator who acted, if any.
    #[must_use]
    pub fn by(&self) -> Option<&str> {
        match self {
            Self::WentOn { by, .. } | Self::Operator { by, .. } => Some(by),
            Self::Unknown { by, .. } => by.as_deref(),
            Self::HealthChanged { .. }
            | Self::TookOver { .. }
            | Self::ChatteringStarted { .. }
            | Self::ChatteringEnded { .. }
            | Self::StoodStill { .. }
            | Self::Stalled { .. }
            | Self::Overrun { .. }
            | Self::Hung { .. }
            | Self::CallAbandoned { .. }
            | Self::AbandonedCallReturned { .. }
            | Self::Refused { .. }
            | Self::Limited { .. }
            | Self::Reloaded { .. }
            | Self::ReloadRolledBack { .. }
            | Self::Retracted { .. }
            | Self::Triggered { .. }
            | Self::Ended { .. } => None,
        }
    }
}

impl Occurrence<String> {
    /// When, s since the application's start.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        seconds(self.time)
    }

    /// Describes it without naming the schema: "took 12.000 ms of 10.000 ms".
    #[must_use]
    pub fn text(&self) -> String {
        let ms = |time: Nanos| time as f64 / 1e6;
        let after = |since: Nanos| self.time.saturating_sub(since);
        match &self.what {
            What::HealthChanged { health, .. } => match health {
                Health::Ok => "well again".to_owned(),
                Health::Overrun => "missed its deadline".to_owned(),
                Health::ArbitrationFailed(reason) | Health::Faulted(reason) => reason.clone(),
            },
            What::Overrun { took, budget, .. } => {
                format!("took {:.3} ms of {:.3} ms", ms(*took), ms(*budget))
            }
            What::Hung { since, .. } => {
                format!("a call has not returned for {:.3} ms", ms(after(*since)))
            }
            What::CallAbandoned {
                since,
                abandoned: count,
                retained_bytes: bytes,
                process,
                ..
            } => format!(
                "the call that began {:.3} s ago is left behind, {count} in all; it keeps {bytes} bytes of shared values; the process \
                 has {process}",
                seconds(after(*since)),
            ),
            What::AbandonedCallReturned {
                since,
                abandoned: count,
                process,
                ..
            } => format!(
                "a call that was left behind returned after {:.3} s, and its instance ended; {count} have not returned; the process \
                 has {process}",
                seconds(after(*since)),
            ),
            What::TookOver {
                group,
                latency,
                allowed,
                machine,
                ..
            } => {
                let machine = match machine {
                    0 => String::new(),
                    late => format!("; the machine began turns {:.3} ms late", ms(*late)),
                };
                let (latency, allowed) = (ms(*latency), ms(*allowed));
                format!(
                    "took over in {group} after {latency:.3} ms, and its contract allows {allowed:.3} ms{machine}"
                )
            }
            What::ChatteringStarted {
                group,
                between,
                switches,
            } => {
                let [first, second] = between
                    .each_ref()
                    .map(|schema| schema.as_deref().unwrap_or("nobody"));
                format!("{group} chatters between {first} and {second}: {switches} switches within a second")
            }
            What::ChatteringEnded {
                group,
                since,
                switches,
            } => {
                let after = seconds(after(*since));
                format!("{group} has calmed down after {after:.1} s and {switches} more switches")
            }
            What::StoodStill { reason } => format!("time stands still: {reason}"),
            What::WentOn { by, one_step: true } => format!("{by} made a step"),
            What::WentOn { by, one_step: false } => format!("{by} let time pass again"),
            What::Stalled {
                since,
                distance,
                reached,
                ..
            } => format!(
                "the mission has come no nearer for {:.0} s: {distance:.2} m from its target, {reached} reached",
                seconds(after(*since))
            ),
            What::Refused { description, .. } | What::Limited { description, .. } => description.clone(),
            What::Operator { by, action, losses } => {
                let mut text = format!("{by} {}", action.description());
                for Loss { reader, import } in losses {
                    text += &format!("; {reader} loses its {import}");
                }
                text
            }
            What::Reloaded { takeover, .. } => takeover.summary(),
            What::ReloadRolledBack { build, reason, .. } => {
                format!("goes on with the build before {build}: {reason}")
            }
            What::Retracted { variable } => format!("the value of {variable} was taken back"),
            What::Triggered { condition } => condition.clone(),
            What::Ended { outcome } => outcome.message().to_owned(),
            What::Unknown { text, .. } => text.clone(),
        }
    }
}

/// The schema if there is one, the kind and the description: `goon faulted: it panicked`.
impl fmt::Display for Occurrence<String> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(schema) = self.what.schema() {
            write!(f, "{schema} ")?;
        }
        write!(f, "{}: {}", self.what.kind(), self.text())
    }
}
