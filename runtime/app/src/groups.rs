//! Groups: which schemas compete with each other. `group_settings` reads how they compete.

use std::collections::HashMap;

use jde_abi::describe::Child;
use jde_core::{Id, SchemaId};

use super::GroupConfig;
use super::children::NamedChild;
use super::cycle::Edge;
use super::drafts::Drafts;
use super::group_settings::{GroupContext, GroupSettings};
use super::outline::Level;
use jde_document::{FaultReport, quote};

/// Returns the group of a level of roots.
pub(super) fn of_roots(
    report: &mut FaultReport,
    drafts: &Drafts,
    level: &Level,
    roots: &[Edge],
) -> GroupConfig {
    let members: Vec<_> = roots.iter().map(|(root, _)| *root).collect();
    let names = members.iter().map(|root| (drafts.list[*root].name, *root));
    let lists = level.name != "roots";
    let context = GroupContext {
        drafts,
        arbitrates: false,
        lists,
        members_noun: if lists { "members" } else { "schemas in `roots`" },
        members: &names.collect::<Vec<_>>(),
    };
    let settings = GroupSettings::read(report, level.section.as_ref(), &context);
    settings.group(level.name.clone(), None, members)
}

/// Returns the groups of one father, in the order in which it names their first members.
pub(super) fn of_father(
    report: &mut FaultReport,
    drafts: &Drafts,
    father: SchemaId,
    children: &[NamedChild],
) -> Vec<GroupConfig> {
    let Some(schema) = drafts.schema(father) else {
        return Vec::new();
    };
    let section = &drafts.list[father].section;
    let sections = section.section(report, "groups", section.key("groups"));
    let many = schema.children.iter().any(|child| child.many);
    let mut known: Vec<&str> = Vec::new();
    // Of each group, the members with their places among the children.
    let mut members: HashMap<&str, Vec<(usize, &Child, SchemaId)>> = HashMap::new();
    for role in schema.children.iter().filter(|role| role.motor) {
        members.entry(&role.group).or_insert_with(|| {
            known.push(&role.group);
            Vec::new()
        });
    }
    for (place, child) in children.iter().enumerate() {
        if let Some(role) = child.role.map(|role| &schema.children[role.index()])
            && let Some(members) = members.get_mut(role.group.as_str()).filter(|_| role.motor)
        {
            members.push((place, role, child.child));
        }
    }
    if let Some(sections) = &sections {
        for (name, node) in sections
            .entries()
            .filter(|(name, _)| !members.contains_key(name.text))
        {
            if many && node.get_ref().get("members").is_some() {
                // None of its members is a child, which has been reported.
                continue;
            }
            let fault = report.fault(
                &name.span,
                format!("{} has no group {}", section.label, quote(name.text)),
            );
            if many {
                fault.advise("list its members: members = [...], of its `children`");
            } else {
                fault.suggest(name.text, "groups", known.iter().copied());
            }
        }
    }
    let mut groups = Vec::new();
    for group in known {
        let members = &members[group];
        let names: Vec<_> = members
            .iter()
            .map(|(_, role, child)| (role.name.as_str(), *child))
            .collect();
        let what = format!("group {} of {}", quote(group), section.label);
        let group_section = sections
            .as_ref()
            .and_then(|sections| sections.section(report, group, what));
        let context = GroupContext {
            drafts,
            arbitrates: schema.arbitrates,
            lists: many,
            members_noun: "roles of this group",
            members: &names,
        };
        let settings = GroupSettings::read(report, group_section.as_ref(), &context);
        if let Some((first, ..)) = members.first() {
            let name = format!("{}/{group}", drafts.list[father].name);
            let members = names.iter().map(|(_, child)| *child).collect();
            groups.push((*first, settings.group(name, Some(father), members)));
        }
    }
    groups.sort_by_key(|(place, _)| *place);
    groups.into_iter().map(|(_, group)| group).collect()
}
