//! The event of a run with the names of its schemas and groups, as records have it.

use jde_core::{GroupId, SchemaId, Table};

use super::{Loss, Occurrence, OperatorAction, StateChange, What};

/// The names of an application's schemas and groups.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// The schemas.
    pub schemas: Table<SchemaId, String>,
    /// The groups.
    pub groups: Table<GroupId, String>,
}

impl Names {
    fn schema(&self, id: SchemaId) -> String {
        self.schemas[id].clone()
    }

    /// Returns a change of state of the application that has these names.
    #[must_use]
    pub fn state(&self, change: &StateChange) -> StateChange<String> {
        let StateChange { time, from, to, .. } = *change;
        StateChange {
            time,
            schema: self.schema(change.schema),
            from,
            to,
        }
    }

    /// Returns an event of the application that has these names.
    #[must_use]
    pub fn occurrence(&self, occurrence: &Occurrence) -> Occurrence<String> {
        self.what(occurrence.what.clone()).at(occurrence.time)
    }

    fn what(&self, what: What) -> What<String> {
        let name = |id| self.schema(id);
        match what {
            What::HealthChanged { schema, health } => What::HealthChanged {
                schema: name(schema),
                health,
            },
            What::TookOver {
                group,
                record,
                schema,
                latency,
                allowed,
                machine,
            } => What::TookOver {
                group: self.groups[group].clone(),
                record,
                schema: name(schema),
                latency,
                allowed,
                machine,
            },
            What::ChatteringStarted {
                group,
                between,
                switches,
            } => What::ChatteringStarted {
                group: self.groups[group].clone(),
                between: between.map(|schema| schema.map(name)),
                switches,
            },
            What::ChatteringEnded {
                group,
                since,
                switches,
            } => What::ChatteringEnded {
                group: self.groups[group].clone(),
                since,
                switches,
            },
            What::StoodStill { reason } => What::StoodStill { reason },
            What::WentOn { by, one_step } => What::WentOn { by, one_step },
            What::Stalled {
                schema,
                since,
                distance,
                reached,
            } => What::Stalled {
                schema: name(schema),
                since,
                distance,
                reached,
            },
            What::Overrun { schema, took, budget } => What::Overrun {
                schema: name(schema),
                took,
                budget,
            },
            What::Hung { schema, since } => What::Hung {
                schema: name(schema),
                since,
            },
            What::CallAbandoned {
                schema,
                since,
                abandoned,
                retained_bytes,
                process,
            } => What::CallAbandoned {
                schema: name(schema),
                since,
                abandoned,
                retained_bytes,
                process,
            },
            What::AbandonedCallReturned {
                schema,
                since,
                abandoned,
                process,
            } => What::AbandonedCallReturned {
                schema: name(schema),
                since,
                abandoned,
                process,
            },
            What::Refused {
                schema,
                description,
                retry,
            } => What::Refused {
                schema: name(schema),
                description,
                retry,
            },
            What::Limited { schema, description } => What::Limited {
                schema: name(schema),
                description,
            },
            What::Operator { by, action, losses } => What::Operator {
                by,
                action: action.named(name),
                losses: losses.into_iter().map(|loss| self.loss(loss)).collect(),
            },
            What::Reloaded { schema, takeover } => What::Reloaded {
                schema: name(schema),
                takeover,
            },
            What::ReloadRolledBack {
                schema,
                build,
                reason,
            } => What::ReloadRolledBack {
                schema: name(schema),
                build,
                reason,
            },
            What::Retracted { variable } => What::Retracted { variable },
            What::Triggered { condition } => What::Triggered { condition },
            What::Ended { outcome } => What::Ended { outcome },
            What::Unknown {
                kind,
                schema,
                by,
                text,
                data,
            } => What::Unknown {
                kind,
                schema: schema.map(name),
                by,
                text,
                data,
            },
        }
    }

    fn loss(&self, Loss { reader, import }: Loss) -> Loss<String> {
        Loss {
            reader: self.schema(reader),
            import,
        }
    }
}

impl OperatorAction {
    fn named(self, name: impl Fn(SchemaId) -> String) -> OperatorAction<String> {
        match self {
            Self::Play { schema } => OperatorAction::Play { schema: name(schema) },
            Self::Stop { schema } => OperatorAction::Stop { schema: name(schema) },
            Self::Force { schema } => OperatorAction::Force { schema: name(schema) },
            Self::Release { schema } => OperatorAction::Release { schema: name(schema) },
            Self::Unload { schema } => OperatorAction::Unload { schema: name(schema) },
            Self::Load { schema } => OperatorAction::Load { schema: name(schema) },
            Self::Reload { schema, build } => OperatorAction::Reload {
                schema: name(schema),
                build,
            },
            Self::Period { schema, period } => OperatorAction::Period {
                schema: name(schema),
                period,
            },
            Self::Modulate {
                schema,
                variable,
                value,
            } => OperatorAction::Modulate {
                schema: name(schema),
                variable,
                value,
            },
            Self::Fail {
                schema,
                export,
                fault,
            } => OperatorAction::Fail {
                schema: name(schema),
                export,
                fault,
            },
            Self::Repair { schema, export } => OperatorAction::Repair {
                schema: name(schema),
                export,
            },
            Self::Touch {
                schema,
                number,
                gesture,
            } => OperatorAction::Touch {
                schema: name(schema),
                number,
                gesture,
            },
        }
    }
}
