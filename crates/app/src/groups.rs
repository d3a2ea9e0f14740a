//! Groups: which schemas compete with each other. How they compete is read in `rules`.

use jde_abi::describe::Child;

use super::GroupConfig;
use super::children::NamedChild;
use super::cycle::Edge;
use super::drafts::Drafts;
use super::group_settings::{GroupContext, GroupSettings};
use super::outline::Level;
use super::report::{FaultReport, quote};

/// Returns the group of a level of roots.
pub(super) fn of_roots(
    report: &mut FaultReport,
    drafts: &Drafts,
    level: &Level,
    roots: &[Edge],
) -> GroupConfig {
    let members: Vec<_> = roots.iter().map(|(root, _)| *root).collect();
    let names = members.iter().map(|root| (drafts.get(*root).name, *root));
    let lists = level.name != "roots";
    let among = GroupContext {
        arbitrates: false,
        lists,
        members_noun: if lists { "members" } else { "schemas in `roots`" },
        members: &names.collect::<Vec<_>>(),
    };
    let rules = GroupSettings::read(report, level.section.as_ref(), &among);
    rules.group(level.name.clone(), None, members)
}

/// Returns the groups of one father, in the order in which it names their first members.
pub(super) fn of_father(
    report: &mut FaultReport,
    drafts: &Drafts,
    father: usize,
    kin: &[NamedChild],
) -> Vec<GroupConfig> {
    let Some(schema) = drafts.schema(father) else {
        return Vec::new();
    };
    let section = &drafts.get(father).section;
    let settings = section.section(report, "groups", section.key("groups"));
    let many = schema.children.iter().any(|child| child.many);
    let mut known: Vec<&str> = Vec::new();
    for role in schema.children.iter().filter(|role| role.motor) {
        if !known.contains(&role.group.as_str()) {
            known.push(&role.group);
        }
    }
    if let Some(settings) = &settings {
        for (name, node) in settings.entries().filter(|(name, _)| !known.contains(&name.text)) {
            if many && node.get_ref().get("members").is_some() {
                // None of its members is a child, which has been reported.
                continue;
            }
            let fault = report.fault(
                &name.span,
                format!("{} has no group {}", section.label, quote(name.text)),
            );
            if many {
                fault.advise("say whose it is: members = [...], of its `children`");
            } else {
                fault.suggest(name.text, "groups", known.iter().copied());
            }
        }
    }
    let mut groups = Vec::new();
    for group in known {
        let members: Vec<(&Child, usize)> = kin
            .iter()
            .filter_map(|kin| Some((&schema.children[kin.role?], kin.child)))
            .filter(|(role, _)| role.motor && role.group == group)
            .collect();
        let names: Vec<_> = members
            .iter()
            .map(|(role, child)| (role.name.as_str(), *child))
            .collect();
        let what = format!("group {} of {}", quote(group), section.label);
        let rules = settings
            .as_ref()
            .and_then(|settings| settings.section(report, group, what));
        let among = GroupContext {
            arbitrates: schema.arbitrates,
            lists: many,
            members_noun: "roles of this group",
            members: &names,
        };
        let rules = GroupSettings::read(report, rules.as_ref(), &among);
        if !members.is_empty() {
            let name = format!("{}/{group}", drafts.get(father).name);
            let members = members.into_iter().map(|(_, child)| child).collect();
            groups.push((
                first_member_position(kin, &names),
                rules.group(name, Some(father), members),
            ));
        }
    }
    groups.sort_by_key(|(place, _)| *place);
    groups.into_iter().map(|(_, group)| group).collect()
}

fn first_member_position(kin: &[NamedChild], members: &[(&str, usize)]) -> Option<usize> {
    let (_, first) = members.first()?;
    kin.iter().position(|kin| kin.child == *first)
}
