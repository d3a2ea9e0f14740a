//! The hierarchy of a recording at any time, reconstructed from its lines: states, winners, health.

use jde_abi::describe::Kind;
use jde_core::{Health, Nanos, State};
use jde_link::message::{GroupInfo, SchemaInfo, Schemas};
use jde_log::RecordedHierarchy;
use jde_records::check::check_fathers;
use jde_records::event::{Occurrence, What};
use jde_records::snapshot::{GroupView, SchemaView, Snapshot, Switch};
use jde_records::{DecidedBy, Decision, RunRecord};

use super::index::Cycle;

/// The schemas and groups of a recording: from its own list, or else from all names in its lines.
pub(super) struct HierarchyNames {
    /// Whether the recording has a list of its own.
    has_list: bool,
    /// Schemas, with their types if known.
    schemas: Vec<(String, String)>,
    /// Groups, with their members.
    groups: Vec<(String, Vec<String>)>,
}

/// The hierarchy after the lines so far.
#[derive(Clone)]
pub(super) struct Hierarchy {
    snapshot: Snapshot,
}

impl HierarchyNames {
    pub(super) fn new(recorded: Option<&RecordedHierarchy>) -> Self {
        let schemas = recorded.into_iter().flat_map(|recorded| &recorded.schemas);
        let groups = recorded.into_iter().flat_map(|recorded| &recorded.groups);
        Self {
            has_list: recorded.is_some(),
            schemas: schemas
                .map(|schema| (schema.name.clone(), schema.type_name.clone()))
                .collect(),
            groups: groups
                .map(|group| (group.name.clone(), group.members.clone()))
                .collect(),
        }
    }

    /// Adds the names in a line.
    pub(super) fn add_line(&mut self, line: &RunRecord) {
        match line {
            RunRecord::State(change) => add_schema(&mut self.schemas, &change.schema),
            RunRecord::Decision(decision) => {
                let known = self.groups.iter_mut().find(|(name, _)| *name == decision.group);
                let names = decision.candidates.iter().map(|candidate| candidate.name.clone());
                match known {
                    Some(_) if self.has_list => {}
                    Some((_, members)) => {
                        for name in names.filter(|name| !members.contains(name)).collect::<Vec<_>>() {
                            members.push(name);
                        }
                    }
                    None => self.groups.push((decision.group.clone(), names.collect())),
                }
                for candidate in &decision.candidates {
                    add_schema(&mut self.schemas, &candidate.name);
                }
            }
            RunRecord::Other(_) => {}
        }
    }

    /// Returns the hierarchy before the first line: only names, groups and fathers are known.
    pub(super) fn hierarchy(&self) -> Hierarchy {
        let Self { schemas, groups, .. } = self;
        let index = |name: &str| schemas.iter().position(|(known, _)| known == name);
        // A group's name begins with its father's: `example/base`.
        let father = |group: &str| group.split_once('/').and_then(|(father, _)| index(father));
        let mut views: Vec<_> = schemas
            .iter()
            .map(|(name, type_name)| SchemaView {
                name: name.clone(),
                type_name: type_name.clone(),
                ..SchemaView::default()
            })
            .collect();
        let mut groups: Vec<_> = groups
            .iter()
            .map(|(name, members)| (father(name), name, members))
            .map(|(father, name, members)| GroupView {
                name: name.clone(),
                father,
                members: members.iter().filter_map(|name| index(name)).collect(),
                ..GroupView::default()
            })
            .collect();
        for (group_index, group) in groups.iter_mut().enumerate() {
            // A schema competes in one group. A damaged recording could state several.
            group.members.retain(|member| {
                let view = &mut views[*member];
                let is_new = view.kind != Kind::Motor;
                if is_new {
                    (view.group, view.father, view.kind) = (Some(group_index), group.father, Kind::Motor);
                }
                is_new
            });
        }
        // Nor can it have fathers without end.
        let fathers: Vec<_> = views.iter().map(|view| view.father).collect();
        if check_fathers(&fathers).is_err() {
            groups.iter_mut().for_each(|group| group.father = None);
            views.iter_mut().for_each(|view| view.father = None);
        }
        Hierarchy {
            snapshot: Snapshot {
                time: 0,
                groups,
                schemas: views,
                ..Snapshot::default()
            },
        }
    }
}

impl Hierarchy {
    /// Applies the next line.
    pub(super) fn apply(&mut self, line: &RunRecord) {
        self.snapshot.time = self.snapshot.time.max(line.time());
        match line {
            RunRecord::State(change) => {
                if let Some(schema) = self.schema_mut(&change.schema) {
                    schema.state = change.to;
                }
            }
            RunRecord::Decision(decision) => self.apply_decision(decision),
            RunRecord::Other(event) => self.apply_event(event),
        }
    }

