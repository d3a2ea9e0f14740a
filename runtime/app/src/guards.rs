//! Guards of groups (R18): which schema judges which commands. Refuses schemas that cannot judge, and a guard
//! of no actuator or of several.

use std::collections::{BTreeMap, BTreeSet};

use super::drafts::Drafts;
use super::hierarchy::MAX_DEPTH;
use super::{Application, Binding, GroupConfig, InstanceConfig, InstancePort};
use jde_core::{GroupId, SchemaId, Table};
use jde_document::section::Section;
use jde_document::{FaultReport, quote, quote_all};

/// Returns the schema that a group names as its `guard`.
pub(super) fn named(report: &mut FaultReport, drafts: &Drafts, section: &Section) -> Option<SchemaId> {
    let written = section.text(report, "guard")?;
    let guard = drafts.find(report, &section.key("guard"), written.text, &written.span)?;
    let schema = drafts.schema(guard)?;
    if schema.guard.is_some() {
        return Some(guard);
    }
    let guards = drafts.list.entries();
    let guards: Vec<&str> = guards
        .filter(|(index, _)| drafts.schema(*index).is_some_and(|schema| schema.guard.is_some()))
        .map(|(_, draft)| draft.name)
        .collect();
    let fault = report.fault(
        &written.span,
        format!(
            "{} is {}, whose type {} judges no commands",
            section.key("guard"),
            quote(written.text),
            quote(&schema.name)
        ),
    );
    match guards.as_slice() {
        [] => fault.advise("add a schema whose type is a guard, such as \"guard/footprint\", and name it"),
        guards => fault.advise(format!("name a guard: {}", guards.join(", "))),
    };
    None
}

/// Reports guards in processes of their own, and guards that judge no command of their group, or commands of
/// several actuators: one state describes one robot.
pub(super) fn refuse_mismatches(
    report: &mut FaultReport,
    drafts: &Drafts,
    instances: &Table<SchemaId, Option<InstanceConfig>>,
    groups: &Table<GroupId, GroupConfig>,
) {
    let commands = judged_commands(drafts, instances, groups);
    for (id, group) in groups.entries() {
        let Some((guard, instance)) = group
            .guard
            .and_then(|guard| Some((guard, instances[guard].as_ref()?)))
        else {
            continue;
        };
        let Some(judged) = &instance.schema.guard else {
            continue;
        };
        let section = &drafts.list[guard].section;
        if instance.isolate.is_some() {
            report
                .fault(
                    &section.key_span("isolate"),
                    format!("{} is a guard, and its judgement runs in the host", section.label),
                )
                .advise("remove `isolate`; the schemas that it guards may be isolated");
        }
        let commands = &commands[id];
        if commands.len() == 1 {
            continue;
        }
        let names = commands.iter().map(|command| drafts.quoted_port(*command));
        let what = match names.collect::<Vec<_>>() {
            none if none.is_empty() => String::from("no schema of the group commands one"),
            several => format!("schemas of the group command {}", several.join(" and ")),
        };
        report
            .fault(
                &section.span,
                format!(
                    "the group {} has the guard {}, which judges {}, and {what}",
                    quote(&group.name),
                    quote(&instance.name),
                    judged.command.name
                ),
            )
            .advise("name the guard in the group whose schemas command one robot");
    }
}

impl Application {
    /// Returns the guards of a schema's commands to this command of a driver, from the schema's own group
    /// upwards (R18).
    #[must_use]
    pub fn guards(&self, schema: SchemaId, command: InstancePort) -> Vec<SchemaId> {
        let command = &self.instances[command.instance].schema.ports[command.port].value_type;
        let mut guards = Vec::new();
        let mut next = Some(schema);
        while let Some(group) = next.and_then(|schema| self.instances[schema].group) {
            let GroupConfig { guard, father, .. } = &self.groups[group];
            if let Some(guard) = *guard
                && let Some(judged) = &self.instances[guard].schema.guard
                && judged.command.same_as(command)
                && !guards.contains(&guard)
            {
                guards.push(guard);
            }
            next = *father;
        }
        guards
    }
}

impl Application {
    /// Warns of commands that no guard judges, although a group above their schemas has one: it judges another type.
    pub(super) fn warn_of_unjudged(&self) -> impl Iterator<Item = String> {
        let mut unjudged: BTreeMap<(InstancePort, SchemaId), Vec<SchemaId>> = BTreeMap::new();
        for (schema, instance) in self.instances.entries() {
            for binding in &instance.bindings {
                if let Binding::Actuator {
                    target: Some(command),
                } = binding
                    && self.guards(schema, *command).is_empty()
                    && let Some(guard) = self.nearest_guard(schema)
                {
                    unjudged.entry((*command, guard)).or_default().push(schema);
                }
            }
        }
        unjudged.into_iter().map(|((command, guard), schemas)| {
            let guard = &self.instances[guard];
            let names = schemas.iter().map(|schema| self.instances[*schema].name.as_str());
            let judged = guard.schema.guard.as_ref();
            format!(
                "line {}: no guard judges `{}`, which {} may command: the guard `{}` judges {}",
                self.instances[command.instance].line,
                self.variable_name(command),
                quote_all(names),
                guard.name,
                judged.map_or("nothing", |judged| &judged.command.name)
            )
        })
    }

    /// The guard of the nearest group above a schema that has one.
    fn nearest_guard(&self, schema: SchemaId) -> Option<SchemaId> {
        let mut next = self.instances[schema].group;
        while let Some(group) = next {
            let GroupConfig { guard, father, .. } = &self.groups[group];
            if guard.is_some() {
                return *guard;
            }
            next = father.and_then(|father| self.instances[father].group);
        }
        None
    }
}

/// Returns, for each group, the commands of its schemas, and of those below, that its guard judges.
fn judged_commands(
    drafts: &Drafts,
    instances: &Table<SchemaId, Option<InstanceConfig>>,
    groups: &Table<GroupId, GroupConfig>,
) -> Table<GroupId, BTreeSet<InstancePort>> {
    let judged: Table<GroupId, _> = groups
        .iter()
        .map(|group| drafts.schema(group.guard?)?.guard.as_ref())
        .collect();
    let mut commands = groups.map_ids(|_| BTreeSet::new());
    for (schema, instance) in instances.entries() {
        for binding in instance.iter().flat_map(|instance| &instance.bindings) {
            let Binding::Actuator { target: Some(target) } = *binding else {
                continue;
            };
            let Some(driver) = drafts.schema(target.instance) else {
                continue;
            };
            let command = &driver.ports[target.port].value_type;
            for group in above(instances, groups, schema) {
                if judged[group].is_some_and(|judged| judged.command.same_as(command)) {
                    commands[group].insert(target);
                }
            }
        }
    }
    commands
}

/// The groups in which a schema and its fathers compete, from its own upwards.
fn above(
    instances: &Table<SchemaId, Option<InstanceConfig>>,
    groups: &Table<GroupId, GroupConfig>,
    schema: SchemaId,
) -> impl Iterator<Item = GroupId> {
    let group_of = |schema: SchemaId| instances[schema].as_ref()?.group;
    // A cycle, which is reported elsewhere, has no end.
    std::iter::successors(group_of(schema), move |group| group_of(groups[*group].father?)).take(MAX_DEPTH)
}
