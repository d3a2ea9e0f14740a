//! Roles with any number of children: the file names the children, and the father's groups state which
//! compete with each other. Only completes the type for this application; the usual checks decide whether the
//! children fit.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::drafts::{Drafts, refuse_bad_name};
use jde_document::section::{Section, Text};
use jde_document::{FaultReport, quote};

/// Gives every schema whose type has such a role the children that the file names.
pub(super) fn name_children(report: &mut FaultReport, drafts: &mut Drafts) {
    for draft in drafts.list.iter_mut() {
        let Some(found) = &mut draft.resolved else {
            continue;
        };
        let Some(role) = found.schema.children.iter().find(|child| child.many) else {
            continue;
        };
        let own = found.schema.children.iter().filter(|child| !child.many);
        let own: HashSet<&str> = own.map(|child| child.name.as_str()).collect();
        let section = &draft.section;
        let mut names = child_names(section);
        names.retain(|name| !own.contains(name.text));
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
        let (mut children, grouped) = group_members(report, section, &names);
        let rest = names.iter().filter(|name| !grouped.contains_key(name.text));
        children.extend(rest.map(|name| (name.text, role.group.as_str())));
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

/// Returns the children that groups name as members, each with its group: in the file's order, and by name.
fn group_members<'a>(
    report: &mut FaultReport,
    section: &Section<'a>,
    names: &[Text<'a>],
) -> (Vec<(&'a str, &'a str)>, HashMap<&'a str, &'a str>) {
    let (mut children, mut grouped) = (Vec::new(), HashMap::new());
    let Some(groups) = section.get("groups").and_then(|node| node.get_ref().as_table()) else {
        return (children, grouped);
    };
    let known: HashSet<&str> = names.iter().map(|name| name.text).collect();
    let groups = Section::new("", 0..0, groups);
    for (group, node) in groups.entries() {
        let Some(entries) = node.get_ref().as_table() else {
            continue;
        };
        let what = format!("group {} of {}", quote(group.text), section.label);
        refuse_bad_name(report, &group, "a group");
        let settings = Section::new(what, group.span.clone(), entries);
        for member in settings.texts(report, "members").unwrap_or_default() {
            if let Some(other) = grouped.get(member.text) {
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
            } else if known.contains(member.text) {
                children.push((member.text, group.text));
                grouped.insert(member.text, group.text);
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
    (children, grouped)
}
