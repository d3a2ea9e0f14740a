//! Groups: which schemas compete with each other. `group_settings` reads how they compete.

use jde_abi::describe::Child;

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
    father: usize,
    children: &[NamedChild],
) -> Vec<GroupConfig> {
    let Some(schema) = drafts.schema(father) else {
        return Vec::new();
    };
    let section = &drafts.list[father].section;
    let sections = section.section(report, "groups", section.key("groups"));
    let many = schema.children.iter().any(|child| child.many);
    let mut known: Vec<&str> = Vec::new();
    for role in schema.children.iter().filter(|role| role.motor) {
        if !known.contains(&role.group.as_str()) {
            known.push(&role.group);
        }
    }
    if let Some(sections) = &sections {
        for (name, node) in sections.entries().filter(|(name, _)| !known.contains(&name.text)) {
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
        let members: Vec<(&Child, usize)> = children
            .iter()
            .filter_map(|child| Some((&schema.children[child.role?], child.child)))
            .filter(|(role, _)| role.motor && role.group == group)
            .collect();
        let names: Vec<_> = members
            .iter()
            .map(|(role, child)| (role.name.as_str(), *child))
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
        if !members.is_empty() {
            let name = format!("{}/{group}", drafts.list[father].name);
            let members = members.into_iter().map(|(_, child)| child).collect();
            groups.push((
                first_member_position(children, &names),
                settings.group(name, Some(father), members),
            ));
        }
    }
    groups.sort_by_key(|(place, _)| *place);
    groups.into_iter().map(|(_, group)| group).collect()
}

fn first_member_position(children: &[NamedChild], members: &[(&str, usize)]) -> Option<usize> {
    let (_, first) = members.first()?;
    children.iter().position(|child| child.child == *first)
}
