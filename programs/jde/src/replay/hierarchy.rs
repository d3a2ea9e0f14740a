//! The schemas and groups of a recording as the link describes those of an application.

use jde_abi::describe::Kind;
use jde_link::message::{GroupInfo, SchemaInfo, Schemas};
use jde_timeline::Hierarchy;

/// Returns the schemas and groups, as far as they are known.
pub(super) fn schemas(hierarchy: &Hierarchy) -> Schemas {
    let name = |place: usize| hierarchy.name(Some(place)).to_owned();
    let groups = hierarchy.groups();
    Schemas {
        schemas: hierarchy
            .schemas()
            .iter()
            .map(|schema| SchemaInfo {
                type_name: schema.type_name.clone(),
                kind: schema.kind.to_string(),
                father: schema.father.map(name),
                group: schema.group.map(|group| groups[group].name.clone()),
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

/// A schema of which only the name is known.
pub(super) fn unknown_schema(name: &str) -> SchemaInfo {
    SchemaInfo {
        name: name.to_owned(),
        kind: Kind::Perceptive.to_string(),
        ..SchemaInfo::default()
    }
}
