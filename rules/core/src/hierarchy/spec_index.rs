//! The fixed part of a hierarchy: the specification, with its links upwards and downwards computed in
//! advance.
//!
//! Lookups only. It refuses to check identifiers: they must be those of a valid specification.

use crate::spec::{GroupId, GroupSpec, Kind, SchemaId, SchemaSpec, Spec};
use crate::table::Table;

/// The specification, with its links upwards and downwards computed in advance.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct SpecIndex {
    pub(super) spec: Spec,
    group_of: Table<SchemaId, Option<GroupId>>,
    position_of: Table<SchemaId, usize>,
    groups_under: Table<SchemaId, Vec<GroupId>>,
    roots: Vec<GroupId>,
}

impl SpecIndex {
    pub(super) fn new(spec: Spec) -> Self {
        let mut group_of = spec.schemas.map_ids(|_| None);
        let mut position_of = spec.schemas.map_ids(|_| 0);
        let mut groups_under = spec.schemas.map_ids(|_| Vec::new());
        let mut roots = Vec::new();
        for (id, group) in spec.groups.entries() {
            match group.father {
                Some(father) => groups_under[father].push(id),
                None => roots.push(id),
            }
            for (position, member) in group.members.iter().enumerate() {
                group_of[*member] = Some(id);
                position_of[*member] = position;
            }
        }
        Self {
            spec,
            group_of,
            position_of,
            groups_under,
            roots,
        }
    }

    pub(super) fn contains(&self, id: SchemaId) -> bool {
        self.spec.schemas.get(id).is_some()
    }

    pub(super) fn schema(&self, id: SchemaId) -> &SchemaSpec {
        &self.spec.schemas[id]
    }

    pub(super) fn kind(&self, id: SchemaId) -> Kind {
        self.schema(id).kind
    }

    pub(super) fn group(&self, id: GroupId) -> &GroupSpec {
        &self.spec.groups[id]
    }

    pub(super) fn members(&self, id: GroupId) -> &[SchemaId] {
        &self.group(id).members
    }

    /// Returns the group in which a schema competes; `None` for an unknown identifier too.
    pub(super) fn group_of(&self, id: SchemaId) -> Option<GroupId> {
        self.group_of.get(id).copied().flatten()
    }

    /// Returns its index in the father's order; 0 for a schema that does not compete.
    pub(super) fn position_of(&self, id: SchemaId) -> usize {
        self.position_of[id]
    }

    pub(super) fn father(&self, id: SchemaId) -> Option<SchemaId> {
        self.group(self.group_of(id)?).father
    }

    pub(super) fn groups_under(&self, id: SchemaId) -> &[GroupId] {
        &self.groups_under[id]
    }

    pub(super) fn root_groups(&self) -> &[GroupId] {
        &self.roots
    }

    pub(super) fn group_ids(&self) -> impl Iterator<Item = GroupId> + use<> {
        self.spec.groups.ids()
    }

    pub(super) fn ids_of(&self, kind: Kind) -> impl Iterator<Item = SchemaId> {
        let schemas = self.spec.schemas.entries();
        schemas
            .filter(move |(_, schema)| schema.kind == kind)
            .map(|(id, _)| id)
    }
}
