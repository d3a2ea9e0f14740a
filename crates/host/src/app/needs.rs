//! Who keeps whom awake (R6), and that perceptive schemas do not keep each other awake for ever.

use jde_abi::describe::{Kind, Role, Schema};

use toml::Spanned;

use super::cycle::{Edge, cycles};
use super::drafts::Drafts;
use super::report::{Report, quote};
use super::{Binding, Instance, Source};

/// Whether whoever is bound to this port of a schema keeps the schema awake. A motor schema is woken by its father alone,
/// and a modulation has its value whether its owner is awake or not.
pub(super) fn keeps_awake(schema: &Schema, port: usize) -> bool {
    schema.kind != Kind::Motor && !matches!(schema.ports[port].role, Role::Modulation { .. })
}

/// Reports imports by which perceptive schemas need each other in a circle: none of them could ever go to sleep.
pub(super) fn refuse_cycles(report: &mut Report, drafts: &Drafts, instances: &[Option<Instance>]) {
    let edges: Vec<Vec<Edge>> = instances
        .iter()
        .enumerate()
        .map(|(index, instance)| {
            let needs = instance
                .as_ref()
                .filter(|instance| instance.schema.kind != Kind::Motor);
            needs.map_or_else(Vec::new, |instance| edges(drafts, index, instance))
        })
        .collect();
    for (way, span) in cycles(&edges) {
        let names: Vec<_> = way.iter().map(|index| drafts.get(*index).name).collect();
        report
            .fault(
                &span,
                format!(
                    "perceptive schemas would keep each other awake for ever: {}",
                    names.join(" -> ")
                ),
            )
            .advise("break the circle of `imports`");
    }
}

/// Reports schemas that trigger themselves: each value would have them look again at once, and export the next. Who imports from each
/// other in a circle is refused above already, triggered or not, unless a motor schema is among them; that one iterates at its period
/// whatever triggers it (R12), so nothing goes round faster than that.
pub(super) fn refuse_echoes(report: &mut Report, drafts: &Drafts, instances: &[Option<Instance>]) {
    for (index, instance) in instances.iter().enumerate() {
        let Some(instance) = instance else { continue };
        for (port, binding) in instance.schema.ports.iter().zip(&instance.bindings) {
            let Binding::Import {
                source: Some(Source::Here(provider, number)),
                trigger: true,
            } = *binding
            else {
                continue;
            };
            if provider == index && instance.schema.ports[number].role == Role::Export {
                let section = &drafts.get(index).section;
                let written = section
                    .get("imports")
                    .and_then(|node| node.get_ref().get(port.name.as_str()));
                let span = written.map_or_else(|| section.span.clone(), Spanned::span);
                let message = format!(
                    "{} would trigger itself without end: {} is its own export, and triggers it",
                    section.what,
                    quote(&port.name)
                );
                report
                    .fault(&span, message)
                    .advise("bind it to another schema's export, or leave it out of `triggers`");
            }
        }
    }
}

fn edges(drafts: &Drafts, index: usize, instance: &Instance) -> Vec<Edge> {
    let section = &drafts.get(index).section;
    let imports = section.get("imports");
    let ports = instance.schema.ports.iter().zip(&instance.bindings);
    ports
        .filter_map(|(port, binding)| {
            let Binding::Import {
                source: Some(Source::Here(provider, number)),
                ..
            } = *binding
            else {
                return None;
            };
            let needed = provider != index && keeps_awake(drafts.schema(provider)?, number);
            let span = imports.and_then(|node| Some(node.get_ref().get(port.name.as_str())?.span()));
            needed.then(|| (provider, span.unwrap_or_else(|| section.span.clone())))
        })
        .collect()
}
