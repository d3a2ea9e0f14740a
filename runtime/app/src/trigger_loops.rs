//! Schemas that trigger each other in a circle: what one exports in its check lets the next one check at once, and so
//! without end. Those without a motor schema are refused, because they would also keep each other awake.

use jde_abi::describe::Role;
use jde_core::SchemaId;

use super::cycle::{Edge, find_cycles, in_words};
use super::{Application, Binding, ImportSource};

impl Application {
    /// Warns of each circle of imports that trigger.
    pub(super) fn warn_of_trigger_loops(&self) -> impl Iterator<Item = String> {
        let edges = self.instances.map_ids(|id| self.triggers(id));
        find_cycles(&edges).into_iter().map(|(circle, _)| {
            let names = in_words(&circle, |id| self.instances[id].name.clone());
            let line = self.instances[circle[0]].line;
            format!(
                "line {line}: these schemas trigger each other: {names}. If each exports in its check, they check without end, for up to \
                 half of the time. Leave one of these imports out of `triggers`"
            )
        })
    }

    /// The schemas whose exports trigger this one.
    fn triggers(&self, id: SchemaId) -> Vec<Edge> {
        let triggering = self.instances[id].bindings.iter().filter_map(|binding| {
            let Binding::Import {
                source: Some(ImportSource::Local(provider)),
                trigger: true,
                ..
            } = *binding
            else {
                return None;
            };
            let role = &self.instances[provider.instance].schema.ports[provider.port].role;
            matches!(role, Role::Export { .. }).then_some((provider.instance, 0..0))
        });
        triggering.collect()
    }
}
