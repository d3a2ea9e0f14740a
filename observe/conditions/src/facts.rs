//! The part of an event that conditions use, from an event of this process or from a record.

use jde_core::{Case, Health, Id, SchemaId};
use jde_records::RunRecord;
use jde_records::event::{Event, Naming, What};

use super::Names;

/// A fact to which a condition may refer.
pub(crate) enum Fact<'a> {
    /// A selection.
    Selected {
        group: &'a str,
        /// Two or more candidates are READY.
        conflict: bool,
        /// A schema is awake, and none is WINNER.
        absence: bool,
        /// The choice differs from the one before.
        switched: bool,
    },
    /// The health of a schema.
    Health {
        schema: &'a str,
        overrun: bool,
        /// The reason why it cannot continue, if it cannot.
        fault: Option<&'a str>,
    },
    /// A command or a wake was refused.
    Refused { schema: &'a str, text: &'a str },
    /// An operator acted: the operator, and the schema concerned.
    Operator(String),
}

/// Returns the fact of an event, whose schemas and groups have these names.
pub(crate) fn of_event<'a>(event: &'a Event, names: &'a Names) -> Option<Fact<'a>> {
    match event {
        Event::Decision(record) => Some(Fact::Selected {
            group: names.groups.get(record.group.index())?,
            conflict: record.case == Case::Collision,
            absence: record.choice.is_none() && !record.candidates.is_empty(),
            switched: record.changed,
        }),
        Event::State(_) => None,
        Event::Other(occurrence) => of_occurrence(&occurrence.what, |schema: &SchemaId| {
            names.schemas.get(schema.index()).map(String::as_str)
        }),
    }
}

/// Returns the fact of a record.
pub(crate) fn of_record(record: &RunRecord) -> Option<Fact<'_>> {
    match record {
        RunRecord::Decision(decision) => Some(Fact::Selected {
            group: &decision.group,
            conflict: decision.case == Case::Collision,
            absence: decision.choice.is_none() && !decision.candidates.is_empty(),
            switched: decision.changed,
        }),
        RunRecord::State(_) => None,
        RunRecord::Other(occurrence) => of_occurrence(&occurrence.what, |schema: &String| Some(schema)),
    }
}

fn of_occurrence<'a, N: Naming>(
    what: &'a What<N>,
    name: impl Fn(&'a N) -> Option<&'a str>,
) -> Option<Fact<'a>> {
    match what {
        What::HealthChanged { schema, health } => Some(Fact::Health {
            schema: name(schema)?,
            overrun: *health == Health::Overrun,
            fault: match health {
                Health::Faulted(reason) => Some(reason),
                Health::Ok | Health::Overrun | Health::ArbitrationFailed(_) => None,
            },
        }),
        What::Hung { schema, .. } => Some(Fact::Health {
            schema: name(schema)?,
            overrun: true,
            fault: Some("a call does not return"),
        }),
        What::Overrun { schema, .. } => Some(Fact::Health {
            schema: name(schema)?,
            overrun: true,
            fault: None,
        }),
        What::Refused {
            schema, description, ..
        } => Some(Fact::Refused {
            schema: name(schema)?,
            text: description,
        }),
        What::Operator { by, action, .. } => Some(Fact::Operator(format!(
            "{by} acted on {}",
            name(action.schema())?
        ))),
        What::TookOver { .. }
        | What::ChatteringStarted { .. }
        | What::ChatteringEnded { .. }
        | What::StoodStill { .. }
        | What::WentOn { .. }
        | What::Stalled { .. }
        | What::CallAbandoned { .. }
        | What::AbandonedCallReturned { .. }
        | What::Limited { .. }
        | What::Reloaded { .. }
        | What::ReloadRolledBack { .. }
        | What::Retracted { .. }
        | What::Triggered { .. }
        | What::Ended { .. }
        | What::Unknown { .. } => None,
    }
}
