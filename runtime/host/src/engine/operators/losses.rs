//! What awake schemas lose when an operator stops or unloads what they read from: said, and not refused.
//!
//! It ends no value itself.

use jde_app::{Binding, ImportSource};
use jde_core::Hierarchy;
use jde_records::event::Loss;

use super::{Operators, schema};

impl Operators {
    /// Changes the hierarchy, and returns what awake schemas lost by it if it stopped the instance.
    pub(super) fn with_losses<R>(
        &self,
        hierarchy: &mut Hierarchy,
        instance: usize,
        change: impl FnOnce(&mut Hierarchy) -> R,
    ) -> (R, Vec<Loss>) {
        let was_awake = hierarchy.is_awake(schema(instance));
        let result = change(hierarchy);
        let is_lost = was_awake && hierarchy.is_stopped(schema(instance));
        let losses = if is_lost {
            self.losses(hierarchy, instance)
        } else {
            Vec::new()
        };
        (result, losses)
    }

    /// Returns the imports from an instance of all schemas that are awake and not below it.
    pub(crate) fn losses(&self, hierarchy: &Hierarchy, instance: usize) -> Vec<Loss> {
        let below = hierarchy.subtree(schema(instance));
        let instances = self.application.instances.iter().enumerate();
        let readers = instances.filter(|(reader, _)| {
            let id = schema(*reader);
            *reader != instance && hierarchy.is_awake(id) && !below.contains(&id)
        });
        let imports = readers.flat_map(|(reader, config)| {
            let bound = config.schema.ports.iter().zip(&config.bindings);
            let from_instance = bound.filter(|(_, binding)| match binding {
                Binding::Import {
                    source: Some(ImportSource::Local(provider, _)),
                    ..
                } => *provider == instance,
                Binding::Import { .. }
                | Binding::Export
                | Binding::Modulation { .. }
                | Binding::Command
                | Binding::Actuator { .. }
                | Binding::ChildModulation { .. } => false,
            });
            from_instance.map(move |(port, _)| Loss {
                reader,
                import: port.name.clone(),
            })
        });
        imports.collect()
    }

    /// Returns losses in words: "goon loses its laser".
    pub(crate) fn words(&self, losses: &[Loss]) -> String {
        let words = losses
            .iter()
            .map(|loss| format!("{} loses its {}", self.name(loss.reader), loss.import));
        words.collect::<Vec<_>>().join(", ")
    }
}
