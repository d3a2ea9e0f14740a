//! From the numbers of schemas, groups and ports in a recording to those of the application that takes its turns again. They are
//! found by their names; what is not there any more is nobody's.

use jde_host::app::Application;
use jde_host::turn::{INPUTS, Turn};

use super::Drive;

/// From the numbers of a recording to those of an application.
pub(super) struct Translation {
    schemas: Vec<Option<Member>>,
    groups: Vec<u64>,
}

struct Member {
    number: u32,
    /// For each port of the application, the one of the recording.
    ports: Vec<Option<usize>>,
}

impl Translation {
    /// From a drive to an application.
    pub(super) fn new(drive: &Drive, application: &Application) -> Self {
        let cast = drive.cast();
        let schemas = cast.schemas.iter().map(|then| {
            let number = application.instance(&then.name)?;
            let ports = application.instances[number].schema.ports.iter();
            let ports = ports.map(|port| then.ports.iter().position(|name| *name == port.name));
            Some(Member {
                number: number as u32,
                ports: ports.collect(),
            })
        });
        let groups = cast.groups.iter().map(|then| {
            let mut groups = application.groups.iter();
            let place = groups.position(|group| group.name == then.name);
            place.map_or(u64::MAX, |place| place as u64)
        });
        Self {
            schemas: schemas.collect(),
            groups: groups.collect(),
        }
    }

    /// A turn as the application numbers it.
    pub(super) fn of(&self, mut turn: Turn) -> Turn {
        match turn.kind {
            Turn::STARTED | Turn::TICKED | Turn::ENDED => return turn,
            Turn::ARBITRATED => {
                let group = usize::try_from(turn.detail)
                    .ok()
                    .and_then(|group| self.groups.get(group));
                turn.detail = group.copied().unwrap_or(u64::MAX);
            }
            _ => {}
        }
        let Some(member) = self.schemas.get(turn.schema as usize).and_then(Option::as_ref) else {
            // Its transactions count, and are nobody's.
            (turn.kind, turn.schema) = (0, u32::MAX);
            return turn;
        };
        turn.schema = member.number;
        if turn.kind == Turn::LED {
            let child = usize::try_from(turn.detail)
                .ok()
                .and_then(|child| self.schemas.get(child)?.as_ref());
            turn.detail = child.map_or(u64::MAX, |child| u64::from(child.number));
            return turn;
        }
        if turn.kind == Turn::OPERATED {
            if turn.way == Turn::WROTE && turn.detail != Turn::PERIOD {
                let now = member
                    .ports
                    .iter()
                    .position(|then| *then == Some(turn.detail as usize));
                turn.detail = now.map_or(u64::MAX, |port| port as u64);
            }
            return turn;
        }
        let then = turn.inputs;
        let inputs = turn.inputs.resize(member.ports.len().min(INPUTS));
        for (input, port) in inputs.iter_mut().zip(&member.ports) {
            *input = port
                .and_then(|port| then.get(port).copied())
                .unwrap_or(Turn::UNSEEN);
        }
        turn
    }
}
