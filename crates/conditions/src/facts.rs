//! The part of an event that conditions use, from an event of this process or from a record.

use jde_core::{Case, Health};
use jde_records::RunRecord;
use jde_records::event::Event;

use super::Names;

/// A fact to which a condition may refer.
pub(crate) enum Fact<'a> {
    /// A selection.
    Selected {
        group: &'a str,
        /// Two or more candidates are READY.
        collision: bool,
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

/// Returns the fact of an event.
pub(crate) fn of_event<'a>(event: &'a Event, names: &'a Names) -> Option<Fact<'a>> {
    let name = |schema: usize| names.schemas.get(schema).map(String::as_str);
    Some(match event {
        Event::Decided(record) => Fact::Selected {
            group: names.groups.get(record.group.index())?,
            collision: record.case == Case::Collision,
            absence: record.choice.is_none() && !record.candidates.is_empty(),
            switched: record.changed,
        },
        Event::HealthChanged { schema, health, .. } => Fact::Health {
            schema: name(*schema)?,
            overrun: *health == Health::Overrun,
            fault: match health {
                Health::Faulted(reason) => Some(reason),
                Health::Ok | Health::Overrun | Health::ArbitrationFailed(_) => None,
            },
        },
        Event::Hung { schema, .. } => Fact::Health {
            schema: name(*schema)?,
            overrun: true,
            fault: Some("a call does not return"),
        },
        Event::Overrun { schema, .. } => Fact::Health {
            schema: name(*schema)?,
            overrun: true,
            fault: None,
        },
        Event::Refused {
            schema, description, ..
        } => Fact::Refused {
            schema: name(*schema)?,
            text: description,
        },
        Event::Operator { by, action, .. } => {
            Fact::Operator(format!("{by} acted on {}", name(action.schema())?))
        }
        _ => return None,
    })
}

/// Returns the fact of a record.
pub(crate) fn of_record(record: &RunRecord) -> Option<Fact<'_>> {
    match record {
        RunRecord::Decision(decision) => Some(Fact::Selected {
            group: &decision.group,
            collision: decision.case == "collision",
            absence: decision.choice.is_none() && !decision.candidates.is_empty(),
            switched: decision.changed,
        }),
        RunRecord::State(_) => None,
        RunRecord::Event(event) => {
            let schema = event.schema.as_deref();
            match event.kind.as_str() {
                "ok" | "arbitration-failed" => Some(Fact::Health {
                    schema: schema?,
                    overrun: false,
                    fault: None,
                }),
                "overrun" => Some(Fact::Health {
                    schema: schema?,
                    overrun: true,
                    fault: None,
                }),
                "faulted" | "hung" => Some(Fact::Health {
                    schema: schema?,
                    overrun: event.kind == "hung",
                    fault: Some(&event.text),
                }),
                "refused" => Some(Fact::Refused {
                    schema: schema?,
                    text: &event.text,
                }),
                "operator" => Some(Fact::Operator(format!(
                    "{} acted on {}",
                    event.by.as_deref().unwrap_or("somebody"),
                    schema?
                ))),
                _ => None,
            }
        }
    }
}
