//! Refuses applications in which two motor schemas could command one actuator and hold authority at the same
//! instant. Requires a hierarchy without cycles.

use std::collections::HashMap;

use super::Binding;
use super::drafts::Drafts;
use super::{GroupConfig, InstanceConfig, InstancePort};
use jde_core::{GroupId, SchemaId, Table};
use jde_document::{FaultReport, quote};

/// By father; `None` stands above all roots.
type Claims = HashMap<Option<SchemaId>, Claim>;

/// The user of the actuator in question at a father, or below it.
#[derive(Clone, Copy)]
enum Claim {
    Itself,
    Below { group: GroupId, user: SchemaId },
}

/// Reports schemas that could command one actuator at the same time, each with one rival. Different members
/// of one group, and everything below them, exclude each other.
pub(super) fn refuse_conflicts(
    report: &mut FaultReport,
    drafts: &Drafts,
    instances: &Table<SchemaId, Option<InstanceConfig>>,
    groups: &Table<GroupId, GroupConfig>,
) {
    let mut claims: HashMap<InstancePort, Claims> = HashMap::new();
    for (user, instance) in instances.entries() {
        let Some(instance) = instance else { continue };
        for (port, binding) in instance.bindings.iter().enumerate() {
            let Binding::Actuator { target: Some(target) } = *binding else {
                continue;
            };
            let claims = claims.entry(target).or_default();
            let Some((rival, why)) = claim(claims, drafts, instances, groups, user) else {
                continue;
            };
            let rival = drafts.quoted(rival);
            let role = &instance.schema.ports[port].name;
            let span = drafts.list[user].section.entry_span("actuators", role);
            let command = drafts.quoted_port(target);
            let user = drafts.quoted(user);
            if rival == user {
                report
                    .fault(
                        &span,
                        format!("{user} commands {command} by two of its actuators"),
                    )
                    .advise("bind each of its actuators to a different command");
            } else {
                report
                    .fault(
                        &span,
                        format!("{rival} and {user} could command {command} at the same time: {why}"),
                    )
                    .advise("bind the command in only one of them, or let them compete in one group");
            }
        }
    }
}

/// Enters a user of the actuator, at itself and at all its fathers. Returns a rival that it does not exclude,
/// and the reason.
fn claim(
    claims: &mut Claims,
    drafts: &Drafts,
    instances: &Table<SchemaId, Option<InstanceConfig>>,
    groups: &Table<GroupId, GroupConfig>,
    user: SchemaId,
) -> Option<(SchemaId, String)> {
    let above = |father: SchemaId| format!("{} is above the other", drafts.quoted(father));
    match claims.insert(Some(user), Claim::Itself) {
        Some(Claim::Itself) => return Some((user, String::new())),
        Some(Claim::Below { user: below, .. }) => return Some((below, above(user))),
        None => {}
    }
    let mut child = user;
    while let Some(group) = instances[child].as_ref().and_then(|instance| instance.group) {
        let father = groups[group].father;
        match claims.get(&father) {
            None => {
                claims.insert(father, Claim::Below { group, user });
            }
            Some(Claim::Itself) => return father.map(|father| (father, above(father))),
            Some(Claim::Below { group: other, .. }) if *other == group => return None,
            Some(Claim::Below {
                group: other,
                user: rival,
            }) => {
                let why = format!(
                    "the groups {} and {} have a winner each",
                    quote(&groups[*other].name),
                    quote(&groups[group].name)
                );
                return Some((*rival, why));
            }
        }
        child = father?;
    }
    None
}
