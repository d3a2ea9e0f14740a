//! Roles with any number of children: the file names the children, and the father's groups state which
//! compete with each other. Only completes the type for this application; the usual checks decide whether the
//! children fit.

use std::sync::Arc;

use super::drafts::{Drafts, refuse_bad_name};
use jde_document::section::{Section, Text};
use jde_document::{FaultReport, quote};

/// Gives every schema whose type has such a role the children that the file names.
pub(super) fn name_children(report: &mut FaultReport, drafts: &mut Drafts) {
    for draft in &mut drafts.list {
        let Some(found) = &mut draft.resolved else {
            continue;
        };
        let Some(role) = found.schema.children.iter().find(|child| child.many) else {
            continue;
        };
        let of_the_type = |name: &str| {
            found
                .schema
                .children
                .iter()
                .any(|child| child.name == name && !child.many)
        };
        let section = &draft.section;
        let mut names = child_names(section);
        names.retain(|name| !of_the_type(name.text));
        if names.is_empty() {
            report
                .fault(
                    &section.key_span("children"),
                    format!("{} has no children to wake", section.label),
                )
                .advise("name them, such as children = { left = \"NAME\", right = \"NAME\" }");
        }
        for name in &names {
            refuse_bad_name(report, name, "a child");
        }
        let mut children = group_members(report, section, &names);
        let rest = names
            .iter()
            .filter(|name| !children.iter().any(|(child, _)| *child == name.text));
        let rest: Vec<_> = rest.map(|name| (name.text, role.group.as_str())).collect();
        children.extend(rest);
        if names.is_empty() {
            continue;
        }
        found.schema = Arc::new(found.schema.with_children(children));
    }
}

/// Returns the names in `children`, if that is a table. Another shape is reported where it is read.
fn child_names<'a>(section: &Section<'a>) -> Vec<Text<'a>> {
    let table = section.get("children").and_then(|node| node.get_ref().as_table());
    let section = table.map(|table| Section::new("", 0..0, table));
    section.map_or_else(Vec::new, |section| {
        section.entries().map(|(name, _)| name).collect()
    })
}

/// Returns the children that groups name as members, each with its group, in the file's order.
fn group_members<'a>(
    report: &mut FaultReport,
    section: &Section<'a>,
    names: &[Text<'a>],
) -> Vec<(&'a str, &'a str)> {
    let mut children: Vec<(&str, &str)> = Vec::new();
    let Some(groups) = section.get("groups").and_then(|node| node.get_ref().as_table()) else {
        return children;
    };
    let groups = Section::new("", 0..0, groups);
    for (group, node) in groups.entries() {
        let Some(entries) = node.get_ref().as_table() else {
            continue;
        };
        let what = format!("group {} of {}", quote(group.text), section.label);
        refuse_bad_name(report, &group, "a group");
        let settings = Section::new(what, group.span.clone(), entries);
        for member in settings.texts(report, "members").unwrap_or_default() {
            let twice = children.iter().find(|(child, _)| *child == member.text);
            if let Some((_, other)) = twice {
                report
                    .fault(
                        &member.span,
                        format!(
                            "{} names {}, which is a member of {} already",
                            settings.key("members"),
                            quote(member.text),
                            quote(other)
                        ),
                    )
                    .advise("a child competes in one group: remove one");
            } else if names.iter().any(|name| name.text == member.text) {
                children.push((member.text, group.text));
            } else {
                report
                    .fault(
                        &member.span,
                        format!(
                            "{} names {}, which is not a child of it",
                            settings.key("members"),
                            quote(member.text)
                        ),
                    )
                    .suggest(member.text, "children", names.iter().map(|name| name.text));
            }
        }
    }
    children
}
