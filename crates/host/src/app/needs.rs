//! Who keeps whom awake (R6), and that perceptive schemas do not keep each other awake for ever.

use jde_abi::describe::{Kind, Role, Schema};

use super::cycle::{Edge, cycles};
use super::drafts::Drafts;
use super::report::Report;
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
