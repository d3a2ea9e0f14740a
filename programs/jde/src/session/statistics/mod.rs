//! Sums over the events of an application: how long each schema was WINNER, how often it took over, and the
//! longest takeover of each group.
//!
//! It has no clock and prints nothing.

use jde_app::Application;
use jde_core::{Nanos, State};
use jde_records::event::{Event, Occurrence, What};

/// Most refusals of a schema that are kept.
const MAX_REFUSALS: usize = 4;

/// The sums so far.
pub(crate) struct Statistics {
    schemas: Vec<SchemaStatistics>,
    groups: Vec<GroupStatistics>,
}

#[derive(Clone, Default)]
struct SchemaStatistics {
    /// The group in which it competes.
    group: Option<usize>,
    /// The groups of its children, in the application's order.
    groups: Vec<usize>,
    /// The time at which it became WINNER, while it is WINNER.
    winner_since: Option<Nanos>,
    /// Time as WINNER before that, ns.
    winner_time: Nanos,
    takeovers: u64,
    /// What was refused, and why: the first different ones.
    refusals: Vec<String>,
}

#[derive(Clone, Default)]
struct GroupStatistics {
    winner: Option<usize>,
    worst: Option<Nanos>,
    late: u64,
}

impl Statistics {
    /// Creates empty sums for an application.
    pub(crate) fn new(application: &Application) -> Self {
        let groups = application.groups.iter();
        Self::with_groups(
            application.instances.len(),
            groups.map(|group| (group.father, group.members.as_slice())),
        )
    }

    /// Creates empty sums for so many schemas and these groups, each a father and its members, the roots
    /// first.
    fn with_groups<'m>(schemas: usize, groups: impl Iterator<Item = (Option<usize>, &'m [usize])>) -> Self {
        let mut schemas = vec![SchemaStatistics::default(); schemas];
        let mut count = 0;
        for (number, (father, members)) in groups.enumerate() {
            count = number + 1;
            for member in members {
                schemas[*member].group = Some(number);
            }
            if let Some(father) = father {
                schemas[father].groups.push(number);
            }
        }
        Self {
            schemas,
            groups: vec![GroupStatistics::default(); count],
        }
    }

    /// Adds an event.
    pub(crate) fn add(&mut self, event: &Event) {
        match event {
            Event::Decision(_) => {}
            Event::State(change) => self.apply_change(change.time, change.schema, change.from, change.to),
            Event::Other(Occurrence { what, .. }) => {
                if let What::TookOver {
                    group,
                    schema,
                    latency,
                    ..
                } = what
                {
                    let sums = &mut self.groups[*group];
                    sums.worst = sums.worst.max(Some(*latency));
                    sums.late += u64::from(what.is_late());
                    self.schemas[*schema].takeovers += 1;
                }
                if let What::Refused { schema, description } = what {
                    let refusals = &mut self.schemas[*schema].refusals;
                    if refusals.len() < MAX_REFUSALS && !refusals.contains(description) {
                        refusals.push(description.clone());
                    }
                }
            }
        }
    }

    /// Returns how long a schema was WINNER until `now`, ns.
    pub(crate) fn winner_time(&self, schema: usize, now: Nanos) -> Nanos {
        let SchemaStatistics {
            winner_since: since,
            winner_time: won,
            ..
        } = &self.schemas[schema];
        won + since.map_or(0, |since| now.saturating_sub(since))
    }

    /// Returns how often a schema became WINNER.
    pub(crate) fn takeovers(&self, schema: usize) -> u64 {
        self.schemas[schema].takeovers
    }

    /// Returns what was refused to a schema, and why: the first different ones.
    pub(crate) fn refusals(&self, schema: usize) -> &[String] {
        &self.schemas[schema].refusals
    }

    /// Returns how often any motor schema became WINNER.
    pub(crate) fn total_takeovers(&self) -> u64 {
        self.schemas.iter().map(|schema| schema.takeovers).sum()
    }

    /// Returns the longest takeover of a group so far, ns.
    pub(crate) fn worst(&self, group: usize) -> Option<Nanos> {
        self.groups[group].worst
    }

    /// Returns how many takeovers of a group took longer than its contract permits (R17).
    pub(crate) fn late(&self, group: usize) -> u64 {
        self.groups[group].late
    }

    /// Returns the schemas that act now: the winners without groups of their own, among the winners of the
    /// roots and of the groups below winners. A winner whose groups have no winner adds none.
    pub(crate) fn acting_schemas(&self) -> Vec<usize> {
        let below = |group: &usize| self.groups[*group].winner;
        let is_root = |number: &usize| !self.schemas.iter().any(|schema| schema.groups.contains(number));
        let mut winning: Vec<usize> = (0..self.groups.len())
            .filter(is_root)
            .filter_map(|group| below(&group))
            .collect();
        let mut acting = Vec::new();
        while let Some(winner) = winning.pop() {
            let groups = &self.schemas[winner].groups;
            if groups.is_empty() {
                acting.push(winner);
            }
            winning.extend(groups.iter().filter_map(below));
        }
        acting
    }

    /// Returns the motor schemas without motor children, which are those that can act.
    pub(crate) fn actors(&self) -> impl Iterator<Item = usize> {
        let schemas = self.schemas.iter().enumerate();
        schemas
            .filter(|(_, schema)| schema.group.is_some() && schema.groups.is_empty())
            .map(|(number, _)| number)
    }

    fn apply_change(&mut self, time: Nanos, schema: usize, from: State, to: State) {
        let sums = &mut self.schemas[schema];
        if from == State::Winner {
            sums.winner_time += sums
                .winner_since
                .take()
                .map_or(0, |since| time.saturating_sub(since));
        }
        if to == State::Winner {
            sums.winner_since = Some(time);
        }
        let Some(group) = sums.group.map(|group| &mut self.groups[group]) else {
            return;
        };
        if to == State::Winner {
            group.winner = Some(schema);
        } else if group.winner == Some(schema) {
            group.winner = None;
        }
    }
}

#[cfg(test)]
mod tests;
