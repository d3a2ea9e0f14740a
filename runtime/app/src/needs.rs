//! Which schemas keep each other awake (R6), and the check that perceptive schemas and drivers do not keep
//! each other awake for ever.

use std::collections::HashSet;

use jde_abi::describe::{Kind, Role, Schema};
use jde_core::{SchemaId, Table};

use super::cycle::{Edge, find_cycles, in_words};
use super::drafts::Drafts;
use super::{Binding, ImportSource, InstanceConfig};
use jde_document::section::Text;
use jde_document::{FaultReport, quote};

/// Whether a schema that is bound to this port keeps the port's owner awake. A motor schema is woken by its
/// father alone, and a modulation has its value whether its owner is awake or not.
pub(super) fn keeps_awake(schema: &Schema, port: usize) -> bool {
    schema.kind != Kind::Motor && !matches!(schema.ports[port].role, Role::Modulation { .. })
}

/// Returns the perceptive schemas and drivers that `awake` names; reports other names.
pub(super) fn of_the_roots(report: &mut FaultReport, drafts: &Drafts, awake: &[Text]) -> Vec<SchemaId> {
    let (mut needed, mut known) = (Vec::new(), HashSet::new());
    for name in awake {
        let Some(id) = drafts.find(report, "`awake` of the application", name.text, &name.span) else {
            continue;
        };
        if drafts.schema(id).is_some_and(|schema| schema.kind == Kind::Motor) {
            report
                .fault(
                    &name.span,
                    format!("`awake` names {}, which is a motor schema", drafts.quoted(id)),
                )
                .advise("name it among the `roots`, or as the child of a father");
        } else if known.insert(id) {
            needed.push(id);
        }
    }
    needed
}

/// Reports imports by which perceptive schemas and drivers need each other in a cycle: none of them could ever sleep.
pub(super) fn refuse_cycles(
    report: &mut FaultReport,
    drafts: &Drafts,
    instances: &Table<SchemaId, Option<InstanceConfig>>,
) {
    let edges = instances
        .entries()
        .map(|(id, instance)| {
            let needs = instance
                .as_ref()
                .filter(|instance| instance.schema.kind != Kind::Motor);
            needs.map_or_else(Vec::new, |instance| edges(drafts, id, instance))
        })
        .collect();
    for (cycle, span) in find_cycles(&edges) {
        let names = in_words(&cycle, |id| drafts.list[id].name.to_owned());
        report
            .fault(
                &span,
                format!("these schemas would keep each other awake for ever: {names}"),
            )
            .advise("break the cycle: let one of them read another variable, or none; of a driver, a second one can take what they export");
    }
}

/// Reports schemas that trigger themselves: each value would cause another check at once, which exports the
/// next value. Other cycles of imports are refused above, triggered or not, unless a motor schema is among
/// them: those cause a warning, because only a motor schema that exports in its check makes them endless.
pub(super) fn refuse_self_triggers(
    report: &mut FaultReport,
    drafts: &Drafts,
    instances: &Table<SchemaId, Option<InstanceConfig>>,
) {
    for (id, instance) in instances.entries() {
        let Some(instance) = instance else { continue };
        for (port, binding) in instance.schema.ports.iter().zip(&instance.bindings) {
            let Binding::Import {
                source: Some(ImportSource::Local(provider)),
                trigger: true,
                ..
            } = *binding
            else {
                continue;
            };
            if provider.instance == id
                && matches!(instance.schema.ports[provider.port].role, Role::Export { .. })
            {
                let section = &drafts.list[id].section;
                let span = section.entry_span("imports", &port.name);
                let message = format!(
                    "{} would trigger itself without end: {} is its own export, and triggers it",
                    section.label,
                    quote(&port.name)
                );
                report
                    .fault(&span, message)
                    .advise("bind it to another schema's export, or leave it out of `triggers`");
            }
        }
    }
}

/// Refuses an age limit of an import that reads a modulation, whose value does not age.
pub(super) fn refuse_stale_modulations(
    report: &mut FaultReport,
    drafts: &Drafts,
    instances: &Table<SchemaId, Option<InstanceConfig>>,
) {
    for (id, instance) in instances.entries() {
        let Some(instance) = instance else { continue };
        for (port, binding) in instance.schema.ports.iter().zip(&instance.bindings) {
            let Binding::Import {
                source: Some(ImportSource::Local(provider)),
                stale_ns: Some(_),
                ..
            } = *binding
            else {
                continue;
            };
            let Some(owner) = &instances[provider.instance] else {
                continue;
            };
            let source = &owner.schema.ports[provider.port];
            if matches!(source.role, Role::Modulation { .. }) {
                let span = drafts.list[id].section.entry_span("imports", &port.name);
                let message = format!(
                    "{} has `stale`, and {} is a modulation, whose value does not age",
                    quote(&port.name),
                    quote(&format!("{}.{}", owner.name, source.name))
                );
                report.fault(&span, message).advise("remove `stale`");
            }
        }
    }
}

fn edges(drafts: &Drafts, id: SchemaId, instance: &InstanceConfig) -> Vec<Edge> {
    let section = &drafts.list[id].section;
    let own = instance.schema.ports.len() - instance.listed.len();
    let ports = instance.schema.ports.iter().zip(&instance.bindings);
    ports
        .enumerate()
        .filter_map(|(place, (port, binding))| {
            let Binding::Import {
                source: Some(ImportSource::Local(provider)),
                ..
            } = *binding
            else {
                return None;
            };
            let needed =
                provider.instance != id && keeps_awake(drafts.schema(provider.instance)?, provider.port);
            let listed = place.checked_sub(own).map(|place| &instance.listed[place]);
            let (table, key) = listed.map_or(("imports", &port.name), |listed| {
                (&instance.schema.lists[listed.list].name, &listed.label)
            });
            needed.then(|| (provider.instance, section.entry_span(table, key)))
        })
        .collect()
}