    fn apply_event(&mut self, event: &Occurrence<String>) {
        let Some(schema) = event.what.schema().and_then(|name| self.schema_mut(name)) else {
            return;
        };
        match &event.what {
            What::HealthChanged { health, .. } => {
                schema.faults += u64::from(matches!(health, Health::Faulted(_)));
                schema.health.clone_from(health);
            }
            What::Overrun { .. } => {
                schema.overruns += 1;
                schema.health = Health::Overrun;
            }
            What::Refused { .. } => schema.refused += 1,
            What::TookOver { .. }
            | What::ChatteringStarted { .. }
            | What::ChatteringEnded { .. }
            | What::StoodStill { .. }
            | What::WentOn { .. }
            | What::Stalled { .. }
            | What::Hung { .. }
            | What::CallAbandoned { .. }
            | What::AbandonedCallReturned { .. }
            | What::Limited { .. }
            | What::Operator { .. }
            | What::Reloaded { .. }
            | What::ReloadRolledBack { .. }
            | What::Retracted { .. }
            | What::Triggered { .. }
            | What::Ended { .. }
            | What::Unknown { .. } => {}
        }
    }

    /// Applies a cycle.
    pub(super) fn apply_cycle(&mut self, cycle: &Cycle) {
        if let Some(schema) = self.snapshot.schemas.get_mut(cycle.schema) {
            schema.iterations += u64::from(cycle.iterated);
        }
    }

    /// Returns the hierarchy at a time. A schema has authority if it and all its fathers are WINNER.
    pub(super) fn snapshot(&self, time: Nanos) -> Snapshot {
        let mut snapshot = self.snapshot.clone();
        snapshot.time = time;
        let mut authority = vec![false; snapshot.schemas.len()];
        for (index, granted) in authority.iter_mut().enumerate() {
            let mut next = Some(index);
            // At most as many steps as there are schemas: a damaged file could contain a loop of fathers.
            *granted = (0..snapshot.schemas.len()).all(|_| match next {
                Some(schema) if snapshot.schemas[schema].state == State::Winner => {
                    next = snapshot.schemas[schema].father;
                    true
                }
                Some(_) => false,
                None => true,
            });
        }
        for (schema, granted) in snapshot.schemas.iter_mut().zip(authority) {
            schema.authority = granted;
        }
        snapshot
    }

    /// Returns the schemas and groups, as far as they are known.
    pub(super) fn schemas(&self) -> Schemas {
        let Snapshot { schemas, groups, .. } = &self.snapshot;
        let name = |index: usize| schemas[index].name.clone();
        Schemas {
            schemas: schemas
                .iter()
                .map(|schema| SchemaInfo {
                    type_name: schema.type_name.clone(),
                    kind: schema.kind.to_string(),
                    father: schema.father.map(name),
                    group: schema.group.map(|group| groups[group].name.clone()),
                    period_s: schema.period as f64 / 1e9,
                    ..unknown_schema(&schema.name)
                })
                .collect(),
            groups: groups
                .iter()
                .map(|group| GroupInfo {
                    name: group.name.clone(),
                    father: group.father.map(name),
                    members: group.members.iter().copied().map(name).collect(),
                    policy: group.policy.clone(),
                })
                .collect(),
        }
    }

    fn apply_decision(&mut self, decision: &Decision) {
        let index = |name: &Option<String>| {
            let name = name.as_deref()?;
            self.snapshot
                .schemas
                .iter()
                .position(|schema| schema.name == name)
        };
        let (from, to) = (index(&decision.before), index(&decision.choice));
        let latency = decision.takeover_us.map(|us| (us * 1e3) as Nanos);
        let Some(group) = self
            .snapshot
            .groups
            .iter_mut()
            .find(|group| group.name == decision.group)
        else {
            return;
        };
        group.winner = to;
        if let DecidedBy::Policy(policy) = &decision.decider {
            group.policy.clone_from(policy);
        }
        if decision.changed {
            group.switches += 1;
            group.worst = group.worst.max(latency.unwrap_or(0));
            group.last = Some(Switch {
                time: (decision.time_s * 1e9) as Nanos,
                from,
                to,
                decider: decision.decider.to_string(),
                reason: decision.reason.clone(),
                latency,
            });
        }
    }

    fn schema_mut(&mut self, name: &str) -> Option<&mut SchemaView> {
        self.snapshot
            .schemas
            .iter_mut()
            .find(|schema| schema.name == name)
    }
}

/// A schema of which only the name is known.
pub(super) fn unknown_schema(name: &str) -> SchemaInfo {
    SchemaInfo {
        name: name.to_owned(),
        kind: Kind::Perceptive.to_string(),
        ..SchemaInfo::default()
    }
}

fn add_schema(schemas: &mut Vec<(String, String)>, name: &str) {
    if schemas.iter().all(|(known, _)| known != name) {
        schemas.push((name.to_owned(), String::new()));
    }
}
