//! Translates the numbers of schemas, groups and ports in a recording to those of the application that
//! repeats it. It matches them by name. Steps of schemas that the application no longer has belong to no
//! schema.

use jde_app::Application;
use jde_records::turn::{FatherOperation, Operation, RecordedTurn, Turn, TurnKind, WrittenPort};

use crate::ReplayedDrive;

/// The translation from the numbers of a recording to those of an application.
pub(super) struct Translation {
    schemas: Vec<Option<SchemaMapping>>,
    groups: Vec<u64>,
    /// The number of ports of each schema of the recording.
    counts: Vec<usize>,
}

struct SchemaMapping {
    number: u32,
    /// For each port of the application, the index of the one in the recording.
    ports: Vec<Option<usize>>,
}

impl SchemaMapping {
    fn port(&self, recorded: u64) -> u64 {
        let mut ports = self.ports.iter();
        let port = ports.position(|port| *port == Some(recorded as usize));
        port.map_or(u64::MAX, |port| port as u64)
    }
}

impl Translation {
    /// Builds the translation from a drive to an application.
    pub(super) fn new(drive: &ReplayedDrive, application: &Application) -> Self {
        let hierarchy = drive.hierarchy();
        let schemas = hierarchy.schemas.iter().map(|recorded| {
            let id = application.instance(&recorded.name)?;
            let ports = application.instances[id].schema.ports.iter();
            let ports = ports.map(|port| {
                let recorded_as = |name: &str| recorded.ports.iter().position(|other| other == name);
                recorded_as(&port.name).or_else(|| recorded_as(port.former_name.as_deref()?))
            });
            Some(SchemaMapping {
                number: id.0,
                ports: ports.collect(),
            })
        });
        let groups = hierarchy.groups.iter().map(|recorded| {
            let group = application.groups.find(|group| group.name == recorded.name);
            group.map_or(u64::MAX, |group| group.0.into())
        });
        Self {
            schemas: schemas.collect(),
            groups: groups.collect(),
            counts: hierarchy
                .schemas
                .iter()
                .map(|recorded| recorded.ports.len())
                .collect(),
        }
    }

    /// Translates a turn.
    pub(super) fn of(&self, recorded: RecordedTurn) -> RecordedTurn {
        let RecordedTurn { mut turn, ports } = recorded;
        let kind = turn.kind();
        if matches!(kind, TurnKind::Started | TurnKind::Ticked | TurnKind::Ended) {
            return RecordedTurn { turn, ports };
        }
        let Some(member) = self.schemas.get(turn.schema as usize).and_then(Option::as_ref) else {
            // Its transactions keep their place in the order, and belong to no schema.
            turn.set_kind(TurnKind::Unknown);
            turn.schema = u32::MAX;
            return RecordedTurn { turn, ports };
        };
        turn.schema = member.number;
        turn.set_kind(self.kind(kind, member));
        if matches!(kind, TurnKind::FatherActed(_) | TurnKind::Operated(_)) {
            return RecordedTurn { turn, ports };
        }
        let reading = |port: &Option<usize>| port.and_then(|port| ports.get(port).copied());
        let ports = member
            .ports
            .iter()
            .map(|port| reading(port).unwrap_or(Turn::UNUSED));
        let ports = ports.collect();
        RecordedTurn { turn, ports }
    }

    /// Translates what a turn of a schema was.
    fn kind(&self, kind: TurnKind, member: &SchemaMapping) -> TurnKind {
        let operated = |operation| TurnKind::Operated(operation);
        match kind {
            TurnKind::Arbitrated { group } => TurnKind::Arbitrated {
                group: self.group(group),
            },
            TurnKind::FatherActed(operation) => TurnKind::FatherActed(match operation {
                FatherOperation::Woke { child } => FatherOperation::Woke {
                    child: self.child(child),
                },
                FatherOperation::PutToSleep { child } => FatherOperation::PutToSleep {
                    child: self.child(child),
                },
                FatherOperation::ChangedPolicy { group } => FatherOperation::ChangedPolicy {
                    group: self.group(group),
                },
            }),
            TurnKind::Operated(Operation::Wrote(WrittenPort::Port(port))) => {
                operated(Operation::Wrote(WrittenPort::Port(member.port(port))))
            }
            TurnKind::Operated(Operation::FailedExport { port }) => operated(Operation::FailedExport {
                port: member.port(port),
            }),
            TurnKind::Operated(Operation::RepairedExport { port }) => operated(Operation::RepairedExport {
                port: member.port(port),
            }),
            other => other,
        }
    }

    fn child(&self, recorded: u64) -> u64 {
        let child = usize::try_from(recorded)
            .ok()
            .and_then(|child| self.schemas.get(child)?.as_ref());
        child.map_or(u64::MAX, |child| u64::from(child.number))
    }

    fn group(&self, recorded: u64) -> u64 {
        let group = usize::try_from(recorded)
            .ok()
            .and_then(|recorded| self.groups.get(recorded));
        group.copied().unwrap_or(u64::MAX)
    }

    /// Returns the number of ports of a schema of the recording, by its number there.
    pub(super) fn recorded_ports(&self, schema: u32) -> usize {
        self.counts.get(schema as usize).copied().unwrap_or(0)
    }
}
