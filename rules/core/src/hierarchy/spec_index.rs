//! The fixed part of a hierarchy: the specification, with its links upwards and downwards computed in
//! advance.
//!
//! Lookups only. It refuses to check identifiers: they must be those of a valid specification.

use crate::spec::{GroupId, GroupSpec, Kind, SchemaId, SchemaSpec, Spec};

/// The specification, with its links upwards and downwards computed in advance.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct SpecIndex {
    pub(super) spec: Spec,
    group_of: Vec<Option<GroupId>>,
    position_of: Vec<usize>,
    groups_under: Vec<Vec<GroupId>>,
    roots: Vec<GroupId>,
}

impl SpecIndex {
    pub(super) fn new(spec: Spec) -> Self {
        let mut group_of = vec![None; spec.schemas.len()];
        let mut position_of = vec![0; spec.schemas.len()];
        let mut groups_under = vec![Vec::new(); spec.schemas.len()];
        let mut roots = Vec::new();
        for (index, group) in (0u32..).zip(&spec.groups) {
            let id = GroupId(index);
            match group.father {
                Some(father) => groups_under[father.index()].push(id),
                None => roots.push(id),
            }
            for (position, member) in group.members.iter().enumerate() {
                group_of[member.index()] = Some(id);
                position_of[member.index()] = position;
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
        id.index() < self.spec.schemas.len()
    }

    pub(super) fn schema(&self, id: SchemaId) -> &SchemaSpec {
        &self.spec.schemas[id.index()]
    }

    pub(super) fn kind(&self, id: SchemaId) -> Kind {
        self.schema(id).kind
    }

    pub(super) fn group(&self, id: GroupId) -> &GroupSpec {
        &self.spec.groups[id.index()]
    }

    pub(super) fn members(&self, id: GroupId) -> &[SchemaId] {
        &self.group(id).members
    }

    /// Returns the group in which a schema competes; `None` for an unknown identifier too.
    pub(super) fn group_of(&self, id: SchemaId) -> Option<GroupId> {
        self.group_of.get(id.index()).copied().flatten()
    }

    /// Returns its index in the father's order; 0 for a schema that does not compete.
    pub(super) fn position_of(&self, id: SchemaId) -> usize {
        self.position_of[id.index()]
    }

    pub(super) fn father(&self, id: SchemaId) -> Option<SchemaId> {
        self.group(self.group_of(id)?).father
    }

    pub(super) fn groups_under(&self, id: SchemaId) -> &[GroupId] {
        &self.groups_under[id.index()]
    }

    pub(super) fn root_groups(&self) -> &[GroupId] {
        &self.roots
    }

    pub(super) fn group_ids(&self) -> impl Iterator<Item = GroupId> + use<> {
        (0..u32::try_from(self.spec.groups.len()).unwrap_or(u32::MAX)).map(GroupId)
    }

    pub(super) fn ids_of(&self, kind: Kind) -> impl Iterator<Item = SchemaId> {
        (0u32..)
            .zip(&self.spec.schemas)
            .filter(move |(_, s)| s.kind == kind)
            .map(|(i, _)| SchemaId(i))
    }
}
