//! The present of a timeline, in the form in which a running application shows its own.

use jde_core::State;
use jde_records::snapshot::{self, GroupView, SchemaView, Snapshot};

use crate::timeline::Timeline;

impl Timeline {
    /// Returns the present as a snapshot, as far as it is known from what was added. A schema has authority if it and all
    /// its fathers are WINNER.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let is_winner = |place: usize| self.schemas()[place].state() == State::Winner;
        let schemas = self.hierarchy().schemas().iter().zip(self.schemas()).enumerate();
        let groups = self.hierarchy().groups().iter().zip(self.groups());
        Snapshot {
            time: self.now(),
            schemas: schemas
                .map(|(place, (schema, known))| SchemaView {
                    name: schema.name.clone(),
                    type_name: schema.type_name.clone(),
                    kind: schema.kind,
                    father: schema.father,
                    group: schema.group,
                    state: known.state(),
                    health: known.health.clone(),
                    authority: self.hierarchy().fathers(place).all(is_winner),
                    iterations: known.counts.iterations,
                    overruns: known.counts.overruns,
                    refused: known.counts.refused,
                    faults: known.counts.faults,
                    ..SchemaView::default()
                })
                .collect(),
            groups: groups
                .map(|(group, known)| GroupView {
                    name: group.name.clone(),
                    father: group.father,
                    members: group.members.clone(),
                    winner: known.winner(),
                    policy: group.policy.clone(),
                    switches: known.counts.switches,
                    last: known.switches.back().map(|last| snapshot::Switch {
                        time: last.time,
                        from: last.from,
                        to: last.to,
                        decider: last.decider.clone(),
                        reason: last.reason.clone(),
                        latency: last.latency,
                    }),
                    worst: known.counts.worst.unwrap_or_default(),
                    allowed: group.contract.unwrap_or_default(),
                    late: known.counts.late,
                    ..GroupView::default()
                })
                .collect(),
            ..Snapshot::default()
        }
    }
}

/// Returns the winners from the roots down. Follows the first group of each winner, as long as that group has
/// a winner.
#[must_use]
pub fn acting(snapshot: &Snapshot) -> Vec<String> {
    let mut names = Vec::new();
    let mut father = None;
    while let Some(group) = snapshot.groups.iter().find(|group| group.father == father)
        && let Some(winner) = group.winner
        && names.len() < snapshot.schemas.len()
    {
        if snapshot.schemas[winner].state != State::Winner {
            break;
        }
        names.push(snapshot.schemas[winner].name.clone());
        father = Some(winner);
    }
    names
}
