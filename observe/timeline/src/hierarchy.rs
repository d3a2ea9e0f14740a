//! The schemas and groups of a run: from its application, from a snapshot, from the list of a recording, or else from the
//! names in its records. Fathers have no loop, whatever a file says.

use std::collections::HashMap;

use jde_abi::describe::Kind;
use jde_app::{Application, Binding};
use jde_core::{Id, Nanos};
use jde_records::check::MAX_SCHEMAS;
use jde_records::snapshot::Snapshot;
use jde_records::{Decision, RunRecord};

/// Schemas and groups, by their places.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    schemas: Vec<SchemaEntry>,
    groups: Vec<Group>,
    schema_places: HashMap<String, usize>,
    group_places: HashMap<String, usize>,
    /// Whether the members of the groups are known from elsewhere than selections.
    is_complete: bool,
}

/// A schema.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SchemaEntry {
    /// Its name.
    pub name: String,
    /// Its type, `stop/stop`; empty if unknown.
    pub type_name: String,
    /// Its kind; in a recording, all that do not compete count as perceptive.
    pub kind: Kind,
    /// Its father.
    pub father: Option<usize>,
    /// The group in which it competes.
    pub group: Option<usize>,
    /// The groups of its children.
    pub groups: Vec<usize>,
    /// Its period at the start, ns.
    pub period: Option<Nanos>,
    /// The robots that it commands; empty if unknown.
    pub commands: Vec<String>,
}

/// A group.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Group {
    /// Its name: `roots`, `example/base`.
    pub name: String,
    /// Its father; `None` for the roots.
    pub father: Option<usize>,
    /// The members, in order of priority.
    pub members: Vec<usize>,
    /// The policy for collisions; empty if unknown.
    pub policy: String,
    /// The longest takeover by contract (R17), ns.
    pub contract: Option<Nanos>,
}

impl Hierarchy {
    /// Returns the hierarchy of an application, with its places.
    #[must_use]
    pub fn of_application(application: &Application) -> Self {
        let mut hierarchy = Self::default();
        for instance in &application.instances {
            let plugin = &application.plugins[instance.plugin].name;
            let targets = instance.bindings.iter().filter_map(|binding| match binding {
                Binding::Actuator { target } => Some(application.instances[(*target)?.instance].name.clone()),
                _ => None,
            });
            hierarchy.push(SchemaEntry {
                name: instance.name.clone(),
                type_name: format!("{plugin}/{}", instance.schema.name),
                kind: instance.schema.kind,
                period: Some(instance.period_ns),
                commands: targets.collect(),
                ..SchemaEntry::default()
            });
        }
        for group in &application.groups {
            let policy = group.policy.name().to_owned();
            let members: Vec<_> = group.members.iter().map(|member| member.index()).collect();
            hierarchy.push_group(&group.name, group.father.map(Id::index), &members, policy);
        }
        hierarchy
    }

    /// Returns the hierarchy of a snapshot, with its places.
    #[must_use]
    pub fn of_snapshot(snapshot: &Snapshot) -> Self {
        let mut hierarchy = Self::default();
        for view in &snapshot.schemas {
            hierarchy.push(SchemaEntry {
                name: view.name.clone(),
                type_name: view.type_name.clone(),
                kind: view.kind,
                ..SchemaEntry::default()
            });
        }
        for view in &snapshot.groups {
            hierarchy.push_group(&view.name, view.father, &view.members, view.policy.clone());
        }
        for (place, view) in snapshot.schemas.iter().enumerate() {
            if let Some(father) = view.father.filter(|_| hierarchy.schemas[place].group.is_none()) {
                hierarchy.set_father(place, father);
            }
        }
        hierarchy
    }

    /// Adds a schema, or takes over what is known of one with this name. Its father and groups follow from groups.
    pub fn describe(&mut self, schema: SchemaEntry) {
        let Some(place) = self.add(&schema.name) else {
            return;
        };
        let known = &mut self.schemas[place];
        *known = SchemaEntry {
            father: known.father,
            group: known.group,
            groups: std::mem::take(&mut known.groups),
            ..schema
        };
    }

