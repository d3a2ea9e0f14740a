//! The schemas and groups of a recording: from its description of schemas, or else from the names in its
//! selections and states.

use std::collections::{HashMap, HashSet};

use jde_log::RecordedHierarchy;
use jde_records::{DecidedBy, Decision};

/// Most schemas, and most groups, since the file is untrusted.
const MOST: usize = 4096;

/// Schemas and groups.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hierarchy {
    pub(crate) schemas: Vec<Schema>,
    pub(crate) groups: Vec<Group>,
    schema_places: HashMap<String, usize>,
    group_places: HashMap<String, usize>,
    /// Robots whose commanders are known.
    commanded: HashSet<String>,
}

/// A schema.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Schema {
    pub(crate) name: String,
    /// `stop/stop`; empty if unknown.
    pub(crate) type_name: String,
    /// The group in which it competes.
    pub(crate) group: Option<usize>,
    /// The period configured at the start, ns.
    pub(crate) period: Option<u64>,
    /// The robots that it commands; empty if unknown.
    pub(crate) commands: Vec<String>,
}

/// A group.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Group {
    pub(crate) name: String,
    /// The members, in order of priority.
    pub(crate) members: Vec<usize>,
    /// The policy for collisions; empty if unknown.
    pub(crate) policy: String,
    /// The longest takeover by contract (R17), ns.
    pub(crate) contract: Option<u64>,
}

/// A row of a list in which children follow their fathers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Row {
    /// A group and its depth.
    Group(usize, usize),
    /// A schema and its depth.
    Schema(usize, usize),
}

impl Hierarchy {
    /// Reads a recording's description of its schemas.
    pub(crate) fn new(recorded: Option<&RecordedHierarchy>) -> Self {
        let mut hierarchy = Self::default();
        let Some(recorded) = recorded else {
            return hierarchy;
        };
        for member in &recorded.schemas {
            if let Some(place) = hierarchy.schema(&member.name) {
                let schema = &mut hierarchy.schemas[place];
                schema.type_name.clone_from(&member.type_name);
                schema.period = member.period_ns;
                schema.commands.clone_from(&member.commands);
                hierarchy.commanded.extend(member.commands.iter().cloned());
            }
        }
        for group in &recorded.groups {
            if let Some(place) = hierarchy.group(&group.name) {
                hierarchy.groups[place].policy = group.policy.clone().unwrap_or_default();
                hierarchy.groups[place].contract = group.takeover_ns;
                for member in &group.members {
                    hierarchy.join(place, member);
                }
            }
        }
        hierarchy
    }

    /// The index of a schema, which is added if it is new; none if there are too many.
    pub(crate) fn schema(&mut self, name: &str) -> Option<usize> {
        if let Some(place) = self.schema_places.get(name) {
            return Some(*place);
        }
        let place = Some(self.schemas.len()).filter(|place| *place < MOST)?;
        self.schema_places.insert(name.to_owned(), place);
        self.schemas.push(Schema {
            name: name.to_owned(),
            ..Schema::default()
        });
        Some(place)
    }

