//! Translates the numbers of schemas, groups and ports in a recording to those of the application that
//! repeats it. It matches them by name. Steps of schemas that the application no longer has belong to no
//! schema.

use jde_app::Application;
use jde_records::turn::{RecordedTurn, Turn};

use super::Drive;

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

impl Translation {
    /// Builds the translation from a drive to an application.
    pub(super) fn new(drive: &Drive, application: &Application) -> Self {
        let hierarchy = drive.hierarchy();
        let schemas = hierarchy.schemas.iter().map(|recorded| {
            let number = application.instance(&recorded.name)?;
            let ports = application.instances[number].schema.ports.iter();
            let ports = ports.map(|port| recorded.ports.iter().position(|name| *name == port.name));
            Some(SchemaMapping {
                number: number as u32,
                ports: ports.collect(),
            })
        });
        let groups = hierarchy.groups.iter().map(|recorded| {
            let mut groups = application.groups.iter();
            let index = groups.position(|group| group.name == recorded.name);
            index.map_or(u64::MAX, |index| index as u64)
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
        match turn.kind {
            Turn::STARTED | Turn::TICKED | Turn::ENDED => return RecordedTurn { turn, ports },
            Turn::ARBITRATED => {
                turn.detail = self.group(turn.detail);
            }
            _ => {}
        }
        let Some(member) = self.schemas.get(turn.schema as usize).and_then(Option::as_ref) else {
            // Its transactions keep their place in the order, and belong to no schema.
            (turn.kind, turn.schema) = (0, u32::MAX);
            return RecordedTurn { turn, ports };
        };
        turn.schema = member.number;
        if turn.kind == Turn::FATHER_ACTED && turn.way == Turn::CHANGED_POLICY {
            turn.detail = self.group(turn.detail);
            return RecordedTurn { turn, ports };
        }
        if turn.kind == Turn::FATHER_ACTED {
            let child = usize::try_from(turn.detail)
                .ok()
                .and_then(|child| self.schemas.get(child)?.as_ref());
            turn.detail = child.map_or(u64::MAX, |child| u64::from(child.number));
            return RecordedTurn { turn, ports };
        }
        if turn.kind == Turn::OPERATED {
            let name_a_port = [Turn::WROTE, Turn::FAILED_EXPORT, Turn::REPAIRED_EXPORT];
            if name_a_port.contains(&turn.way) && turn.detail != Turn::PERIOD {
                let port = member
                    .ports
                    .iter()
                    .position(|recorded| *recorded == Some(turn.detail as usize));
                turn.detail = port.map_or(u64::MAX, |port| port as u64);
            }
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