    /// Adds a group with its members, which compete in it unless they compete in another one already. Without a father, the
    /// name of the group says which it is: `example/base`. From now on, selections add no members to known groups.
    pub fn describe_group<'n>(
        &mut self,
        name: &str,
        father: Option<&str>,
        members: impl IntoIterator<Item = &'n str>,
    ) -> Option<usize> {
        self.is_complete = true;
        let group = self.add_group(name)?;
        if let Some(father) = father.and_then(|father| self.add(father)) {
            self.set_father_of_group(group, father);
        }
        for member in members {
            if let Some(member) = self.add(member) {
                self.join(group, member);
            }
        }
        Some(group)
    }

    /// Changes what is known of a group.
    pub fn group_mut(&mut self, group: usize) -> Option<&mut Group> {
        self.groups.get_mut(group)
    }

    /// Returns the place of a schema, which is added if it is new; `None` if there are too many.
    pub fn add(&mut self, name: &str) -> Option<usize> {
        if let Some(place) = self.schema_places.get(name) {
            return Some(*place);
        }
        let place = Some(self.schemas.len()).filter(|place| *place < MAX_SCHEMAS)?;
        self.push(SchemaEntry {
            name: name.to_owned(),
            ..SchemaEntry::default()
        });
        for group in 0..self.groups.len() {
            if father_name(&self.groups[group].name) == Some(name) && self.groups[group].father.is_none() {
                self.set_father_of_group(group, place);
            }
        }
        Some(place)
    }

    /// Adds the names of a record.
    pub fn add_names(&mut self, record: &RunRecord) {
        match record {
            RunRecord::Decision(decision) => _ = self.add_decision(decision),
            RunRecord::State(change) => _ = self.add(&change.schema),
            RunRecord::Other(event) => {
                if let Some(schema) = event.what.schema() {
                    self.add(schema);
                }
            }
        }
    }

    /// Returns the place of the group of a selection. New candidates become members, unless the groups are described.
    pub fn add_decision(&mut self, decision: &Decision) -> Option<usize> {
        let is_known = self.group_places.contains_key(&decision.group);
        let group = self.add_group(&decision.group)?;
        if !is_known || !self.is_complete {
            for candidate in &decision.candidates {
                if let Some(member) = self.add(&candidate.name) {
                    self.join(group, member);
                }
            }
        }
        Some(group)
    }

    /// Returns the schemas.
    #[must_use]
    pub fn schemas(&self) -> &[SchemaEntry] {
        &self.schemas
    }

    /// Returns the groups.
    #[must_use]
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Returns the place of a schema.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<usize> {
        self.schema_places.get(name).copied()
    }

    /// Returns the place of a group.
    #[must_use]
    pub fn find_group(&self, name: &str) -> Option<usize> {
        self.group_places.get(name).copied()
    }

    /// Returns the name of a schema, or "nobody" for none.
    #[must_use]
    pub fn name(&self, schema: Option<usize>) -> &str {
        let schema = schema.and_then(|place| self.schemas.get(place));
        schema.map_or("nobody", |schema| &schema.name)
    }

    /// Returns a schema and its fathers, from below.
    pub fn fathers(&self, schema: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(schema), |place| self.schemas.get(*place)?.father)
    }

    /// Returns whether a schema can act: a motor schema without motor children.
    #[must_use]
    pub fn is_actor(&self, schema: usize) -> bool {
        let schema = &self.schemas[schema];
        schema.group.is_some() && schema.groups.is_empty()
    }

    /// Returns the schemas that can act.
    pub fn actors(&self) -> impl Iterator<Item = usize> {
        (0..self.schemas.len()).filter(|schema| self.is_actor(*schema))
    }

    /// Returns whether a schema acts for a robot: it commands the robot, or nobody is known to.
    #[must_use]
    pub fn acts_for(&self, schema: usize, robot: &str) -> bool {
        let commands = |schema: &SchemaEntry| schema.commands.iter().any(|commanded| commanded == robot);
        commands(&self.schemas[schema]) || !self.schemas.iter().any(commands)
    }

    /// Returns the robot that a schema or one of its descendants commands; `None` if unknown.
    #[must_use]
    pub fn robot_of(&self, name: &str) -> Option<&str> {
        let mut pending = vec![self.find(name)?];
        let mut next = 0;
        while let Some(place) = pending.get(next) {
            let schema = &self.schemas[*place];
            if let Some(robot) = schema.commands.first() {
                return Some(robot);
            }
            pending.extend(
                schema
                    .groups
                    .iter()
                    .flat_map(|group| &self.groups[*group].members),
            );
            next += 1;
        }
        None
    }

    fn add_group(&mut self, name: &str) -> Option<usize> {
        if let Some(place) = self.group_places.get(name) {
            return Some(*place);
        }
        let place = Some(self.groups.len()).filter(|place| *place < MAX_SCHEMAS)?;
        self.group_places.insert(name.to_owned(), place);
        self.groups.push(Group {
            name: name.to_owned(),
            ..Group::default()
        });
        if let Some(father) = father_name(name).and_then(|father| self.find(father)) {
            self.set_father_of_group(place, father);
        }
        Some(place)
    }

    /// Adds a schema. Of several with one name, the first is found by it.
    fn push(&mut self, schema: SchemaEntry) {
        let place = self.schemas.len();
        self.schema_places.entry(schema.name.clone()).or_insert(place);
        self.schemas.push(schema);
    }

    /// Adds a group whose members are known.
    fn push_group(&mut self, name: &str, father: Option<usize>, members: &[usize], policy: String) {
        self.is_complete = true;
        let group = self.groups.len();
        self.group_places.entry(name.to_owned()).or_insert(group);
        self.groups.push(Group {
            name: name.to_owned(),
            policy,
            ..Group::default()
        });
        if let Some(father) = father {
            self.set_father_of_group(group, father);
        }
        for member in members {
            self.join(group, *member);
        }
    }

    fn join(&mut self, group: usize, schema: usize) {
        // Nobody competes twice, or below itself.
        let is_free = self
            .schemas
            .get(schema)
            .is_some_and(|known| known.group.is_none());
        let father = self.groups[group].father;
        if !is_free || father.is_some_and(|father| !self.set_father(schema, father)) {
            return;
        }
        (self.schemas[schema].group, self.schemas[schema].kind) = (Some(group), Kind::Motor);
        self.groups[group].members.push(schema);
    }

    /// Makes a schema the father of a group, unless it is below one of the members.
    fn set_father_of_group(&mut self, group: usize, father: usize) {
        let members = self.groups[group].members.clone();
        let is_loop = |member: &usize| self.fathers(father).any(|above| above == *member);
        if father >= self.schemas.len() || self.groups[group].father.is_some() || members.iter().any(is_loop)
        {
            return;
        }
        for member in members {
            self.set_father(member, father);
        }
        self.groups[group].father = Some(father);
        self.schemas[father].groups.push(group);
    }

    /// Makes a schema the father of another one, unless it is below it. Returns whether it is the father now.
    fn set_father(&mut self, schema: usize, father: usize) -> bool {
        if father >= self.schemas.len() || self.fathers(father).any(|above| above == schema) {
            return false;
        }
        self.schemas[schema].father = Some(father);
        true
    }
}

/// The name of the father of a group, from that of the group.
fn father_name(group: &str) -> Option<&str> {
    Some(group.split_once('/')?.0)
}