    /// The index of a known schema.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.schema_places.get(name).copied()
    }

    /// The index of a selection's group. All its candidates become members.
    pub(crate) fn add_decision(&mut self, decision: &Decision) -> Option<usize> {
        let group = self.group(&decision.group)?;
        if let DecidedBy::Policy(policy) = &decision.decider
            && self.groups[group].policy != *policy
        {
            self.groups[group].policy.clone_from(policy);
        }
        for candidate in &decision.candidates {
            self.join(group, &candidate.name);
        }
        Some(group)
    }

    /// The father of a group, from its name: `example/base`; none for the roots.
    pub(crate) fn father(&self, group: usize) -> Option<usize> {
        let (father, _) = self.groups[group].name.split_once('/')?;
        self.find(father)
    }

    /// The groups of a schema's children.
    pub(crate) fn groups_of(&self, schema: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.groups.len()).filter(move |group| self.father(*group) == Some(schema))
    }

    /// Whether a schema can act: a motor schema without motor children.
    pub(crate) fn is_actor(&self, schema: usize) -> bool {
        self.schemas[schema].group.is_some() && self.groups_of(schema).next().is_none()
    }

    /// Whether a schema acts for a robot: it commands the robot, or the commander is unknown.
    pub(crate) fn acts_for(&self, schema: usize, robot: &str) -> bool {
        !self.commanded.contains(robot)
            || self.schemas[schema]
                .commands
                .iter()
                .any(|commanded| commanded == robot)
    }

    /// The robot that a schema or one of its descendants commands; none if unknown.
    pub(crate) fn robot_of(&self, name: &str) -> Option<String> {
        let mut pending = vec![self.find(name)?];
        // Each schema is examined once, since the file may describe a cycle.
        for place in 0..self.schemas.len() {
            let schema = *pending.get(place)?;
            if let Some(robot) = self.schemas[schema].commands.first() {
                return Some(robot.clone());
            }
            let groups: Vec<usize> = self.groups_of(schema).collect();
            let members = groups.iter().flat_map(|group| &self.groups[*group].members);
            pending.extend(members.copied());
        }
        None
    }

    /// All groups and schemas: children follow their fathers, and schemas without a group are last.
    pub(crate) fn rows(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        let mut shown = vec![false; self.schemas.len()];
        for group in (0..self.groups.len()).filter(|group| self.father(*group).is_none()) {
            self.rows_of(group, 0, &mut shown, &mut rows);
        }
        for schema in 0..self.schemas.len() {
            if !shown[schema] {
                shown[schema] = true;
                rows.push(Row::Schema(schema, 0));
                for group in self.groups_of(schema) {
                    self.rows_of(group, 1, &mut shown, &mut rows);
                }
            }
        }
        rows
    }

    /// Adds the rows of a group. Without recursion, since the file may nest schemas as deep as it likes.
    fn rows_of(&self, group: usize, depth: usize, shown: &mut [bool], rows: &mut Vec<Row>) {
        let mut pending = vec![Row::Group(group, depth)];
        while let Some(row) = pending.pop() {
            match row {
                Row::Group(group, depth) => {
                    let members = self.groups[group].members.iter().rev();
                    pending.extend(members.map(|member| Row::Schema(*member, depth + 1)));
                }
                // A schema is shown once, since the file may make a schema its own father.
                Row::Schema(schema, _) if std::mem::replace(&mut shown[schema], true) => continue,
                Row::Schema(schema, depth) => {
                    let groups: Vec<_> = self.groups_of(schema).collect();
                    pending.extend(groups.into_iter().rev().map(|group| Row::Group(group, depth + 1)));
                }
            }
            rows.push(row);
        }
    }

    fn group(&mut self, name: &str) -> Option<usize> {
        if let Some(place) = self.group_places.get(name) {
            return Some(*place);
        }
        let place = Some(self.groups.len()).filter(|place| *place < MOST)?;
        self.group_places.insert(name.to_owned(), place);
        self.groups.push(Group {
            name: name.to_owned(),
            ..Group::default()
        });
        Some(place)
    }

    fn join(&mut self, group: usize, name: &str) {
        let Some(schema) = self.schema(name) else { return };
        if self.schemas[schema].group.is_none() {
            self.schemas[schema].group = Some(group);
            self.groups[group].members.push(schema);
        }
    }
}

#[cfg(test)]
mod tests {
    use jde_core::{Case, State};
    use jde_records::CandidateRecord;

    use super::*;

    fn decision(group: &str, names: &[&str]) -> Decision {
        let candidate = |name: &&str| CandidateRecord {
            name: (*name).to_owned(),
            state: State::Ready,
            ready: true,
            urgency: None,
        };
        Decision {
            number: 1,
            time_s: 0.0,
            group: group.to_owned(),
            case: Case::Alone,
            candidates: names.iter().map(candidate).collect(),
            before: None,
            choice: None,
            decider: DecidedBy::Father,
            reason: String::new(),
            cause: String::new(),
            changed: false,
            takeover_us: None,
        }
    }

    #[test]
    fn children_follow_their_fathers_in_any_order_of_selections() {
        let mut hierarchy = Hierarchy::default();
        hierarchy.schema("pioneer");
        hierarchy.add_decision(&decision("example/base", &["stop", "goon"]));
        hierarchy.add_decision(&decision("roots", &["example"]));
        let names = hierarchy.rows().into_iter().map(|row| match row {
            Row::Group(group, depth) => (hierarchy.groups[group].name.as_str(), depth),
            Row::Schema(schema, depth) => (hierarchy.schemas[schema].name.as_str(), depth),
        });
        assert_eq!(
            names.collect::<Vec<_>>(),
            [
                ("roots", 0),
                ("example", 1),
                ("example/base", 2),
                ("stop", 3),
                ("goon", 3),
                ("pioneer", 0)
            ]
        );
        let actors: Vec<_> = (0..4).filter(|schema| hierarchy.is_actor(*schema)).collect();
        assert_eq!(actors, [1, 2]);
    }

    #[test]
    fn a_cycle_of_fathers_is_shown_once() {
        let mut hierarchy = Hierarchy::default();
        hierarchy.add_decision(&decision("a/base", &["b"]));
        hierarchy.add_decision(&decision("b/base", &["a"]));
        assert_eq!(hierarchy.rows().len(), 4);
    }
}
